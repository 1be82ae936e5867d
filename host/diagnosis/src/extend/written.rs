//! Which model is written: with the extensions that have shown what they gain, on all samples and on those that took no part in the
//! fit, else the plain one.

use super::heldout::{self, HeldOutGain, on_another};
use super::{Extended, Extension, Plain, seen_from, start};
use crate::Columns;
use crate::causes::Cause;
use crate::fitted::Parameters;
use identification::{self, Termination};

/// The model that is written, beside the plain one. Errors are root mean squares in output unit.
#[derive(Clone, Debug)]
pub struct Written {
    /// The model.
    pub model: Extension,
    /// The same, fitted to the samples before the split alone.
    pub(crate) taught: Extension,
    /// Its answer to the recording's input, a value a sample. Output unit.
    pub simulated: Vec<f64>,
    /// Its error over all scored samples.
    pub rmse: f64,
    /// That of the plain model.
    pub plain_rmse: f64,
    /// What it gains over the plain model on samples that took no part in the fit; nothing where it is that.
    pub gain: HeldOutGain,
    /// Whether it has a valve, and the errors are those from the command.
    pub from_command: bool,
    /// Starts of its search.
    pub starts: usize,
    /// How that ended.
    pub termination: Termination,
}

impl Written {
    /// Whether anything extends the operator.
    pub fn is_extended(&self) -> bool {
        self.model.extensions != Default::default() || self.model.jump.is_some()
    }

    /// What extends the operator, in the order in which the model has it: each by the cause that it stands for, with its parameters in the
    /// units that people measure in.
    pub fn extensions(&self) -> Vec<(Cause, Parameters)> {
        let Some(model) = self.model.simulated() else { return Vec::new() };
        let written = |cause: Cause| Some((cause, cause.written(&model)?));
        let mut all: Vec<(Cause, Parameters)> = Cause::ALL.into_iter().filter_map(written).collect();
        all.sort_by_key(|(cause, _)| cause.about().stage);
        all
    }
}

/// A model fitted to all samples, and the same fitted to those before the split.
#[derive(Clone)]
struct Pair {
    whole: Extension,
    taught: Extension,
}

impl Pair {
    fn without_valve(&self) -> Self {
        let without =
            |model: &Extension| Extension { extensions: model.extensions.without_valve(), ..model.clone() };
        Self { whole: without(&self.whole), taught: without(&self.taught) }
    }

    fn with_valve_of(&self, other: &Self) -> Self {
        let Self { whole, taught } = self.clone();
        Self { whole: whole.with_valve_of(&other.whole), taught: taught.with_valve_of(&other.taught) }
    }

    fn has_valve(&self) -> bool {
        self.whole.extensions != self.whole.extensions.without_valve()
    }
}

impl Extended {
    /// Whether the extensions gain something: over all scored samples, and by more than the standard error on samples that took no
    /// part in the fit.
    pub fn gains(&self, gain: &HeldOutGain) -> bool {
        self.extended_rmse < self.baseline_rmse && gain.is_sure()
    }

    /// The model that is written, by what its extensions gain on samples that took no part in the fit: those of another recording, or
    /// the last third of this one; None where no model runs through them. Of several sets of causes it is the one that predicts
    /// best, whether it is named or not, and of forms too. The input of the columns is the one that the models are judged by.
    pub fn written(&self, columns: &Columns, other: Option<&Columns>) -> Option<Written> {
        let is_tested = other.is_some() || self.counted.split.is_test;
        let others = self.others.iter().filter(|_| is_tested).filter_map(|one| one.alone(columns, other));
        let own = self.alone(columns, other)?;
        let best =
            others.fold(own, |best, one| if one.gain.after.rmse < best.gain.after.rmse { one } else { best });
        // A plain operator fitted to the smoothed input may simulate the measured input worse than one fitted to that.
        let measured = self.of_measured.as_ref().filter(|_| !best.is_extended());
        let measured = measured.and_then(|operator| self.with_operator(operator, columns, other));
        Some(measured.filter(|one| one.rmse < best.rmse).unwrap_or(best))
    }

    /// An operator without extensions in the place of what was found.
    fn with_operator(&self, operator: &Plain, columns: &Columns, other: Option<&Columns>) -> Option<Written> {
        let plain = Pair { whole: self.plain.clone(), taught: self.counted.plain.clone() };
        let pair = Pair { whole: operator.whole.clone(), taught: operator.taught.clone() };
        Some(Written {
            simulated: pair.whole.answer(columns)?,
            rmse: pair.whole.rmse(columns),
            plain_rmse: plain.whole.rmse(columns),
            gain: self.beside((columns, other), false, (&plain, &pair))?,
            from_command: false,
            starts: start::STARTS,
            termination: operator.termination,
            model: pair.whole,
            taught: pair.taught,
        })
    }

    /// The better of the model with its own set and of that without.
    fn alone(&self, columns: &Columns, other: Option<&Columns>) -> Option<Written> {
        let plain = Pair { whole: self.plain.clone(), taught: self.counted.plain.clone() };
        let extended = Pair { whole: self.model.clone(), taught: self.counted.extended.clone() };
        let gains = match other {
            Some(other) => self.gains(&on_another(other, self)?),
            None => self.gains(&self.heldout),
        };
        // Where the input was smoothed, what gains on that may be driven out of all bounds by the noise of the measured one.
        let gains = gains && extended.whole.rmse(columns) < plain.whole.rmse(columns);
        let mut pair = if gains { extended.clone() } else { plain.clone() };
        // What an ordinary valve gains shows from the command.
        if extended.has_valve() && columns.command.is_some() && !self.valve_is_named {
            let without = pair.without_valve();
            let with = without.with_valve_of(&extended);
            let is_sure = |gain: HeldOutGain| gain.is_sure();
            let seen = seen_from(columns, true);
            let is_better = with.whole.rmse(&seen) < without.whole.rmse(&seen)
                && self.beside((columns, other), true, (&without, &with)).is_some_and(is_sure);
            pair = if is_better { with } else { without };
        }
        let from_command = pair.has_valve() && columns.command.is_some();
        let seen = seen_from(columns, from_command);
        Some(Written {
            simulated: pair.whole.answer(columns)?,
            rmse: pair.whole.rmse(&seen),
            plain_rmse: plain.whole.rmse(&seen),
            gain: self.beside((columns, other), from_command, (&plain, &pair))?,
            from_command,
            starts: if gains { start::STARTS } else { identification::STARTS },
            termination: if gains { self.terminations.0 } else { self.terminations.1 },
            model: pair.whole,
            taught: pair.taught,
        })
    }

    /// What one model gains over another on another recording, or on the samples behind the split.
    fn beside(
        &self,
        (columns, other): (&Columns, Option<&Columns>),
        from_command: bool,
        (before, after): (&Pair, &Pair),
    ) -> Option<HeldOutGain> {
        match other {
            Some(other) => heldout::on_all(&seen_from(other, from_command), (&before.whole, &after.whole)),
            None => {
                let columns = seen_from(columns, from_command);
                heldout::gain(
                    &columns,
                    &self.counted.split,
                    (&before.taught, &after.taught),
                    self.heldout.noise_floor,
                )
            }
        }
    }
}
