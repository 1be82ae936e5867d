//! The image of a joint for the emulator (QEMU's `netduinoplus2`, an STM32F405): the control code
//! of two channels in lock-step with a plant on the host.
//!
//! | task | priority | interrupt | runs | deadline |
//! |---|---|---|---|---|
//! | `link_bytes` | 3 | USART2 | moves bytes | none: the host waits |
//! | `tick` | 2 | TIM2, pended by `link` | the control tick on the samples that arrived | none: the host waits |
//! | `link` | 1 | pended by `link_bytes` | answers requests | none: the host waits |
//!
//! As in the image `emulated`, a complete request is the clock, and what computes is the library's
//! ([`firmware::joint`]).
//!
//! # Limits
//! Those of that image; and there is no bus, and nothing is stored. A real board has the image
//! `stm32f405_joint`.
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
    use bsp::link::{LinkBuffers, LinkLine, log_change};
    use bsp::ports;
    use bsp::serial::{self, Mover, Port};
    use firmware::joint::lock_step::LockStepJoint;
    use stm32f4::stm32f405::{Interrupt, USART2};
    use wire::joint::{
        JOINT_VERSION, JointBoardState, JointRequest, JointResponse, JointTickReply, JointTickRequest,
    };
    use wire::{FRAME_BYTES, Protection, Receiver, Refusal};

    /// The emulated port does not time its bits; any clock will do.
    const CLOCK_HZ: u32 = 16_000_000;

    /// What a tick works on and leaves.
    pub struct LockStep {
        joint: LockStepJoint,
        reply: Option<JointTickReply>,
    }

    #[shared]
    struct Shared {
        lock_step: LockStep,
    }

    #[local]
    struct Local {
        link_mover: Mover<USART2, LinkLine>,
        link_port: Port<LinkLine>,
        receiver: Receiver,
        frame: [u8; FRAME_BYTES],
        logged: JointBoardState,
    }

    #[init(local = [link_buffers: LinkBuffers = LinkBuffers::new()])]
    fn init(cx: init::Context) -> (Shared, Local) {
        ports::hold();
        let (link_mover, mut link_port) =
            serial::open(cx.device.USART2, CLOCK_HZ, LinkLine, cx.local.link_buffers);
        let mut joint = LockStepJoint::new(Protection::SIMULATED);
        let mut frame = [0; FRAME_BYTES];
        bsp::link::send(&mut link_port, &mut frame, &joint.answer(&JointRequest::Identify));
        defmt::info!("emulated board of a joint, messages version {=u16}", JOINT_VERSION);
        let logged = joint.task().state();
        let receiver = Receiver::new();
        let local = Local { link_mover, link_port, receiver, frame, logged };
        (Shared { lock_step: LockStep { joint, reply: None } }, local)
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
        cx.shared.lock_step.lock(|LockStep { joint, reply }| *reply = Some(joint.tick()));
    }

    #[task(binds = USART2, priority = 3, local = [link_mover])]
    fn link_bytes(cx: link_bytes::Context) {
        cx.local.link_mover.advance();
    }

    #[task(binds = SPI2, priority = 1, shared = [lock_step], local = [link_port, receiver, frame, logged])]
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
            Ok(JointRequest::Tick(request)) => run_tick(lock_step, &request),
            Ok(request) => lock_step.lock(|shared| shared.joint.answer(&request)),
            Err(_) => JointResponse::Refused(Refusal::Unreadable),
        };
        bsp::link::send(link_port, frame, &response);
        log_change(logged, lock_step.lock(|shared| shared.joint.task().state()));
    }

    /// Lays the samples in and lets the tick's task run, which happens before the next statement.
    fn run_tick(lock_step: &mut impl rtic::Mutex<T = LockStep>, request: &JointTickRequest) -> JointResponse {
        lock_step.lock(|shared| shared.joint.feed(request));
        rtic::pend(Interrupt::TIM2);
        // Without the barriers a pended interrupt may come some instructions later.
        cortex_m::asm::dsb();
        cortex_m::asm::isb();
        let reply = lock_step.lock(|shared| shared.reply.take());
        JointResponse::Tick(reply.expect("the tick's task has the higher priority"))
    }
}
