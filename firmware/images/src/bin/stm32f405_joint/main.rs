//! The production image of a joint for the STM32F405: two channels, for the place A of the flash,
//! with the starter before it: what a debugger flashes.
//!
//! | task | priority | raised by | does | deadline |
//! |---|---|---|---|---|
//! | `low_voltage` | 4 | PVD, the voltage detector | vents both valves | at once |
//! | `link_bytes` | 3 | USART2 | moves a byte | a byte time, 21 µs |
//! | `tick` | 2 | SysTick, each millisecond | samples, controls, drives both valves, feeds the watchdog | half a period, else counted as late |
//! | `link` | 1 | `link_bytes`, and the supervisor | answers requests | none: they wait in a queue |
//! | supervisor | 0 | - | status light, log; looks whether the link runs | 250 ticks |
//!
//! What drives the board, what it begins with and how it ends is that of the image of one channel
//! (`bsp`); what it does is `firmware::joint`, as in the emulator; what it is told is
//! `wire::joint`.
//!
//! # Safety
//! As of the image of one channel. Whatever vents one of both valves vents the other at the same
//! time: by the tick, by the interrupt of low voltage, by what ends the program, and by a reset.
//!
//! # Parameters
//! Settings and a joint that were accepted are stored, and taken again behind the next start, as
//! those of the image of one channel are; nothing is driven by that.
//!
//! # Limits
//! No bus: number, registers and updates over it are those of the image of one channel.
#![no_std]
#![no_main]

use defmt_rtt as _;
use firmware::watchdog::CheckIns;
use wire::image::BoardKind;

/// Where the tasks check in.
static CHECK_INS: CheckIns = CheckIns::new();

bsp::end_by_restart!();
bsp::put_head!(BoardKind::Joint);
bsp::put_starter!();

#[rtic::app(device = stm32f4::stm32f405, peripherals = true)]
mod app {
    use core::sync::atomic::AtomicBool;

    use bsp::link::{LinkBuffers, LinkLine, answer_of_joint, log_change};
    use bsp::ports;
    use bsp::serial::{self, Line, Mover, Port};
    use bsp::stm32f405::flash::Flash;
    use bsp::stm32f405::joint::SensorsAndValves;
    use bsp::stm32f405::pins::{self, DumpValve, Light, VoltageDetector};
    use bsp::stm32f405::scan::Scan;
    use bsp::stm32f405::scan::joint::JointScan;
    use bsp::stm32f405::stored::Stored;
    use bsp::stm32f405::tick::{TICKS_PER_SECOND, Tick};
    use bsp::stm32f405::watchdog::HardwareWatchdog;
    use bsp::stm32f405::{memory, start};
    use firmware::joint::{JointNode, JointTask, recall};
    use firmware::led;
    use firmware::store::{JointParameters, SaveError};
    use firmware::watchdog::{Task, Watchdog};
    use rtic::Mutex;
    use stm32f4::stm32f405::USART2;
    use wire::joint::{BoardJointParameters, JOINT_VERSION, JointBoardState, JointRequest};
    use wire::{FRAME_BYTES, Fault, Protection, Receiver};

    use super::CHECK_INS;

    #[shared]
    struct Shared {
        joint: JointTask,
    }

    /// What is kept without power.
    type Kept = Stored<JointParameters, 1>;

