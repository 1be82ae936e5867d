//! From named causes to an extended model that runs free, and what it gains on data that its fit has not seen.
//!
//! # Design
//! | file | what it does |
//! |---|---|
//! | `carry` | from the effects of the search to the nearest extensions of the model |
//! | `start` | the operator to begin with, identified from what the operators see in the search |
//! | `variables` | operator and extensions as numbers that a search can move |
//! | `refine` | all of them together by Levenberg-Marquardt, on the residual of the model that runs free |
//! | [`heldout`] | the gain on rows that took no part in the fit |
//!
//! # Contract
//! The models have seen nothing of the output but the scored rows before the split, when they are compared behind it; then
//! they go on from there with all rows. The model without extensions is fitted in the same way, of the same size.
//!
//! # Limits
//! The causes themselves were chosen on the whole recording; a gain that is free of that too takes another recording.

mod carry;
pub mod heldout;
mod refine;
mod start;
mod variables;

use model_core::ExtensionParameters;

use super::Columns;
use super::search::{Candidate, Search};
use super::signals::root_mean_square;
use super::valve::ValveFit;
use crate::identification::{Density, HostExtendedModel, HostParameters};
use crate::simulation::Rows;
pub use heldout::HeldOutGain;
use refine::Task;

/// The share of the scored rows that the compared models are fitted to.
const TAUGHT: f64 = 2.0 / 3.0;

/// An operator with extensions.
#[derive(Clone, Debug)]
pub struct Extension {
    /// The operator.
    pub parameters: HostParameters,
    /// What its plays come from.
    pub density: Density,
    /// What the muscle does beside hysteresis.
    pub extensions: ExtensionParameters<f64>,
}

/// A model extended by the named causes, and the same without.
#[derive(Clone, Debug)]
pub struct Extended {
    /// With the extensions.
    pub model: Extension,
    /// Its free-running answer, a value a row of the recording. Output unit.
    pub simulated: Vec<f64>,
    /// Without.
    pub plain: Extension,
    /// Its answer.
    pub plain_simulated: Vec<f64>,
    /// Root mean square error without, over the scored rows.
    pub baseline_rmse: f64,
    /// The same with the extensions.
    pub extended_rmse: f64,
    /// What it gains behind the split, by models of the rows before.
    pub heldout: HeldOutGain,
}

impl Extension {
    /// The free-running answer to a recording, a value a row; from a measured pressure without the valve. None where the
    /// model refuses a row. Output unit.
    pub fn answer(&self, columns: &Columns) -> Option<Vec<f64>> {
        let extensions = if columns.input_is_command {
            self.extensions.clone()
        } else {
            self.extensions.without_valve()
        };
        let model = HostExtendedModel::try_new(&self.parameters, &extensions).ok()?;
        rows(columns).answer(&model).ok()
    }
}

/// What drives a model of a recording.
fn rows(columns: &Columns) -> Rows<'_> {
    Rows {
        time_s: &columns.time_s,
        input: &columns.input,
        load: columns.load_n.as_deref(),
        temperature: columns.temperature_c.as_deref(),
    }
}

/// Extends the operator model by the causes of a set and those of the valve; None where no model runs through the
/// recording. `progress` is called with the share of the work that is done.
pub fn extend(
    columns: &Columns,
    search: &Search<'_>,
    set: &Candidate,
    valve: Option<&ValveFit>,
    progress: &(dyn Fn(f64) + Sync),
) -> Option<Extended> {
    let signals = search.signals;
    let scored: Vec<usize> = signals.rows.iter().map(|row| row.at).collect();
    let split = ((TAUGHT * scored.len() as f64) as usize).min(scored.len());
    let before = Task { columns, scored: &scored[..split] };
    let whole = Task { columns, scored: &scored };

    let (operator, plain) = rayon::join(
        || start::operator(&start::Seen::of(search, set), &scored[..split]),
        || start::operator(&start::Seen::plain(columns), &scored[..split]),
    );
    progress(0.3);
    let mut extensions = carry::extensions(columns, search, set);
    carry::add_valve(&mut extensions, valve);
    let (parameters, density) = operator?;
    let extended = before.refined(Extension { parameters, density, extensions })?;
    progress(0.6);
    let (parameters, density) = plain?;
    let plain = before.refined(Extension { parameters, density, extensions: ExtensionParameters::default() })?;
    let heldout = heldout::gain(columns, &scored[split..], (&plain, &extended), signals.noise)?;
    progress(0.7);

    let (model, plain) = rayon::join(|| whole.refined(extended), || whole.refined(plain));
    let (model, plain) = (model?, plain?);
    let (simulated, plain_simulated) = (model.answer(columns)?, plain.answer(columns)?);
    let rmse = |simulated: &[f64]| {
        let errors: Vec<f64> = (0..columns.output.len())
            .filter(|&row| columns.scored[row])
            .map(|row| columns.output[row] - simulated[row])
            .collect();
        root_mean_square(&errors)
    };
    progress(1.0);
    Some(Extended {
        baseline_rmse: rmse(&plain_simulated),
        extended_rmse: rmse(&simulated),
        model,
        simulated,
        plain,
        plain_simulated,
        heldout,
    })
}
