//! The parameters of the named causes as the extended model has them, which runs free.

use super::Diagnosis;
use super::causes::Cause;
use super::extend::Extended;
use super::verdict::{Named, Verdict};

/// The extended model measures its causes where it errs by less than so many times what the search does, which has more freedom.
const MEASURES: f64 = 1.5;

/// Measures the named causes anew, and drops those that no longer show in rows `step_s` apart. Of a lag before a mass (`is_third_order`)
/// the search has more to say than the extended model, which has no more than the second order.
pub fn measure(diagnosis: &mut Diagnosis, extended: &Extended, is_third_order: bool, step_s: f64) {
    // A model that gains nothing, or is much farther from the muscle than the search has come, has nothing to say about them.
    let Extended { baseline_rmse: before, extended_rmse: after, .. } = *extended;
    let is_near = after < before && after < MEASURES * diagnosis.rmse.1;
    let model = is_near.then(|| extended.model.simulated()).flatten();
    let is_simpler = |cause: Cause| is_third_order && cause.is_of_second_order();
    for named in diagnosis.causes.iter_mut().filter(|named| !is_simpler(named.cause)) {
        let measured = model.as_ref().and_then(|model| named.cause.measured(model));
        measured.into_iter().for_each(|measured| named.cause.take_over(&mut named.parameters, measured));
    }
    diagnosis.causes.retain(|named| shows(named, step_s));
    if diagnosis.causes.is_empty() && matches!(diagnosis.verdict, Verdict::Explained | Verdict::Confounded) {
        diagnosis.verdict = Verdict::Adequate;
        diagnosis.alternatives.clear();
        diagnosis.unexamined.clear();
    }
    for named in diagnosis.causes.iter_mut().filter(|named| is_simpler(named.cause)) {
        named.evidence.push(
            "the lag comes before the mass; the extended model has one equation of second order for both"
                .into(),
        );
    }
}

/// Whether rows so far apart can show what is named: what is faster has gone out of the refined model.
fn shows(named: &Named, step_s: f64) -> bool {
    named.parameters.iter().all(|&(name, value)| match name {
        "natural_frequency_hz" => value * step_s <= 0.5,
        "delay_s" | "time_constant_s" => value >= 0.5 * step_s,
        _ => true,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::causes::cause;

    #[test]
    fn what_is_faster_than_rows_is_not_named() {
        let named = |cause, name, value| Named {
            cause,
            parameters: vec![(name, value)],
            share: 0.1,
            evidence: Vec::new(),
            without: None,
        };
        let is_shown = |cause, name, value| shows(&named(cause, name, value), 0.01);
        assert!(is_shown(cause("transport_delay"), "delay_s", 0.006));
        assert!(!is_shown(cause("transport_delay"), "delay_s", 0.0));
        assert!(!is_shown(cause("viscous_lag"), "time_constant_s", 0.004));
        assert!(is_shown(cause("inertia"), "natural_frequency_hz", 40.0));
        assert!(!is_shown(cause("inertia"), "natural_frequency_hz", 60.0));
        assert!(is_shown(cause("drift"), "mm_per_s", 0.001));
    }
}
