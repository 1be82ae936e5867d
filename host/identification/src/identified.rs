//! A model of a recording, or of several of one muscle, with what it does on samples that took no
//! part in it: what `mgpi identify` writes, and `Identifier.fit` of the Python package.
//!
//! Of one recording the second half of the cycles is held out, answered by a model of the first
//! ([`later_cycles`]). Of several, each is answered by a model of the others. The model that is
//! kept is always that of everything.

use std::time::Instant;

use model_core::ExtensionParameters;

use crate::holdout::{Later, by_others, later_cycles, share_before_others};
use crate::progress::{Tell, within};
use crate::{Fit, IdentificationError, Options, Problem, identify_several, simulate};
use recording::Recording;
use recording::model_file::{HeldOut, Identification, ModelFile};
use recording::table::DataError;

/// What a model is tried on.
#[derive(Clone, Copy, Debug)]
pub enum Trial<'a> {
    /// Nothing.
    Nothing,
    /// A part of the recordings, answered by a model of the others.
    Part,
    /// Another recording.
    Another(&'a Recording),
}

/// An identified model.
#[derive(Clone, Debug)]
pub struct Identified {
    /// The model, as it is written.
    pub model: ModelFile,
    /// How it was identified.
    pub identification: Identification,
    /// The fit to all recordings.
    pub fit: Fit,
    /// All recordings, one behind the other.
    pub recording: Recording,
    /// The recordings that it was tried on, of which the held-out samples are scored, and what the
    /// models answer, a value a sample, output unit. None where it was not tried.
    pub tried: Option<(Recording, Vec<f64>)>,
    /// How long the search for the model took. Unit: s.
    pub seconds: f64,
}

/// Why there is no model.
#[derive(Debug)]
pub enum NotIdentified {
    /// The recordings are none of one muscle.
    Data(DataError),
    /// No model can be made of them; boxed, since it carries a recording's name.
    Identification(Box<(Recording, IdentificationError)>),
}

/// Identifies a model of all recordings, each of which begins from rest, and tries it.
///
/// # Errors
/// The recordings do not go together ([`Recording::joined`]); see [`IdentificationError`].
pub fn identified(
    recordings: &[Recording],
    options: &Options,
    trial: Trial<'_>,
    progress: Tell<'_>,
) -> Result<Identified, NotIdentified> {
    let joined = Recording::joined(recordings).map_err(NotIdentified::Data)?;
    let fails = |error| NotIdentified::Identification(Box::new((joined.clone(), error)));
    let all: Vec<Problem<'_>> = recordings.iter().map(Problem::from).collect();
    let share = match trial {
        Trial::Part => share_before_others(recordings, options),
        Trial::Nothing | Trial::Another(_) => 1.0,
    };
    let begin = Instant::now();
    let fit = identify_several(&all, options, &within(progress, [0.0, share])).map_err(fails)?;
    let seconds = begin.elapsed().as_secs_f64();
    let trying = within(progress, [share, 1.0]);
    let (tried, heldout) = match trial {
        Trial::Nothing => (None, None),
        Trial::Another(other) => {
            let simulated = simulate(&fit.model, &other.drive.input.values);
            let heldout = HeldOut {
                recording: other.source(),
                from_s: None,
                by_recording: false,
                figures: other.figures(&simulated),
            };
            (Some((other.clone(), simulated)), Some(heldout))
        }
        Trial::Part => on_a_part(&joined, &all, options, &trying).unzip(),
    };
    let errors = fit.uncertainty.estimates.iter();
    let errors =
        errors.filter_map(|estimate| Some((estimate.parameter.name.clone(), estimate.standard_error?)));
    let termination = fit.termination.to_string();
    let identification = Identification {
        recording: recordings[0].source(),
        further: recordings[1..].iter().map(Recording::source).collect(),
        ..Identification::of(&joined, &fit.simulated, heldout, fit.starts, termination, errors.collect())
    };
    let model = ModelFile {
        input: joined.drive.input.channel.clone(),
        output: joined.output.channel.clone(),
        density: fit.density,
        parameters: fit.parameters.clone(),
        extensions: ExtensionParameters::default(),
        model: fit.model.clone(),
        identification: Some(identification.clone()),
        recorded: None,
        tuning: None,
    };
    Ok(Identified { model, identification, fit, recording: joined, tried, seconds })
}

/// What models of a part answer to the rest; None where a part is too short for the model.
fn on_a_part(
    joined: &Recording,
    all: &[Problem<'_>],
    options: &Options,
    progress: Tell<'_>,
) -> Option<((Recording, Vec<f64>), HeldOut)> {
    let of = |recording: &Recording, simulated: &[f64], from_s| HeldOut {
        recording: joined.source(),
        from_s,
        by_recording: all.len() > 1,
        figures: recording.figures(simulated),
    };
    if let [_] = all {
        let Later { from_s, simulated, scored, .. } = later_cycles(joined, options, progress)?;
        let later = joined.with_scored(scored);
        let heldout = of(&later, &simulated, Some(from_s));
        return Some(((later, simulated), heldout));
    }
    let simulated = by_others(all, options, progress)?;
    let heldout = of(joined, &simulated, None);
    Some(((joined.clone(), simulated), heldout))
}
