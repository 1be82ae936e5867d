//! The valve, from command to measured pressure: which of its parts the recording shows.
//!
//! Where both columns are recorded the valve is told apart from the muscle: it is simulated forward and compared at the
//! pressure. A lag is always part of it; its second order, a delay, a dead band and a limit are added while each makes the error clearly
//! smaller. The muscle is then modelled from the measured pressure, whatever the valve does.
//!
//! The lag may be that of air through an orifice, which has another time constant at each pressure.
//!
//! A recording may begin before the valve has come to its first command, so it begins at the first pressure. And it has the command at its
//! rows alone: a band that holds may have accepted others between them.
//!
//! A lag of the second order is not one and a delay: a regulator's spool, or a slow valve behind a regulator's own lag, begins as if it
//! had a dead time.

mod examine;
mod set_points;
mod steps;

use model_core::extension::{ValveLagForm, ValveLagParameters};

pub use examine::{BEFORE, BEGUN, examine};
use recording::unit::Unit;
use set_points::SetPoints;
use steps::{follow, steps};

/// Lags and a delay up to here, together, are those of any proportional regulator, and not named. Unit: s.
pub const ORDINARY_LAG_S: f64 = 0.07;
/// Damping ratios of a lag of the second order: from one that rings on and on to one whose shorter lag is 0.0006 of the longer one.
pub const DAMPING: (f64, f64) = (0.1, 20.0);

/// How a dead band works.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BandForm {
    /// A command nearer than the band to the last accepted one is ignored, any other accepted whole.
    Hold,
    /// The same of a command that goes straight from row to row, where it does not jump: levels at the band's distance are accepted
    /// on the way, which the rows do not have.
    HoldBetween,
    /// The output follows at the distance of half a band.
    Backlash,
}

/// The absolute pressures on either side of an orifice. Unit of the pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orifice {
    /// Before it.
    pub supply: f64,
    /// Outside, where the pressure is 0.
    pub outside: f64,
}

/// A valve's effects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Valve {
    /// How late the pressure is on a ramp, without the delay. Unit: s.
    pub lag_s: f64,
    /// The damping ratio of a lag of the second order: two lags one behind the other from one on. None of one of the first.
    pub damping_ratio: Option<f64>,
    /// The orifice of a valve whose lag has another time constant at each pressure. Such a valve has no damping ratio.
    pub orifice: Option<Orifice>,
    /// Unit: s.
    pub delay_s: Option<f64>,
    /// Unit: bar.
    pub band: Option<(BandForm, f64)>,
    /// Unit: bar.
    pub supply_bar: Option<f64>,
}

/// A part of a valve that is named where the pressure shows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ValvePart {
    /// See [`Valve::delay_s`].
    Delay,
    /// See [`Valve::band`].
    Band,
    /// See [`Valve::supply_bar`].
    Supply,
    /// A lag longer than any regulator's.
    Lag,
}

/// What was found between command and pressure.
#[derive(Clone, Debug)]
pub struct ValveFit {
    /// The valve.
    pub valve: Valve,
    /// The parts that are named, each with the logarithmic gain of having it.
    pub named: Vec<(ValvePart, f64)>,
    /// Root mean square of measured less simulated pressure. Unit of the pressure.
    pub rmse_bar: f64,
    /// The same for a valve that does what it is told at once. Unit of the pressure.
    pub ideal_rmse_bar: f64,
    /// Unit of command and pressure.
    pub unit: Unit,
}

impl Valve {
    /// With a lag only.
    pub fn slow(lag_s: f64) -> Self {
        Self { lag_s, damping_ratio: None, orifice: None, delay_s: None, band: None, supply_bar: None }
    }

    /// The pressure that it makes of a command, from rest at the pressure at the `start`: a recording may begin before the valve has come
    /// to its first command. Unit: bar.
    pub fn simulate(&self, start: f64, time_s: &[f64], command: &[f64]) -> Vec<f64> {
        let mut pressure = SetPoints::of(time_s, command, self.delay_s).through(self.band, self.supply_bar);
        follow(steps(time_s, &self.lag()), start, &mut pressure);
        pressure
    }

    /// Its lag as a model has it.
    pub fn lag(&self) -> ValveLagParameters<f64> {
        let form = match (self.orifice, self.damping_ratio) {
            (Some(Orifice { supply, outside }), _) => ValveLagForm::Orifice { supply, outside },
            (None, Some(damping_ratio)) => ValveLagForm::SecondOrder { damping_ratio },
            (None, None) => ValveLagForm::FirstOrder,
        };
        ValveLagParameters { form, ..ValveLagParameters::new(self.lag_s) }
    }

    /// What a part measures. Unit: s, of the pressure.
    pub fn value(&self, part: ValvePart) -> Option<f64> {
        match part {
            ValvePart::Delay => self.delay_s,
            ValvePart::Band => self.band.map(|(_, band)| band),
            ValvePart::Supply => self.supply_bar,
            ValvePart::Lag => Some(self.longer_lag_s()),
        }
    }

    /// This valve without each of its parts but the lag.
    fn poorer(&self) -> impl Iterator<Item = (ValvePart, Self)> {
        let all = [
            (ValvePart::Delay, Self { delay_s: None, ..*self }),
            (ValvePart::Band, Self { band: None, ..*self }),
            (ValvePart::Supply, Self { supply_bar: None, ..*self }),
        ];
        all.into_iter().filter(|(part, _)| self.value(*part).is_some())
    }

    /// The longer of two lags; of one that rings how late it is on a ramp. Unit: s.
    pub fn longer_lag_s(&self) -> f64 {
        let apart = self.damping_ratio.map_or(1.0, |ratio| (1.0 - ratio.powi(-2)).max(0.0).sqrt());
        if self.damping_ratio.is_some_and(|ratio| ratio < 1.0) {
            self.lag_s
        } else {
            0.5 * self.lag_s * (1.0 + apart)
        }
    }

    /// With a lag of the second order, if it has none yet and is no orifice.
    fn of_second_order(&self) -> Self {
        let damping_ratio = self.damping_ratio.or(self.orifice.is_none().then_some(1.0));
        Self { damping_ratio, ..*self }
    }

    /// Lag and, where they are there, damping, delay, limit and the pressure before an orifice.
    fn smooth(&self) -> Vec<f64> {
        let damping = self.damping_ratio.map(f64::ln);
        let before = self.orifice.map(|orifice| orifice.supply);
        [Some(self.lag_s.ln()), damping, self.delay_s, self.supply_bar, before]
            .into_iter()
            .flatten()
            .collect()
    }

    /// This valve with those; `before`: what the pressure before an orifice is at least and at most.
    fn with_smooth(&self, values: &[f64], step_s: f64, before: (f64, f64)) -> Self {
        let mut values = values.iter().copied();
        let mut next = || values.next().unwrap_or(0.0);
        Self {
            lag_s: next().clamp((0.02 * step_s).ln(), 20.0f64.ln()).exp(),
            damping_ratio: self.damping_ratio.map(|_| next().clamp(DAMPING.0.ln(), DAMPING.1.ln()).exp()),
            delay_s: self.delay_s.map(|_| next().clamp(0.0, 5.0)),
            supply_bar: self.supply_bar.map(|_| next()),
            orifice: self
                .orifice
                .map(|orifice| Orifice { supply: next().clamp(before.0, before.1), ..orifice }),
            ..*self
        }
    }
}

#[cfg(test)]
mod tests;
