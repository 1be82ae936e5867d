//! A single rise, a long hold and a release, as a creep is usually recorded.

use super::*;
use crate::causes::cause;

/// A muscle that creeps by some per cent of its stroke in each of these times. Unit: mm.
fn creeping(still: &[f64], step_s: f64) -> Vec<f64> {
    let elements = [(0.05, 2.0), (0.06, 15.0), (0.06, 60.0)];
    let mut late = elements.map(|_| still[0]);
    still
        .iter()
        .map(|&y| {
            for (late, (_, time_s)) in late.iter_mut().zip(elements) {
                *late += (y - *late) * -(-step_s / time_s).exp_m1();
            }
            let sum: f64 = late.iter().zip(elements).map(|(late, (share, _))| share * late).sum();
            0.83 * y + sum
        })
        .collect()
}

#[test]
fn a_creep_in_one_hold_is_seen_and_written() {
    const STEP_S: f64 = 0.1;
    let time_s: Vec<f64> = (0..3000).map(|row| f64::from(row) * STEP_S).collect();
    let input: Vec<f64> = time_s
        .iter()
        .map(|&t| (t - 2.0).clamp(0.0, 3.0).min((250.0 - t).clamp(0.0, 3.0)) * 5.0 / 3.0)
        .collect();
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut noise = || -> f64 { StandardNormal.sample(&mut rng) };
    let output = creeping(&hysteresis(&input), STEP_S).iter().map(|y| y + 0.01 * noise()).collect();
    let columns = Columns { scored: vec![true; time_s.len()], time_s, input, output, ..Columns::default() };
    let (diagnosis, extended) = diagnose_and_extend(&columns, None, &|_, _| ()).expect("a diagnosis");
    let answers: Vec<Vec<Cause>> =
        diagnosis.alternatives.iter().cloned().chain([names(&diagnosis)]).collect();
    assert!(answers.iter().all(|set| set.contains(&cause("creep"))), "{answers:?}");
    let written = extended.written(&columns, None).expect("a model");
    let (with, without) = (written.rmse, written.plain_rmse);
    assert!(with < 0.25 * without, "{with} {without}");
    assert!(written.gain.is_sure() && written.gain.from_s.is_none());
}
