//! The image for the emulator (QEMU's `netduinoplus2`, an STM32F405): the board's control code in
//! lock-step with a plant on the host.
//!
//! | task | priority | interrupt | runs | deadline |
//! |---|---|---|---|---|
//! | `link_bytes`, `bus_bytes` | 3 | USART2, USART1 | move bytes | none: the host waits |
//! | `tick` | 2 | TIM2, pended by `link` | the control tick on the samples that arrived | none: the host waits |
//! | `link` | 1 | pended by `link_bytes` | answers requests | none: the host waits |
//! | `bus` | 1 | pended by `bus_bytes`, and by `link` behind each tick | Modbus: answers requests | none: the host waits |
//!
//! The emulator has neither a converter nor a timer that keeps time, so samples come by the serial
//! port and a complete request is the clock. What computes is the same as in production: the
//! library's
//! [`firmware::Control`], in the same task, at the same place in the order of priorities.
//!
//! # Limits
//! Time in the emulator means nothing; neither do overruns, which lock-step cannot have. The plant
//! is protected as on a new board, until the host sets other limits. Nothing is kept without power.
//! Logs (defmt) and the exit status leave by semihosting.
#![no_std]
#![no_main]

use bsp::safe_end::SafeEnd;
use defmt_semihosting as _;

/// Ends the emulator with a failure. There is no valve.
enum Failure {}

impl SafeEnd for Failure {
    fn make_safe() {}

    fn end(_: wire::Fault, _: u32) -> ! {
        semihosting::process::exit(1)
    }
}

bsp::end_safely!(Failure);

#[rtic::app(device = stm32f4::stm32f405, peripherals = true)]
mod app {
    use core::sync::atomic::{AtomicU32, Ordering};

    use bsp::bus_port::{BusBuffers, Stamped, serve};
    use bsp::link::{LinkBuffers, LinkLine, answer, log_change};
    use bsp::ports;
    use bsp::serial::{self, Line, Mover, Port};
    use firmware::bus::{Bus, Timing};
    use firmware::control::TickOutcome;
    use firmware::identity::Identity;
    use firmware::lock_step::reply;
    use firmware::node::Node;
    use firmware::store::{Parameters, SaveError};
    use firmware::update::NoImages;
    use firmware::{BlackBox, Capture, Control, LockStepBoard, Order};
    use rtic::Mutex;
    use stm32f4::stm32f405::Interrupt;
    use stm32f4::stm32f405::{USART1, USART2};
    use wire::{FRAME_BYTES, Receiver, Request, Response, State, TickRequest, registers};

    /// The emulated port does not time its bits; any clock will do.
    const CLOCK_HZ: u32 = 16_000_000;
    /// A host's bytes come in bursts. Unit: tick.
    const BUS_SILENCE_TICKS: u32 = 20;

    /// What a tick works on and leaves.
    pub struct LockStep {
        control: Control,
        board: LockStepBoard,
        outcome: Option<TickOutcome>,
    }

    /// Ticks that have run, by which the bus's bytes are timed.
    static TICKS: AtomicU32 = AtomicU32::new(0);

    /// The bus; there is no transceiver.
    pub struct BusLine;

    impl Line for BusLine {
        const BAUD: u32 = registers::BAUD;
        const PORT: Interrupt = Interrupt::USART1;
        const TASK: Interrupt = Interrupt::SPI1;
        const HAS_ECHO: bool = true;
        type Received = Stamped;

        fn received(&self, byte: u8) -> Stamped {
            (byte, TICKS.load(Ordering::Relaxed))
        }
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
        type Images = NoImages;

        fn control<R>(&mut self, work: impl FnOnce(&mut Control) -> R) -> R {
            self.lock_step.lock(|shared| work(&mut shared.control))
        }

        fn parameters(&self) -> &Parameters {
            self.parameters
        }

        fn identity(&self) -> &Identity {
            const { &Identity { unique_id: [0; 6], processor: 0, hardware_revision: 0 } }
        }

        fn keep(&mut self, parameters: Parameters) -> Result<(), SaveError> {
            *self.parameters = parameters;
            Ok(())
        }

        fn images(&mut self) -> Option<&mut NoImages> {
            None
        }
    }

