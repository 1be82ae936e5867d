//! The image for the emulator (QEMU's `netduinoplus2`, an STM32F405): the board's control code in lock-step with a
//! plant on the host.
//!
//! | task | priority | interrupt | runs | deadline |
//! |---|---|---|---|---|
//! | `tick` | 2 | TIM2, pended by `link` | the control tick on the samples that arrived | none: the host waits |
//! | `link` | 1 | USART2 | receives bytes, answers requests | none: the host waits |
//! | `bus` | 1 | USART1, and pended by `link` behind each tick | Modbus: receives bytes, answers | none: the host waits |
//!
//! The emulator has neither a converter nor a timer that keeps time, so samples come by the serial port and a
//! complete request is the clock. What computes is the same as in production: the library's
//! [`firmware::Control`], in the same task, at the same place in the order of priorities.
//!
//! # Limits
//! Time in the emulator means nothing; neither do overruns, which lock-step cannot have. The plant is protected as on a new
//! board, until the host sets other limits.
//! Nothing is kept without power. Logs (defmt) and the exit status leave by semihosting.
#![no_std]
#![no_main]

#[path = "../../hardware/bus_port.rs"]
mod bus_port;
#[path = "../../hardware/link.rs"]
mod link;
#[path = "../../hardware/ports.rs"]
mod ports;
#[path = "../../hardware/safe_end.rs"]
mod safe_end;
#[path = "../../hardware/usart.rs"]
mod usart;

use defmt_semihosting as _;

/// There is no valve.
fn make_safe() {}

/// Ends the emulator with a failure.
fn end(_: wire::Fault, _: u32) -> ! {
    semihosting::process::exit(1)
}

#[rtic::app(device = stm32f4::stm32f405, peripherals = true)]
mod app {
    use firmware::bus::Bus;
    use firmware::node::Node;
    use firmware::store::{Parameters, SaveError};
    use firmware::{BlackBox, Capture, Control, LockStepBoard, Order};
    use rtic::Mutex;
    use stm32f4::stm32f405::Interrupt;
    use wire::{FRAME_BYTES, Receiver, Request, Response, State, TickReply, TickRequest};

    use crate::bus_port::{BusPort, DriverEnable};
    use crate::link::{answer, log_change};
    use crate::ports;
    use crate::usart::Usart;

    /// The emulated port does not time its bits; any clock will do.
    const CLOCK_HZ: u32 = 16_000_000;
    /// A host's bytes come in bursts. Unit: tick.
    const BUS_SILENCE_TICKS: u32 = 20;

    /// What a tick works on and leaves.
    pub struct LockStep {
        control: Control,
        board: LockStepBoard,
        reply: Option<TickReply>,
    }

    /// There is no transceiver.
    pub struct NoDriver;

    impl DriverEnable for NoDriver {
        fn set(&mut self, _: bool) {}
    }

    #[shared]
    struct Shared {
        lock_step: LockStep,
        #[lock_free]
        parameters: Parameters,
    }

    /// What link and bus work on.
    struct EmulatedNode<'a, L> {
        lock_step: &'a mut L,
        parameters: &'a mut Parameters,
    }

    impl<L: Mutex<T = LockStep>> Node for EmulatedNode<'_, L> {
        fn control<R>(&mut self, work: impl FnOnce(&mut Control) -> R) -> R {
            self.lock_step.lock(|shared| work(&mut shared.control))
        }

        fn parameters(&self) -> &Parameters {
            self.parameters
        }

        fn keep(&mut self, parameters: Parameters) -> Result<(), SaveError> {
            *self.parameters = parameters;
            Ok(())
        }
    }

    #[local]
    struct Local {
        usart: Usart,
        receiver: Receiver,
        frame: [u8; FRAME_BYTES],
        bus_port: BusPort<NoDriver>,
        logged: State,
    }

    #[init(local = [
        black_box: BlackBox = BlackBox::new(),
        capture: Capture = Capture::new(),
    ])]
    fn init(cx: init::Context) -> (Shared, Local) {
        ports::hold();
        let mut usart = Usart::new(cx.device.USART2, CLOCK_HZ);
        let parameters = Parameters::FACTORY;
        let mut control = Control::new(parameters.protection, None, cx.local.black_box, cx.local.capture);
        let mut frame = [0; FRAME_BYTES];
        usart.send(&mut frame, &control.apply(Order::Identify));
        defmt::info!("emulated board, messages version {=u16}", wire::VERSION);
        let logged = control.state();
        let lock_step = LockStep { control, board: LockStepBoard::new(), reply: None };
        let bus_port = BusPort::new(cx.device.USART1, CLOCK_HZ, NoDriver);
        let local = Local { usart, receiver: Receiver::new(), frame, bus_port, logged };
        (Shared { lock_step, parameters }, local)
    }

    /// Sleeps between bytes: a processor that spins takes the host's time from the plant.
    #[idle]
    fn idle(_: idle::Context) -> ! {
        ports::release();
        loop {
            cortex_m::asm::wfi();
        }
    }

    #[task(binds = TIM2, priority = 2, shared = [lock_step])]
    fn tick(mut cx: tick::Context) {
        cx.shared.lock_step.lock(|LockStep { control, board, reply }| *reply = Some(control.tick(board)));
    }

    #[task(binds = USART2, priority = 1, shared = [lock_step, parameters], local = [usart, receiver, frame, logged])]
    fn link(mut cx: link::Context) {
        let link::LocalResources { usart, receiver, frame, logged, .. } = cx.local;
        let lock_step = &mut cx.shared.lock_step;
        let Some(received) = usart.read().and_then(|byte| receiver.push(byte)) else {
            return;
        };
        let response = match received {
            Ok(Request::Tick(request)) => run_tick(lock_step, request),
            other => answer(other, &mut EmulatedNode { lock_step, parameters: cx.shared.parameters }),
        };
        usart.send(frame, &response);
        log_change(logged, lock_step.lock(|shared| shared.control.state()));
    }

    #[task(
        binds = USART1,
        priority = 1,
        shared = [lock_step, parameters],
        local = [bus_port, modbus: Bus = Bus::new(BUS_SILENCE_TICKS)]
    )]
    fn bus(mut cx: bus::Context) {
        let bus::LocalResources { bus_port, modbus, .. } = cx.local;
        // In this order: the last byte's echo is there before its end is, and nobody has sent it.
        let byte = bus_port.read();
        bus_port.go_on();
        if !bus_port.is_sending() {
            let lock_step = &mut cx.shared.lock_step;
            let mut node = EmulatedNode { lock_step, parameters: cx.shared.parameters };
            let tick = node.control(|control| control.ticks());
            bus_port.send(modbus.take(byte, tick, &mut node));
        }
    }

    /// Lays the samples in and lets the tick's task run, which happens before the next statement.
    fn run_tick(lock_step: &mut impl rtic::Mutex<T = LockStep>, request: TickRequest) -> Response {
        lock_step.lock(|LockStep { control, board, .. }| board.feed(control, request));
        rtic::pend(Interrupt::TIM2);
        // Without the barriers a pended interrupt may come some instructions later.
        cortex_m::asm::dsb();
        cortex_m::asm::isb();
        // The bus's silence is counted in ticks.
        rtic::pend(Interrupt::USART1);
        let reply = lock_step.lock(|shared| shared.reply.take());
        Response::Tick(reply.expect("the tick's task has the higher priority"))
    }
}
