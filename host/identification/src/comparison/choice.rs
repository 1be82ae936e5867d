//! The choice of a model for a recording: what is tried, and which of it is taken.
//!
//! Held-out error with a penalty: each unknown has to pay for itself with a thousandth of the
//! error, so that of two models that do equally well on what they have not seen the smaller one is
//! taken. Without a held-out part the error on the recording itself takes its place.

use model_core::Kind;

use super::{Comparison, Row};
use crate::{FREE, Options, Weights};

/// By what share of the error each unknown makes a model worse.
const PENALTY: f64 = 1e-3;

/// An error, and what the unknowns have to pay beside it.
///
/// ```
/// use identification::{Options, comparison::choice::penalised};
///
/// let few = Options { plays: 4, ..Options::default() };
/// let many = Options { plays: 16, ..Options::default() };
/// assert!(penalised(1.0, &few) <= penalised(1.0, &many));
/// ```
pub fn penalised(error: f64, options: &Options) -> f64 {
    error * (1.0 + PENALTY * options.unknowns() as f64)
}

/// Every model of the family in the sizes of `base`; the richest ones also with a piecewise-linear
/// envelope of `knots` knots, with free weights, and with twice the plays.
pub fn candidates(base: &Options, knots: usize) -> Vec<Options> {
    let plain = Options { knots: None, weights: Weights::Exponential, ..*base };
    let piecewise = Options { model: Kind::Mgpi, knots: Some(knots), ..plain };
    let mut candidates: Vec<Options> =
        Kind::ALL.into_iter().map(|model| Options { model, ..plain }).collect();
    candidates.extend([Options { model: Kind::Sgpi, ..piecewise }, piecewise]);
    if base.plays <= FREE {
        candidates.push(Options { weights: Weights::Free, ..piecewise });
    }
    if 2 * base.plays <= FREE {
        candidates.push(Options { model: Kind::Mgpi, plays: 2 * base.plays, ..plain });
    }
    candidates
}

impl Comparison<'_> {
    /// The model to take; None where none could be made.
    pub fn chosen(&self) -> Option<&Row> {
        let score = |(row, outcome): &(&Row, &super::Outcome)| penalised(outcome.judged().rmse, &row.options);
        self.made().min_by(|one, other| score(one).total_cmp(&score(other))).map(|(row, _)| row)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::comparison::HeldOut;
    use crate::{CONVERGED, Loss};
    use recording::figures::Figures;
    use recording::{Choice, Recording};

    #[test]
    fn of_models_that_do_equally_well_the_smaller_one_is_taken() {
        let directory = tempfile::tempdir().expect("a directory");
        let file = directory.path().join("rec.csv");
        std::fs::write(&file, "time_s,pressure_bar,contraction_mm\n0,0,0\n1,1,1\n").expect("written");
        let recording = Recording::read(&file, &Choice::default()).expect("a recording");
        let row = |plays, rmse| {
            let figures = Figures { rmse, mae: rmse, max_error: rmse };
            Row {
                tick_instructions: None,
                options: Options {
                    model: Kind::Mgpi,
                    knots: None,
                    weights: Weights::Exponential,
                    loss: Loss::Squares,
                    plays,
                    dead_zones: plays,
                    starts: 1,
                    seed: 1,
                    threads: 1,
                    tolerance: CONVERGED,
                },
                seconds: 0.0,
                outcome: Ok(super::super::Outcome {
                    training: Figures { rmse: 0.0, ..figures },
                    heldout: Some(figures),
                    termination: String::new(),
                    simulated: Vec::new(),
                }),
            }
        };
        let chosen = |rows| {
            let comparison = Comparison { recording: &recording, heldout: HeldOut::LaterCycles, rows };
            comparison.chosen().map(|row| row.options.plays)
        };
        assert_eq!(chosen(vec![row(20, 0.799), row(10, 0.8)]), Some(10));
        assert_eq!(chosen(vec![row(20, 0.7), row(10, 0.8)]), Some(20));
        assert_eq!(chosen(Vec::new()), None);
    }

    #[test]
    fn every_member_of_the_family_is_a_candidate() {
        let base = Options {
            model: Kind::Mgpi,
            knots: None,
            weights: Weights::Exponential,
            loss: Loss::Squares,
            plays: 10,
            dead_zones: 10,
            starts: 1,
            seed: 1,
            threads: 1,
            tolerance: CONVERGED,
        };
        let candidates = candidates(&base, 12);
        for kind in Kind::ALL {
            assert!(candidates.iter().any(|options| options.model == kind), "{kind}");
        }
        assert!(candidates.iter().any(|options| options.weights == Weights::Free));
    }
}
