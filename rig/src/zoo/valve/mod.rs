//! Valves: how the command becomes pressure.

mod orifice;
mod second_order;

use crate::draw::Draw;
use crate::effects::{Effects, ValveLag};
use crate::set_point::DeadBand;
use crate::valve::{Regulator, Valve};

/// Which valve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ValveKind {
    /// First-order lag.
    FirstOrder,
    /// Second-order lag.
    SecondOrder,
    /// Orifice flow into the chamber.
    Orifice,
}

impl ValveKind {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::FirstOrder, Self::SecondOrder, Self::Orifice];

    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::FirstOrder => "first_order",
            Self::SecondOrder => "second_order",
            Self::Orifice => "orifice",
        }
    }

    /// One of its kind with what of `effects` is the valve's.
    pub(crate) fn drawn(self, draw: &mut Draw, effects: &Effects) -> Box<dyn Regulator> {
        let (sound_s, damping_ratio) = (draw.log_uniform(0.015, 0.06), draw.uniform(0.7, 1.1));
        let open_bar = draw.uniform(1.0, 3.0);
        let time_constant_s = effects.valve_lag.as_ref().map_or(sound_s, |hidden| hidden.time_constant_s);
        match self {
            Self::FirstOrder => {
                let valve_lag = Some(ValveLag { time_constant_s });
                Box::new(Valve::with(&Effects { valve_lag, ..effects.clone() }, DeadBand::Hold))
            }
            Self::SecondOrder => {
                Box::new(second_order::SecondOrder::new(effects, time_constant_s, damping_ratio))
            }
            Self::Orifice => Box::new(orifice::Orifice::new(effects, time_constant_s, open_bar)),
        }
    }
}
