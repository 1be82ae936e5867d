//! The program of the production image.
//!
//! | task | priority | raised by | does | deadline |
//! |---|---|---|---|---|
//! | `low_voltage` | 4 | PVD, the voltage detector | vents | at once |
//! | `link_bytes` | 3 | USART2 | moves a byte | a byte time, 21 µs |
//! | `bus_bytes` | 3 | USART1 | moves a byte, tells the time of it, switches the bus's driver | a byte time, 87 µs; the driver a bit, 8 µs |
//! | `tick` | 2 | SysTick, each millisecond | samples, controls, drives the valve, feeds the watchdog | half a period, else counted as late |
//! | `link` | 1 | `link_bytes`, and the supervisor | answers requests | none: they wait in a queue |
//! | `bus` | 1 | `bus_bytes`, and the supervisor | Modbus: answers requests | none: they wait in a queue |
//! | supervisor | 0 | - | status light, log; looks whether link and bus run | 250 ticks |
//!
//! A tick takes some tens of microseconds, and a byte of each port delays it by some 80
//! instructions. `link` and `bus` hold the control's lock only to copy from it, or to carry out an
//! order that was prepared before. While one of the two prepares a configuration the other's
//! requests wait; before one of the two stores it, what the other is sending leaves.
//!
//! # Safety
//! The valve's output is the vented code from before the program proper starts; the control drives
//! it in the states that say so. The dump valve opens unless each tick keeps it closed. Every wait
//! for the hardware is bounded, the tick has none: a crystal that does not start is replaced, a
//! conversion that does not end is a fault. What ends the program vents, seals the record and
//! resets; what starts then is at fault until it is acknowledged. A program or a memory that is
//! damaged starts with both outputs held in reset.
//!
//! # Parameters
//! A configuration and limits that were accepted are stored, and taken again behind the next start.
//! Storing them stops the processor for some milliseconds, up to half a second when a sector is
//! full: see `bsp::stm32f405::flash`. A new image over the bus: see `firmware::update`.
//!
//! # Limits
//! The internal oscillator, which is the fall-back, is 1 % off; so is the tick then.

use core::sync::atomic::AtomicBool;

use bsp::stm32f405::image;
use defmt_rtt as _;
use firmware::watchdog::CheckIns;

/// Where the tasks check in.
static CHECK_INS: CheckIns = CheckIns::new();
/// Whether the board's slot on the bus is near: it begins between two ticks.
static IS_SLOT_NEAR: AtomicBool = AtomicBool::new(false);

bsp::end_by_restart!();
bsp::put_head!(image::ONE_CHANNEL);

#[rtic::app(device = stm32f4::stm32f405, peripherals = true)]
mod app {
    use core::sync::atomic::{AtomicBool, Ordering};

    use bsp::bus_port::{BusBuffers, Stamped, serve};
    use bsp::link::{LinkBuffers, LinkLine, answer, log_change};
    use bsp::ports;
    use bsp::serial::{self, Line, Mover, Port};
    use bsp::stm32f405::flash::Flash;
    use bsp::stm32f405::pins::{self, BusDriver, DumpValve, Light, VoltageDetector};
    use bsp::stm32f405::scan::Scan;
    use bsp::stm32f405::start::{self, Started};
    use bsp::stm32f405::stored::Stored;
    use bsp::stm32f405::tick::{TICKS_PER_SECOND, Tick, moment_us};
    use bsp::stm32f405::watchdog::HardwareWatchdog;
    use bsp::stm32f405::{SensorsAndValve, memory, output};
    use firmware::bus::{Bus, Timing};
    use firmware::identity::Identity;
    use firmware::node::{Node, apply};
    use firmware::noise::Noise;
    use firmware::store::{Parameters, SaveError};
    use firmware::watchdog::{Task, Watchdog};
    use firmware::{Capture, Control, TickClock, led};
    use rtic::Mutex;
    use stm32f4::stm32f405::{Interrupt, USART1, USART2};
    use wire::{FRAME_BYTES, Fault, Protection, Receiver, Response, State, registers};

    use super::{CHECK_INS, IS_SLOT_NEAR};

    /// The bus, its transceiver's driver switched by this.
    pub struct BusLine(BusDriver);

    impl Line for BusLine {
        const BAUD: u32 = registers::BAUD;
        const PORT: Interrupt = Interrupt::USART1;
        const TASK: Interrupt = Interrupt::SPI1;
        const HAS_ECHO: bool = true;
        type Received = Stamped;

        fn received(&self, byte: u8) -> Stamped {
            (byte, moment_us())
        }

        fn drive(&mut self, drives: bool) {
            self.0.set(drives);
        }
    }

    #[shared]
    struct Shared {
        control: Control,
        #[lock_free]
        kept: Kept,
    }

    /// What is kept without power, and which board it is.
    pub struct Kept {
        stored: Stored<Parameters, 2>,
        identity: Identity,
    }

