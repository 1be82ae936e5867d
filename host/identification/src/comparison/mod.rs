//! Models by sizes on a recording, or on several of one muscle together: Tables 3 and 4 of the
//! paper for any recording.
//!
//! Every model is identified by the same search, from the same seed, and tried on the same held-out
//! rows. One that cannot be made (an extended model without an inverse, say) keeps its row, which
//! says why.

pub mod choice;
mod table;

use std::time::Instant;

use model_core::Kind;

use crate::holdout::{by_others, later_cycles, share_before_others};
use crate::progress::{Tell, within};
use crate::{Fit, IdentificationError, Options, Problem, Weights, identify_several};
use recording::Recording;
use recording::figures::Figures;
use recording::worth::{Limit, Worth};

/// Models on a recording; at least one could be made.
pub struct Comparison<'a> {
    /// What they were identified from; several recordings one behind the other.
    pub recording: &'a Recording,
    /// What they were tried on.
    pub heldout: HeldOut<'a>,
    /// A model each.
    pub rows: Vec<Row>,
}

/// What models are tried on that they have not seen.
#[derive(Clone, Copy, Debug)]
pub enum HeldOut<'a> {
    /// Another recording.
    Recording(&'a Recording),
    /// The later cycles of the recording, by a second model of the first ones ([`crate::holdout`]).
    LaterCycles,
    /// Each of several recordings, by a model of the others.
    EachByOthers,
    /// Nothing.
    Nothing,
}

/// A model, and what has become of it.
pub struct Row {
    /// The model, its sizes and how it was searched.
    pub options: Options,
    /// Duration of the search. Unit: s.
    pub seconds: f64,
    /// The most instructions of a tick on the board with this model; None where that has not been
    /// measured.
    pub tick_instructions: Option<u64>,
    /// The identified model's figures, or why there is none.
    pub outcome: Result<Outcome, IdentificationError>,
}

/// What an identified model is worth.
pub struct Outcome {
    /// On what it was identified from. Output unit.
    pub training: Figures,
    /// On what it was tried on. Output unit.
    pub heldout: Option<Figures>,
    /// How the search ended.
    pub termination: String,
    /// Its output for every row of the recording. Output unit.
    pub simulated: Vec<f64>,
}

impl<'a> Comparison<'a> {
    /// Identifies each model, of all recordings, which `recording` has one behind the other
    /// ([`Recording::joined`]). `tick_instructions` tells the most instructions of a tick on the
    /// board with the model of a name as [`Row::name`] has it; None where that has not been
    /// measured. `progress` is told the share of the work on all models that is done.
    ///
    /// # Errors
    /// That of the first model, if none can be made.
    pub fn of(
        (recordings, recording): (&[Recording], &'a Recording),
        heldout: HeldOut<'a>,
        models: &[Options],
        tick_instructions: fn(&str) -> Option<u64>,
        progress: Tell<'_>,
    ) -> Result<Self, IdentificationError> {
        let mut rows = Vec::new();
        let work: Vec<f64> = models.iter().map(|options| heldout.work(recordings, options)).collect();
        let (all, mut before) = (work.iter().sum::<f64>(), 0.0);
        for (options, work) in models.iter().zip(work) {
            let progress = within(progress, [before / all, (before + work) / all]);
            let row = Row::of((recordings, recording), heldout, options, &progress);
            rows.push(Row { tick_instructions: tick_instructions(&row.name()), ..row });
            before += work;
        }
        match rows.first() {
            Some(Row { outcome: Err(error), .. }) if rows.iter().all(|row| row.outcome.is_err()) => {
                Err(error.clone())
            }
            _ => Ok(Self { recording, heldout, rows }),
        }
    }

    /// Whether there are figures of what the models have not seen.
    pub fn has_heldout(&self) -> bool {
        self.made().any(|(_, outcome)| outcome.heldout.is_some())
    }

    /// The models that could be made, with what they are worth.
    pub fn made(&self) -> impl Iterator<Item = (&Row, &Outcome)> {
        self.rows.iter().filter_map(|row| Some((row, row.outcome.as_ref().ok()?)))
    }

    /// The model of the smallest root mean square error: held out, if there is such a figure.
    pub fn best(&self) -> Option<(&Row, &Outcome)> {
        self.made().min_by(|(_, one), (_, other)| one.judged().rmse.total_cmp(&other.judged().rmse))
    }
}

impl HeldOut<'_> {
    /// Units of the work on a model.
    fn work(self, recordings: &[Recording], options: &Options) -> f64 {
        let scored = |recording: &Recording| recording.drive.scored.iter().filter(|&&scored| scored).count();
        crate::work(recordings.iter().map(scored).sum(), options) / self.share_before(recordings, options)
    }

