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

use model_core::extension::{ValveLag, ValveLagForm, ValveLagMemory, ValveLagParameters};

use super::delay::delayed;
pub use examine::{BEFORE, BEGUN, examine};
use recording::simulation::SAME_STEP_S;
use recording::unit::Unit;

/// Lags and a delay up to here, together, are those of any proportional regulator, and not named. Unit: s.
pub const ORDINARY_LAG_S: f64 = 0.07;
/// Damping ratios of a lag of the second order: from one that rings on and on to one whose shorter lag is 0.0006 of the longer one.
pub const DAMPING: (f64, f64) = (0.1, 20.0);
/// A command jumps where it moves more than so many times as fast as to the row before and to the next one: a choice. A sine of more than
/// six rows a period never does.
const JUMP: f64 = 2.0;
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
        let mut values = match self.delay_s {
            Some(delay_s) => delayed(command, time_s, delay_s),
            None => command.to_vec(),
        };
        if let Some((form, band)) = self.band {
            let jumps = if form == BandForm::HoldBetween { jumps(time_s, &values) } else { Vec::new() };
            let mut held = values.first().copied().unwrap_or(0.0);
            let mut before = held;
            for (row, value) in values.iter_mut().enumerate() {
                let command = *value;
                let off = command - held;
                (held, *value) = match form {
                    BandForm::Hold | BandForm::HoldBetween if off.abs() < band => (held, held),
                    BandForm::HoldBetween if !jumps[row] => passed(held, band, (before, command)),
                    BandForm::Hold | BandForm::HoldBetween => (command, command),
                    BandForm::Backlash => {
                        let follows = held.clamp(command - 0.5 * band, command + 0.5 * band);
                        (follows, follows)
                    }
                };
                before = command;
            }
        }
        if let Some(supply_bar) = self.supply_bar {
            values.iter_mut().for_each(|value| *value = value.min(supply_bar));
        }
        // What is no lag of a model makes no pressure.
        let Ok(lag) = ValveLag::try_new(&self.lag()) else { return vec![f64::NAN; values.len()] };
        let mut memory = ValveLagMemory::resting(start);
        let (mut last_s, mut known) = (time_s.first().copied().unwrap_or(0.0), (0.0, None));
        for (value, &time_s) in values.iter_mut().zip(time_s) {
            let step_s = time_s - last_s;
            last_s = time_s;
            if (step_s - known.0).abs() > SAME_STEP_S {
                known = (step_s, Some(lag.step(step_s)));
            }
            *value = known.1.map_or(start, |step| step.pressure(&mut memory, *value));
        }
        values
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

/// What a band holds behind a row in which the command goes straight from one value to the other, and its mean over the row.
fn passed(held: f64, band: f64, (before, command): (f64, f64)) -> (f64, f64) {
    let step = band.copysign(command - held);
    let levels = ((command - held) / step) as usize;
    // What is left of the row when the command comes to a level.
    let left = |level: f64| ((command - level) / (command - before)).clamp(0.0, 1.0);
    let mean = held + (1..=levels).map(|level| step * left(held + level as f64 * step)).sum::<f64>();
    (held + levels as f64 * step, mean)
}

/// Whether a command comes to each row by a jump: it moves far faster than before and behind.
fn jumps(time_s: &[f64], command: &[f64]) -> Vec<bool> {
    let speed = |row: usize| {
        let last = row.checked_sub(1)?;
        Some((command.get(row)? - command[last]).abs() / (time_s[row] - time_s[last]))
    };
    let beside = |row: usize| {
        let before = row.checked_sub(1).and_then(speed).unwrap_or(0.0);
        before.max(speed(row + 1).unwrap_or(0.0))
    };
    (0..command.len()).map(|row| speed(row).is_some_and(|speed| speed > JUMP * beside(row))).collect()
}

#[cfg(test)]
mod tests;
