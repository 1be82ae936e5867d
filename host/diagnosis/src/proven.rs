//! Whether what the search names holds in a model that is simulated.

use super::DiagnosisError;
use super::candidate::Candidate;
use super::extend::{Extended, Extender, Operator};
use super::reject::{Unexplained, no_gain, unexplained};
use super::valve::ValveFit;
use identification::IdentificationError;

/// The model that is simulated, and what it says of the named causes.
pub struct Proven {
    /// The model.
    pub extended: Extended,
    /// Why the named causes explain nothing, if they do not.
    pub refuted: Option<Unexplained>,
    /// Whether they are needless: they gain nothing, and nothing is left unexplained without them. The model is then that
    /// without them.
    pub is_needless: bool,
}

/// Extends the operator model by a set of causes and those of the valve, and asks what that gains. The operator goes on from a
/// given one, unless there is none or its form is too poor. `progress` is called with the share of the work that is done.
///
/// # Errors
/// No model can be simulated, not even one without causes.
pub fn proven(
    extender: &Extender<'_>,
    (set, valve): (&Candidate, Option<&ValveFit>),
    given: Option<&Operator>,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Proven, DiagnosisError> {
    let search = extender.search;
    let plainly = || {
        let without = |valve| extender.extend(&search.baseline, valve, given, progress);
        // An ordinary valve is left out where the model cannot have it.
        let plain = without(valve.filter(|valve| valve.causes.is_empty())).or_else(|| without(None));
        plain.ok_or(DiagnosisError::NoModel(IdentificationError::Lengths))
    };
    let named = !set.causes.is_empty() || valve.is_some_and(|valve| !valve.causes.is_empty());
    if !named {
        return Ok(Proven { extended: plainly()?, refuted: None, is_needless: false });
    }
    let Some(extended) = extender.extend(set, valve, given, progress) else {
        return Ok(Proven {
            extended: plainly()?,
            refuted: Some(Unexplained::NotSimulated),
            is_needless: false,
        });
    };
    let refuted = no_gain(&extended);
    if refuted.is_some() && unexplained(search, &search.baseline).is_none() {
        return Ok(Proven { extended: plainly()?, refuted: None, is_needless: true });
    }
    Ok(Proven { extended, refuted, is_needless: false })
}
