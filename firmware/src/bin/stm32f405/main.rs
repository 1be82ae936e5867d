//! The production image for the STM32F405.
//!
//! | task | priority | interrupt | runs | deadline |
//! |---|---|---|---|---|
//! | `tick` | 2 | TIM2, each millisecond | sample, control, drive the valve | before the next, 1 ms; else an overrun is counted |
//! | `link` | 1 | USART2 | receives bytes, answers requests | a byte time, 21 µs, while a request arrives |
//!
//! A tick takes some tens of microseconds and may delay `link` by that; the port's two bytes of buffer cover it.
//! `link` holds the control's lock only to carry out an order that it has prepared before.
//!
//! # Pins
//! | pin | function |
//! |---|---|
//! | PA0 | ADC1 channel 0: pressure |
//! | PA1 | ADC1 channel 1: contraction |
//! | PA2, PA3 | USART2, sending and receiving |
//! | PA4 | DAC channel 1: set point of the valve |
//!
//! # Safety
//! The valve's output is the vented code from the first instructions of `init` on; the control drives it only while
//! tracking. Every wait for the hardware is bounded: a clock that does not start is replaced by the internal one, a
//! conversion that does not end is a latched fault. Panics and faults of the processor end in [`safe_end`], vented.
//!
//! # Limits
//! The internal oscillator, which is the fall-back, is 1 % off; so is the tick then.
#![no_std]
#![no_main]

mod clock;
#[path = "../../hardware/link.rs"]
mod link;
mod peripherals;
#[path = "../../hardware/safe_end.rs"]
mod safe_end;
mod tick_timer;
#[path = "../../hardware/usart.rs"]
mod usart;

use defmt_rtt as _;

/// Stays, so that the converter keeps the valve vented; a reset would let its output float.
fn end() -> ! {
    loop {
        cortex_m::asm::nop();
    }
}

#[rtic::app(device = stm32f4::stm32f405, peripherals = true)]
mod app {
    use firmware::Control;
    use wire::{FRAME_BYTES, Receiver, State};

    use crate::clock;
    use crate::link::{answer, log_change};
    use crate::peripherals::{SensorsAndValve, route_pins};
    use crate::tick_timer::TickTimer;
    use crate::usart::Usart;

    #[shared]
    struct Shared {
        control: Control,
    }

    #[local]
    struct Local {
        board: SensorsAndValve,
        timer: TickTimer,
        usart: Usart,
        receiver: Receiver,
        frame: [u8; FRAME_BYTES],
        logged: State,
    }

    #[init]
    fn init(cx: init::Context) -> (Shared, Local) {
        let device = cx.device;
        clock::feed_peripherals(&device.RCC);
        let board = SensorsAndValve::vented(device.DAC, device.ADC1, &device.ADC_COMMON);
        route_pins(&device.GPIOA);
        let clocks = clock::start(&device.RCC, &device.FLASH);
        defmt::info!("valve board, messages version {=u16}, {}", wire::VERSION, clocks);
        let usart = Usart::new(device.USART2, clocks.slow_bus_hz);
        let timer = TickTimer::start(device.TIM2, clocks.timer_hz);
        let control = Control::new();
        let logged = control.state();
        let local = Local { board, timer, usart, receiver: Receiver::new(), frame: [0; FRAME_BYTES], logged };
        (Shared { control }, local)
    }

    #[task(binds = TIM2, priority = 2, shared = [control], local = [board, timer])]
    fn tick(mut cx: tick::Context) {
        let tick::LocalResources { board, timer, .. } = cx.local;
        timer.acknowledge();
        cx.shared.control.lock(|control| {
            control.tick(board);
            if timer.is_due() {
                control.note_overrun();
            }
        });
    }

    #[task(binds = USART2, priority = 1, shared = [control], local = [usart, receiver, frame, logged])]
    fn link(mut cx: link::Context) {
        let link::LocalResources { usart, receiver, frame, logged, .. } = cx.local;
        let Some(received) = usart.read().and_then(|byte| receiver.push(byte)) else {
            return;
        };
        let response = answer(received, |order| cx.shared.control.lock(|control| control.apply(order)));
        usart.send(frame, &response);
        log_change(logged, cx.shared.control.lock(|control| control.state()));
    }
}