    /// The share of the work on a model that is done before it is tried on what is held out.
    fn share_before(self, recordings: &[Recording], options: &Options) -> f64 {
        match self {
            Self::LaterCycles | Self::EachByOthers => share_before_others(recordings, options),
            Self::Recording(_) | Self::Nothing => 1.0,
        }
    }

    fn figures(
        self,
        fit: &Fit,
        (all, recording): (&[Problem<'_>], &Recording),
        options: &Options,
        progress: Tell<'_>,
    ) -> Option<Figures> {
        match self {
            Self::Recording(other) => {
                Some(other.figures(&crate::simulate(&fit.model, &other.drive.input.values)))
            }
            Self::LaterCycles => later_cycles(recording, options, progress).map(|later| later.figures),
            Self::EachByOthers => {
                by_others(all, options, progress).map(|simulated| recording.figures(&simulated))
            }
            Self::Nothing => None,
        }
    }
}

impl Row {
    fn of(
        (recordings, recording): (&[Recording], &Recording),
        heldout: HeldOut<'_>,
        options: &Options,
        progress: Tell<'_>,
    ) -> Self {
        let begin = Instant::now();
        let share = heldout.share_before(recordings, options);
        let all: Vec<Problem<'_>> = recordings.iter().map(Problem::from).collect();
        let fit = identify_several(&all, options, &within(progress, [0.0, share]));
        let seconds = begin.elapsed().as_secs_f64();
        let trying = within(progress, [share, 1.0]);
        let outcome = fit.map(|fit| Outcome {
            training: recording.figures(&fit.simulated),
            heldout: heldout.figures(&fit, (&all, recording), options, &trying),
            termination: fit.termination.to_string(),
            simulated: fit.simulated,
        });
        Self { options: *options, seconds, tick_instructions: None, outcome }
    }

    /// The model's name, see [`Options::form`].
    pub fn model(&self) -> String {
        self.options.form()
    }

    /// Number of dead zones of a model that has them.
    pub fn dead_zones(&self) -> Option<usize> {
        has_dead_zones(self.options.model).then_some(self.options.dead_zones)
    }

    /// Name and sizes, see [`Options::name`].
    pub fn name(&self) -> String {
        self.options.name()
    }
}

impl Options {
    /// The model's name, with [`PIECEWISE_LINEAR`] and [`FREE_WEIGHTS`] at its end where it has
    /// them.
    pub fn form(&self) -> String {
        let envelope = if self.knots.is_some() { PIECEWISE_LINEAR } else { "" };
        let weights = if self.weights == Weights::Free { FREE_WEIGHTS } else { "" };
        format!("{}{envelope}{weights}", self.model)
    }

    /// Name and sizes: `mgpi 10/10`, `sgpi 10`.
    pub fn name(&self) -> String {
        let sizes = match has_dead_zones(self.model) {
            true => format!("{}/{}", self.plays, self.dead_zones),
            false => self.plays.to_string(),
        };
        format!("{} {sizes}", self.form())
    }
}

impl Outcome {
    /// What the model is worth that was identified from a recording.
    pub fn worth(&self, recording: &Recording) -> Worth {
        let heldout = self.heldout.as_ref();
        let limit = Limit::of(recording, &self.training, heldout);
        Worth::from_figures(&self.training, heldout, recording.stroke(), limit)
    }

    /// The figures that models are chosen by.
    fn judged(&self) -> &Figures {
        self.heldout.as_ref().unwrap_or(&self.training)
    }
}

/// The end of the names of models with a piecewise-linear envelope.
pub const PIECEWISE_LINEAR: &str = "-pl";

/// The end of the names of models whose plays have free weights; it comes last.
pub const FREE_WEIGHTS: &str = "-free";

/// Whether a model has dead zones, and so a number of them.
///
/// ```
/// use identification::comparison::has_dead_zones;
/// use model_core::Kind;
///
/// assert_eq!(Kind::ALL.map(has_dead_zones), [false, false, false, true, false, true]);
/// ```
pub fn has_dead_zones(kind: Kind) -> bool {
    matches!(kind, Kind::Mpi | Kind::Mgpi)
}