    impl Kept {
        /// What is stored, its layout brought up to date.
        // Not inlined: `init` would need the stack all the time.
        #[inline(never)]
        fn load(
            flash: Flash,
            identity: Identity,
            sending: [&'static AtomicBool; 2],
            control: &mut Control,
        ) -> Self {
            let (mut stored, failure) = Stored::<Parameters, 2>::load(flash, sending, &CHECK_INS);
            if let Some(error) = failure {
                control.report(error.fault());
            }
            if let Some(calibration) = &stored.parameters().calibration {
                control.recall(calibration);
            }
            // What is not brought up to date is brought up to date by the next save, whose host is
            // told.
            let _ = stored.save(control.state());
            Self { stored, identity }
        }
    }

    /// What link and bus work on.
    struct BoardNode<'a, C> {
        control: C,
        kept: &'a mut Kept,
    }

    impl<'a, C: Mutex<T = Control>> BoardNode<'a, C> {
        /// Whichever task comes first behind `init`, which has not the stack for it, takes what was
        /// stored.
        fn new(control: C, kept: &'a mut Kept) -> Self {
            let mut node = Self { control, kept };
            if node.kept.stored.is_to_be_taken() {
                node.take();
            }
            node
        }

        // Not inlined: its callers would need the stack all the time. A request at a time, for the
        // same reason.
        #[inline(never)]
        fn take(&mut self) {
            for index in 0.. {
                let request = self.kept.stored.parameters().requests().nth(index);
                let Some(request) = request else { break };
                if let Response::Refused(refusal) = apply(self, &request) {
                    defmt::error!("stored parameters: {}", defmt::Debug2Format(&refusal));
                    self.control.lock(|control| control.report(Fault::ConfigurationCorrupt));
                }
            }
        }
    }

    impl<C: Mutex<T = Control>> Node for BoardNode<'_, C> {
        type Images = Flash;

        fn control<R>(&mut self, work: impl FnOnce(&mut Control) -> R) -> R {
            self.control.lock(work)
        }

        fn parameters(&self) -> &Parameters {
            self.kept.stored.parameters()
        }

        fn identity(&self) -> &Identity {
            &self.kept.identity
        }

        fn keep(&mut self, parameters: Parameters) -> Result<(), SaveError> {
            let state = self.control.lock(|control| control.state());
            self.kept.stored.keep(state, parameters)
        }