    /// What the link works on.
    struct Node<'a, J> {
        joint: J,
        kept: &'a mut Kept,
    }

    impl<'a, J: Mutex<T = JointTask>> Node<'a, J> {
        /// The first one, which `init` has not the stack for, takes what was stored.
        fn new(joint: J, kept: &'a mut Kept) -> Self {
            let is_to_be_taken = kept.is_to_be_taken();
            let mut node = Self { joint, kept };
            if is_to_be_taken {
                node.take();
            }
            node
        }

        // Not inlined: its callers would need the stack all the time.
        #[inline(never)]
        fn take(&mut self) {
            let kept = self.kept.parameters().clone();
            recall(self, &kept);
        }
    }

    impl<J: Mutex<T = JointTask>> JointNode for Node<'_, J> {
        fn task<R>(&mut self, work: impl FnOnce(&mut JointTask) -> R) -> R {
            self.joint.lock(work)
        }

        fn keep(&mut self, request: &JointRequest) -> Result<(), SaveError> {
            let Some(changed) = self.kept.parameters().changed_by(request) else { return Ok(()) };
            let state = self.joint.lock(|joint| joint.state());
            self.kept.keep(state, changed)
        }

        fn control(&self) -> Option<&BoardJointParameters> {
            self.kept.parameters().control.as_ref()
        }
    }

    /// Takes what is stored out of the flash; a fault where that cannot be read.
    // Not inlined: `init` would need the stack all the time.
    #[inline(never)]
    fn load(flash: Flash, sending: &'static AtomicBool, joint: &mut JointTask) -> Kept {
        let (mut kept, failure) = Kept::load(flash, [sending], &CHECK_INS);
        if let Some(error) = failure {
            joint.report_of_board(error.fault());
        }
        // As in the image of one channel: a new flash is erased, and what is not readable replaced.
        // Where that fails, the host of the next save is told.
        let _ = kept.save(joint.state());
        kept
    }

    #[local]
    struct Local {
        board: SensorsAndValves,
        clock: Tick,
        watchdog: Watchdog,
        hardware_watchdog: HardwareWatchdog,
        voltage: VoltageDetector,
        dump: DumpValve,
        link_mover: Mover<USART2, LinkLine>,
        link_port: Port<LinkLine>,
        kept: Kept,
        light: Light,
        logged: JointBoardState,
    }

    #[init(local = [link_buffers: LinkBuffers = LinkBuffers::new()])]
    fn init(cx: init::Context) -> (Shared, Local) {
        ports::hold();
        let device = cx.device;
        let started =
            start::begin(&device.RCC, device.IWDG, device.PWR, device.FLASH, &device.EXTI, &device.DBGMCU);
        let clocks = started.clocks;
        defmt::info!("board of a joint, messages version {=u16}, {}", JOINT_VERSION, clocks);
        pins::route(&device.GPIOA, &device.GPIOB, &device.GPIOC, started.is_sound());
        pins::route_second(&device.GPIOA, &device.GPIOC);
        let scan = JointScan::new(device.ADC1, &device.ADC_COMMON, device.DMA2, &device.DBGMCU);
        let board = SensorsAndValves::vented(scan, device.DAC);
        Scan::start(&device.TIM2, &clocks, TICKS_PER_SECOND);
        let clock = Tick::start(cx.core.SYST, clocks.core_hz);
        let mut joint =
            JointTask::on_board(Protection::STANDARD, clock.clock(), memory::black_box(started.reset));
        let [latched, known] = started.faults();
        for fault in latched.into_iter().flatten() {
            joint.report_of_board(fault);
        }
        for fault in known.into_iter().flatten() {
            joint.note(fault);
        }
        let start::Started { hardware_watchdog, voltage, flash, .. } = started;
        let (link_mover, link_port) =
            serial::open(device.USART2, clocks.slow_bus_hz, LinkLine, cx.local.link_buffers);
        let kept = load(flash, link_port.sending, &mut joint);
        let logged = joint.state();
        let local = Local {
            board,
            clock,
            watchdog: Watchdog::default(),
            hardware_watchdog,
            voltage,
            dump: DumpValve::default(),
            link_mover,
            link_port,
            kept,
            light: Light,
            logged,
        };
        (Shared { joint }, local)
    }

    /// The supervisor. The tick wakes it.
    #[idle(shared = [joint], local = [light, logged])]
    fn supervise(mut cx: supervise::Context) -> ! {
        let supervise::LocalResources { light, logged, .. } = cx.local;
        ports::release();
        loop {
            CHECK_INS.check_in(Task::Supervisor);
            rtic::pend(LinkLine::TASK);
            let (state, fault, ticks) =
                cx.shared.joint.lock(|joint| (joint.state(), joint.fault(), joint.ticks()));
            light.set(led::is_lit_of_joint(state, fault, ticks));
            log_change(logged, state);
            cortex_m::asm::wfi();
        }
    }

    #[task(binds = SysTick, priority = 2, shared = [joint], local = [board, clock, watchdog, hardware_watchdog, voltage, dump])]
    fn tick(mut cx: tick::Context) {
        let tick::LocalResources { board, clock, watchdog, hardware_watchdog, voltage, dump, .. } = cx.local;
        cx.shared.joint.lock(|joint| {
            if voltage.is_low() {
                joint.report_of_board(Fault::BrownOut);
            }
            joint.hear_stop(pins::is_stop_open());
            joint.hear_coil(pins::has_coil_voltage());
            joint.tick(board);
            // Once more: the interrupt may have come before the write of the valves, which then has
            // not driven them. So the dump valve opens in this tick, not in the next.
            if voltage.is_low() {
                joint.report_of_board(Fault::BrownOut);
            }
            // Behind the write of the valves, which need not wait for what takes many ticks.
            if watchdog.is_content(&CHECK_INS) {
                hardware_watchdog.feed(joint.state().is_driven());
            } else {
                joint.report_of_board(Fault::TaskSilent);
            }
            joint.close_tick(clock.end());
            dump.tick(joint.keeps_dump_closed());
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

    // What is large never passes over the stack of `init`.
    #[task(
        binds = SPI2,
        priority = 1,
        shared = [joint],
        local = [
            link_port,
            kept,
            receiver: Receiver = Receiver::new(),
            frame: [u8; FRAME_BYTES] = [0; FRAME_BYTES],
        ]
    )]
    fn link(cx: link::Context) {
        let link::LocalResources { link_port, kept, receiver, frame, .. } = cx.local;
        CHECK_INS.check_in(Task::Link);
        let mut node = Node::new(cx.shared.joint, kept);
        if !link_port.is_sending()
            && let Some(received) = bsp::link::next(link_port, receiver)
        {
            bsp::link::send(link_port, frame, &answer_of_joint(received, &mut node));
        }
    }
}