    #[local]
    struct Local {
        link_mover: Mover<USART2, LinkLine>,
        link_port: Port<LinkLine>,
        receiver: Receiver,
        frame: [u8; FRAME_BYTES],
        bus_mover: Mover<USART1, BusLine>,
        bus_port: Port<BusLine>,
        logged: State,
    }

    #[init(local = [
        black_box: BlackBox = BlackBox::new(),
        capture: Capture = Capture::new(),
        link_buffers: LinkBuffers = LinkBuffers::new(),
        bus_buffers: BusBuffers = BusBuffers::new(),
    ])]
    fn init(cx: init::Context) -> (Shared, Local) {
        ports::hold();
        let (link_mover, mut link_port) =
            serial::open(cx.device.USART2, CLOCK_HZ, LinkLine, cx.local.link_buffers);
        let (bus_mover, bus_port) = serial::open(cx.device.USART1, CLOCK_HZ, BusLine, cx.local.bus_buffers);
        let parameters = Parameters::FACTORY;
        let mut control = Control::new(parameters.protection, None, cx.local.black_box, cx.local.capture);
        let mut frame = [0; FRAME_BYTES];
        bsp::link::send(&mut link_port, &mut frame, &control.apply(Order::Identify));
        defmt::info!("emulated board, messages version {=u16}", wire::VERSION);
        let logged = control.state();
        let lock_step = LockStep { control, board: LockStepBoard::new(), outcome: None };
        let receiver = Receiver::new();
        let local = Local { link_mover, link_port, receiver, frame, bus_mover, bus_port, logged };
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
        cx.shared.lock_step.lock(|LockStep { control, board, outcome }| *outcome = Some(control.tick(board)));
    }

    #[task(binds = USART2, priority = 3, local = [link_mover])]
    fn link_bytes(cx: link_bytes::Context) {
        cx.local.link_mover.advance();
    }

    #[task(binds = USART1, priority = 3, local = [bus_mover])]
    fn bus_bytes(cx: bus_bytes::Context) {
        cx.local.bus_mover.advance();
    }

    #[task(binds = SPI2, priority = 1, shared = [lock_step, parameters], local = [link_port, receiver, frame, logged])]
    fn link(mut cx: link::Context) {
        let link::LocalResources { link_port, receiver, frame, logged, .. } = cx.local;
        let lock_step = &mut cx.shared.lock_step;
        if link_port.is_sending() {
            return;
        }
        let Some(received) = bsp::link::next(link_port, receiver) else {
            return;
        };
        let response = match received {
            Ok(Request::Tick(request)) => run_tick(lock_step, request),
            other => answer(other, &mut EmulatedNode { lock_step, parameters: cx.shared.parameters }),
        };
        bsp::link::send(link_port, frame, &response);
        log_change(logged, lock_step.lock(|shared| shared.control.state()));
    }

    #[task(
        binds = SPI1,
        priority = 1,
        shared = [lock_step, parameters],
        local = [bus_port, modbus: Bus = Bus::new(Timing::Ticks(BUS_SILENCE_TICKS))]
    )]
    fn bus(mut cx: bus::Context) {
        let bus::LocalResources { bus_port, modbus, .. } = cx.local;
        let lock_step = &mut cx.shared.lock_step;
        let mut node = EmulatedNode { lock_step, parameters: cx.shared.parameters };
        serve(bus_port, modbus, || TICKS.load(Ordering::Relaxed), &mut node);
    }

    /// Lays the samples in and lets the tick's task run, which happens before the next statement.
    fn run_tick(lock_step: &mut impl rtic::Mutex<T = LockStep>, request: TickRequest) -> Response {
        lock_step.lock(|LockStep { control, board, .. }| board.feed(control, request));
        rtic::pend(Interrupt::TIM2);
        // Without the barriers a pended interrupt may come some instructions later.
        cortex_m::asm::dsb();
        cortex_m::asm::isb();
        let (outcome, ticks) = lock_step.lock(|shared| (shared.outcome.take(), shared.control.ticks()));
        // The bus's silence is counted in ticks.
        TICKS.store(ticks, Ordering::Relaxed);
        rtic::pend(BusLine::TASK);
        Response::Tick(reply(outcome.expect("the tick's task has the higher priority")))
    }
}
