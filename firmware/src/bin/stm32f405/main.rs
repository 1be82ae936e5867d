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
//! # Parameters
//! A configuration that was accepted is stored, and installed again at the next start. Storing it stops the processor
//! for some milliseconds, up to half a second when a sector is full: see [`parameter_flash`].
//!
//! # Limits
//! The internal oscillator, which is the fall-back, is 1 % off; so is the tick then.
#![no_std]
#![no_main]

mod clock;
#[path = "../../hardware/link.rs"]
mod link;
mod parameter_flash;
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
    use firmware::store::{ParameterStore, Parameters};
    use wire::{FRAME_BYTES, Receiver, Request, Response, State};

    use crate::clock;
    use crate::link::{answer, log_change};
    use crate::parameter_flash::ParameterFlash;
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
        store: ParameterStore<ParameterFlash>,
        parameters: Parameters,
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
        let mut control = Control::new();
        let logged = control.state();
        let mut store = ParameterStore::new(ParameterFlash::new(device.FLASH));
        let parameters = restore(&mut store, &mut control);
        let (receiver, frame) = (Receiver::new(), [0; FRAME_BYTES]);
        let local = Local { board, timer, usart, receiver, frame, logged, store, parameters };
        (Shared { control }, local)
    }

    /// Installs the stored configuration, if there is one, and brings its layout up to date.
    fn restore(store: &mut ParameterStore<ParameterFlash>, control: &mut Control) -> Parameters {
        let parameters = store.load().unwrap_or_else(|error| {
            defmt::error!("stored parameters: {}", defmt::Debug2Format(&error));
            Parameters::FACTORY
        });
        match parameters.install() {
            None => defmt::info!("no stored configuration"),
            Some(Ok(order)) => {
                keep(store, control.state(), &parameters);
                control.apply(order);
            }
            Some(Err(refusal)) => defmt::error!("stored configuration: {}", defmt::Debug2Format(&refusal)),
        }
        parameters
    }

    /// Stores a set. That it cannot be stored does not keep it from being used.
    fn keep(store: &mut ParameterStore<ParameterFlash>, state: State, parameters: &Parameters) {
        if let Err(error) = store.save(state, parameters) {
            defmt::error!("parameters are not stored: {}", defmt::Debug2Format(&error));
        }
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

    #[task(
        binds = USART2,
        priority = 1,
        shared = [control],
        local = [usart, receiver, frame, logged, store, parameters]
    )]
    fn link(mut cx: link::Context) {
        let link::LocalResources { usart, receiver, frame, logged, store, parameters, .. } = cx.local;
        let Some(received) = usart.read().and_then(|byte| receiver.push(byte)) else {
            return;
        };
        let tracking = match &received {
            Ok(Request::Configure(configuration)) => Some(configuration.tracking.clone()),
            _ => None,
        };
        let response = answer(received, |order| cx.shared.control.lock(|control| control.apply(order)));
        let state = cx.shared.control.lock(|control| control.state());
        if tracking.is_some() && response == Response::Accepted {
            parameters.tracking = tracking;
            keep(store, state, parameters);
        }
        usart.send(frame, &response);
        log_change(logged, state);
    }
}
