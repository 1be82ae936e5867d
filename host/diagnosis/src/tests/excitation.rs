//! What is said where a recording cannot show what acts.

use super::*;
use crate::anatomy::examinable::Inseparable;
use crate::causes::cause;
use crate::words::{experiment, unexamined};

/// The plant under another command. Unit: bar.
fn under(command: impl Fn(f64) -> f64) -> Plant {
    let time_s: Vec<f64> = (0..ROWS).map(|row| row as f64 * STEP_S).collect();
    let pressure = time_s.iter().map(|&t| command(t)).collect();
    Plant { time_s, pressure }
}

/// Triangles, each lower than the one before: no two are alike, and all are of one period. Unit: bar.
fn falling(time_s: f64) -> f64 {
    let triangle = 1.0 - (2.0 * (time_s / 8.0).fract() - 1.0).abs();
    5.5 * (1.0 - 0.08 * (time_s / 8.0).floor()) * triangle
}

/// Swings of all heights without a hold, again every 20 s. Unit: bar.
fn swinging(time_s: f64) -> f64 {
    let sine = |hz: f64| (std::f64::consts::TAU * hz * time_s).sin();
    let swing = 2.5 + 1.1 * sine(0.05) + 0.8 * sine(0.2) + 0.5 * sine(0.45);
    swing.clamp(0.0, 5.5) * (time_s / 3.0).min(1.0)
}

#[test]
fn a_drift_without_swings_alike_is_named_where_nothing_else_explains_the_recording() {
    let plant = under(falling);
    let drifting: Vec<f64> =
        hysteresis(&plant.pressure).iter().zip(&plant.time_s).map(|(y, t)| y + 0.04 * t).collect();
    let columns = Columns { command: None, ..plant.recorded(&drifting) };
    let diagnosis = diagnosed(&columns);
    assert_eq!((diagnosis.verdict, names(&diagnosis)), (Verdict::Explained, vec![cause("drift")]));
    let drift = diagnosis.examinable.iter().find(|judged| judged.cause == cause("drift"));
    let why = &drift.expect("judged").why;
    assert!(
        why.ends_with("no cause that it has an excitation for explains the recording, and this one does"),
        "{why}"
    );
}

/// Swings of one speed and of several heights, again and again. Unit: bar.
fn at_one_speed(time_s: f64) -> f64 {
    const HEIGHTS: [f64; 5] = [5.0, 2.0, 4.0, 3.0, 4.5];
    let period_s: f64 = HEIGHTS.iter().sum();
    let mut left_s = time_s.rem_euclid(period_s);
    for height in HEIGHTS {
        if left_s < height {
            return height - (height - 2.0 * left_s).abs();
        }
        left_s -= height;
    }
    0.0
}

#[test]
fn an_adequate_model_says_that_a_recording_of_one_speed_may_hide_what_comes_late() {
    let plant = under(at_one_speed);
    let answer = |delay_s| {
        let late = under(|t| at_one_speed(t - delay_s));
        let columns = Columns { command: None, ..plant.recorded(&hysteresis(&late.pressure)) };
        let diagnosis = diagnosed(&columns);
        assert_eq!((diagnosis.verdict, names(&diagnosis)), (Verdict::Adequate, vec![]));
        (crate::words::in_a_sentence(&diagnosis, columns.output_unit), diagnosis.unexamined)
    };
    let (sentence, unexamined) = answer(0.06);
    assert!(!unexamined.is_empty() && sentence.contains("this recording cannot show"), "{sentence}");
    let (sentence, unexamined) = answer(0.0);
    assert!(unexamined.is_empty() && sentence.ends_with("no cause is named."), "{sentence}");
}

#[test]
fn a_sound_recording_without_swings_alike_has_no_drift() {
    let plant = under(falling);
    let columns = Columns { command: None, ..plant.recorded(&hysteresis(&plant.pressure)) };
    let diagnosis = diagnosed(&columns);
    assert_eq!((diagnosis.verdict, names(&diagnosis)), (Verdict::Adequate, vec![]));
    assert!(diagnosis.examinable.iter().any(|judged| judged.cause == cause("drift") && !judged.examinable));
}

#[test]
fn what_would_leave_nothing_unexplained_is_said_with_the_experiment_that_would_show_it() {
    let plant = Plant::new();
    let mut diagnosis = diagnosed(&plant.recorded(&hysteresis(&plant.pressure)));
    diagnosis.verdict = Verdict::Unexplained;
    diagnosis.unexplained = Some(Unexplained::NotRepeatable { pure_error: 0.1, tones_hz: Vec::new() });
    diagnosis.unexamined = vec![cause("drift")];
    diagnosis.examinable.iter_mut().for_each(|judged| judged.examinable &= judged.cause != cause("drift"));
    let words = unexamined(&diagnosis).expect("words");
    assert!(words.starts_with("drift would leave nothing unexplained"), "{words}");
    assert_eq!(experiment(&diagnosis).as_deref(), Some("mgpi plan --causes drift -o plan.csv"));
}

#[test]
fn a_creep_without_a_hold_is_not_taken_for_its_rival() {
    let plant = under(swinging);
    let mut slow = [0.0; 3];
    let creeping = |y: f64| -> f64 {
        let late = slow.iter_mut().zip([1.0, 5.0, 20.0]).map(|(slow, tau_s)| {
            *slow += (y - *slow) * STEP_S / tau_s;
            0.06 * *slow
        });
        y + late.sum::<f64>()
    };
    let output: Vec<f64> = hysteresis(&plant.pressure).into_iter().map(creeping).collect();
    let columns = Columns { command: None, ..plant.recorded(&output) };
    let diagnosis = diagnosed(&columns);
    let creep = diagnosis.examinable.iter().find(|judged| judged.cause == cause("creep"));
    assert!(creep.is_some_and(|creep| !creep.examinable));
    assert_eq!(diagnosis.verdict, Verdict::Confounded, "{:?}", names(&diagnosis));
    assert!(
        diagnosis.unexamined.contains(&cause("creep")),
        "{:?} {:?}",
        names(&diagnosis),
        diagnosis.unexamined
    );
    let words = unexamined(&diagnosis).expect("words");
    assert!(words.contains("would do as well as what is named, or better"), "{words}");
}

#[test]
fn what_is_named_and_not_told_apart_gets_the_experiment_that_would() {
    let plant = Plant::new();
    let mut diagnosis = diagnosed(&plant.recorded(&hysteresis(&plant.pressure)));
    let both = vec![cause("viscous_lag"), cause("creep")];
    diagnosis.inseparable = Inseparable { causes: both, why: vec!["there is no hold"] };
    assert_eq!(experiment(&diagnosis), None);
    diagnosis.verdict = Verdict::Explained;
    diagnosis.causes = vec![named(cause("load"), Vec::new())];
    assert_eq!(experiment(&diagnosis), None);
    diagnosis.causes.push(named(cause("creep"), Vec::new()));
    assert_eq!(experiment(&diagnosis).as_deref(), Some("mgpi plan --causes creep,viscous_lag -o plan.csv"));
}