        fn images(&mut self) -> Option<&mut Flash> {
            Some(self.kept.stored.flash_mut())
        }
    }

    #[local]
    struct Local {
        board: SensorsAndValve,
        clock: Tick,
        watchdog: Watchdog,
        hardware_watchdog: HardwareWatchdog,
        voltage: VoltageDetector,
        dump: DumpValve,
        link_mover: Mover<USART2, LinkLine>,
        link_port: Port<LinkLine>,
        bus_mover: Mover<USART1, BusLine>,
        bus_port: Port<BusLine>,
        light: Light,
        logged: State,
        /// Of pressure and contraction.
        noise: [Noise; 2],
        /// The tick whose conversions were looked at last.
        noise_tick: u32,
    }

    #[init(local = [
        capture: Capture = Capture::new(),
        link_buffers: LinkBuffers = LinkBuffers::new(),
        bus_buffers: BusBuffers = BusBuffers::new(),
    ])]
    fn init(cx: init::Context) -> (Shared, Local) {
        ports::hold();
        let device = cx.device;
        let started =
            start::begin(&device.RCC, device.IWDG, device.PWR, device.FLASH, &device.EXTI, &device.DBGMCU);
        let clocks = started.clocks;
        defmt::info!("valve board, messages version {=u16}, {}", wire::VERSION, clocks);
        pins::route(&device.GPIOA, &device.GPIOB, &device.GPIOC, started.is_sound());
        let valve = output::vented(device.DAC, device.TIM3, clocks.timer_hz);
        let board = SensorsAndValve::new(
            Scan::new(device.ADC1, &device.ADC_COMMON, device.DMA2, &device.DBGMCU),
            valve,
        );
        Scan::start(&device.TIM2, &clocks, TICKS_PER_SECOND);
        let clock = Tick::start(cx.core.SYST, clocks.core_hz);
        let mut control = control_of(&started, clock.clock(), cx.local.capture);
        let Started { hardware_watchdog, voltage, flash, .. } = started;
        let (link_mover, link_port) =
            serial::open(device.USART2, clocks.slow_bus_hz, LinkLine, cx.local.link_buffers);
        let bus_line = BusLine(BusDriver::listening(device.GPIOA));
        let (bus_mover, bus_port) =
            serial::open(device.USART1, clocks.fast_bus_hz, bus_line, cx.local.bus_buffers);
        let sending = [link_port.sending, bus_port.sending];
        let kept = Kept::load(flash, memory::identity(&device.DBGMCU), sending, &mut control);
        let logged = control.state();
        let local = Local {
            board,
            clock,
            watchdog: Watchdog::default(),
            hardware_watchdog,
            voltage,
            dump: DumpValve::default(),
            link_mover,
            link_port,
            bus_mover,
            bus_port,
            light: Light,
            logged,
            noise: [Noise::default(); 2],
            noise_tick: 0,
        };
        (Shared { control, kept }, local)
    }

    /// The control, with what the start has found.
    // Not inlined: `init` would need the stack all the time.
    #[inline(never)]
    fn control_of(started: &Started, clock: TickClock, capture: &'static mut Capture) -> Control {
        let black_box = memory::black_box(started.reset);
        let mut control = Control::new(Protection::STANDARD, Some(clock), black_box, capture);
        let [latched, known] = started.faults();
        for fault in latched.into_iter().flatten() {
            control.report(fault);
        }
        for fault in known.into_iter().flatten() {
            control.note(fault);
        }
        control
    }

    /// The supervisor. The tick wakes it.
    #[idle(shared = [control], local = [light, logged, noise, noise_tick])]
    fn supervise(mut cx: supervise::Context) -> ! {
        let supervise::LocalResources { light, logged, noise, noise_tick, .. } = cx.local;
        ports::release();
        loop {
            CHECK_INS.check_in(Task::Supervisor);
            rtic::pend(LinkLine::TASK);
            rtic::pend(BusLine::TASK);
            let codes = noise.each_ref().map(Noise::codes);
            let (state, fault, ticks) = cx.shared.control.lock(|control| {
                control.hear_noise(codes);
                (control.state(), control.fault(), control.ticks())
            });
            if ticks != core::mem::replace(noise_tick, ticks) {
                noise.iter_mut().zip(&Scan::conversions()).for_each(|(noise, codes)| noise.take(codes));
            }
            light.set(led::is_lit(state, fault, ticks));
            log_change(logged, state);
            // Near a slot the bus looks at the time again and again, for a tick and a half at most.
            if !IS_SLOT_NEAR.load(Ordering::Relaxed) {
                cortex_m::asm::wfi();
            }
        }
    }

    #[task(binds = SysTick, priority = 2, shared = [control], local = [board, clock, watchdog, hardware_watchdog, voltage, dump])]
    fn tick(mut cx: tick::Context) {
        let tick::LocalResources { board, clock, watchdog, hardware_watchdog, voltage, dump, .. } = cx.local;
        cx.shared.control.lock(|control| {
            if voltage.is_low() {
                control.report(Fault::BrownOut);
            }
            control.hear_stop(pins::is_stop_open());
            control.hear_coil(pins::has_coil_voltage());
            control.tick(board);
            // Once more: the interrupt may have come before the write of the valve, which then has
            // not driven it. So the dump valve opens in this tick, not in the next.
            if voltage.is_low() {
                control.report(Fault::BrownOut);
            }
            // Behind the write of the valve, which need not wait for what takes many ticks.
            if watchdog.is_content(&CHECK_INS) {
                hardware_watchdog.feed(control.state().is_driven());
            } else {
                control.report(Fault::TaskSilent);
            }
            control.close_tick(clock.end());
            dump.tick(control.keeps_dump_closed());
        });
        clock.finish();
    }

    #[task(binds = PVD, priority = 4)]
    fn low_voltage(_: low_voltage::Context) {
        pins::on_low_voltage();
    }

    #[task(binds = USART2, priority = 3, local = [link_mover])]
    fn link_bytes(cx: link_bytes::Context) {
        cx.local.link_mover.advance();
    }

    #[task(binds = USART1, priority = 3, local = [bus_mover])]
    fn bus_bytes(cx: bus_bytes::Context) {
        cx.local.bus_mover.advance();
    }

    // What is large never passes over the stack of `init`, which a stored configuration needs.
    #[task(
        binds = SPI2,
        priority = 1,
        shared = [control, kept],
        local = [
            link_port,
            receiver: Receiver = Receiver::new(),
            frame: [u8; FRAME_BYTES] = [0; FRAME_BYTES],
        ]
    )]
    fn link(cx: link::Context) {
        let link::LocalResources { link_port, receiver, frame, .. } = cx.local;
        CHECK_INS.check_in(Task::Link);
        let mut node = BoardNode::new(cx.shared.control, cx.shared.kept);
        if !link_port.is_sending()
            && let Some(received) = bsp::link::next(link_port, receiver)
        {
            bsp::link::send(link_port, frame, &answer(received, &mut node));
        }
    }

    #[task(
        binds = SPI1,
        priority = 1,
        shared = [control, kept],
        local = [bus_port, modbus: Bus = Bus::new(Timing::Microseconds)]
    )]
    fn bus(cx: bus::Context) {
        let bus::LocalResources { bus_port, modbus, .. } = cx.local;
        let mut node = BoardNode::new(cx.shared.control, cx.shared.kept);
        serve(bus_port, modbus, moment_us, &mut node);
        IS_SLOT_NEAR.store(modbus.is_slot_near(moment_us()), Ordering::Relaxed);
    }
}
