//! What a plan claims: its recording shows each of its causes, and tells apart those that a slow triangle confounds.

use super::*;
use crate::anatomy::Residual;
use crate::anatomy::examinable::examinable;
use crate::anatomy::excitation::Excitation;
use crate::causes::cause;
use crate::causes::needs::ValveView;

const LIMITS: Limits = Limits { min_bar: 0.0, max_bar: 6.0, slew_bar_per_s: None };

fn wish(causes: &[Cause]) -> Wish {
    Wish { causes: causes.to_vec(), limits: LIMITS, duration_s: None, rate_hz: 100.0, seed: 1 }
}

fn columns(plan: &Plan) -> (Vec<f64>, Vec<f64>) {
    plan.rows().unzip()
}

#[test]
fn the_recording_of_a_plan_shows_its_causes_alone_and_in_pairs() {
    for (first, one) in Cause::ALL.into_iter().enumerate() {
        for other in Cause::ALL.into_iter().skip(first) {
            let plan = Plan::new(&Wish { rate_hz: 40.0, ..wish(&[one, other]) }).expect("a plan");
            let (time_s, command) = columns(&plan);
            // A load and a temperature that a person changes from part to part.
            let by_hand: Vec<f64> = time_s.iter().map(|t| (t / 7.0).sin()).collect();
            let recording = Residual {
                time_s: &time_s,
                residual: &command,
                input: &command,
                output: &command,
                load: Some(&by_hand),
                temperature: Some(&by_hand),
            };
            let excitation = Excitation::of(&recording);
            for judged in examinable(&excitation, ValveView::Beside(&excitation), "bar") {
                let wanted = [one, other].contains(&judged.cause);
                assert!(!wanted || judged.examinable, "{one} and {other}: {judged:?}");
            }
        }
    }
}

#[test]
fn a_plan_without_causes_shows_all_but_the_load() {
    let words = Plan::new(&wish(&[])).expect("a plan").words().join("\n");
    for any in Cause::ALL {
        assert_eq!(words.lines().next().is_some_and(|line| line.contains(any.name())), any != cause("load"));
    }
}

/// A signal through a first-order lag.
fn lagged(time_s: &[f64], input: &[f64], constant_s: f64) -> Vec<f64> {
    let mut value = input[0];
    let mut last_s = time_s[0];
    let mut follow = |(&now_s, &to): (&f64, &f64)| {
        value += (to - value) * (1.0 - (-(now_s - last_s) / constant_s).exp());
        last_s = now_s;
        value
    };
    time_s.iter().zip(input).map(&mut follow).collect()
}

/// A signal so many rows later.
fn delayed(input: &[f64], rows: usize) -> Vec<f64> {
    (0..input.len()).map(|row| input[row.saturating_sub(rows)]).collect()
}

/// What the best of some candidates leaves of a signal: root mean square.
fn left(signal: &[f64], candidates: impl Iterator<Item = Vec<f64>>) -> f64 {
    let rms = |candidate: Vec<f64>| {
        let square = signal.iter().zip(candidate).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
        (square / signal.len() as f64).sqrt()
    };
    candidates.map(rms).fold(f64::INFINITY, f64::min)
}

/// A straight line through a signal over x, by least squares.
fn line(x: &[f64], signal: &[f64]) -> Vec<f64> {
    let count = x.len() as f64;
    let (mean_x, mean) = (x.iter().sum::<f64>() / count, signal.iter().sum::<f64>() / count);
    let covariance: f64 = x.iter().zip(signal).map(|(x, y)| (x - mean_x) * (y - mean)).sum();
    let slope = covariance / x.iter().map(|x| (x - mean_x).powi(2)).sum::<f64>();
    x.iter().map(|x| mean + slope * (x - mean_x)).collect()
}

/// Triangles of 40 s.
fn triangles() -> (Vec<f64>, Vec<f64>) {
    let time_s: Vec<f64> = (0..16_000).map(|row| f64::from(row) * 0.01).collect();
    let input = time_s.iter().map(|t| 6.0 * (1.0 - ((t / 20.0) % 2.0 - 1.0).abs())).collect();
    (time_s, input)
}

#[test]
fn a_delay_that_a_lag_explains_under_slow_triangles_is_told_apart() {
    let left = |(time_s, input): (Vec<f64>, Vec<f64>)| {
        let lags = (1..60).map(|k| lagged(&time_s, &input, 0.005 * f64::from(k)));
        left(&delayed(&input, 10), lags)
    };
    let plan = Plan::new(&wish(&[cause("transport_delay"), cause("valve_lag")])).expect("a plan");
    let (confounded, separated) = (left(triangles()), left(columns(&plan)));
    assert!(separated > 10.0 * confounded, "{confounded} bar, {separated} bar");
}

#[test]
fn a_drift_that_travel_explains_under_triangles_is_told_apart() {
    let left = |(time_s, input): (Vec<f64>, Vec<f64>)| {
        let mut way = 0.0;
        let mut last = input[0];
        let mut go = |&value: &f64| {
            way += (value - last).abs();
            last = value;
            way
        };
        let travel: Vec<f64> = input.iter().map(&mut go).collect();
        let duration_s = time_s[time_s.len() - 1];
        let drift: Vec<f64> = time_s.iter().map(|t| t / duration_s).collect();
        left(&drift, [line(&travel, &drift)].into_iter())
    };
    let plan = Plan::new(&wish(&[cause("drift"), cause("warm_up")])).expect("a plan");
    let (confounded, separated) = (left(triangles()), left(columns(&plan)));
    assert!(separated > 10.0 * confounded, "{confounded}, {separated}");
}

#[test]
fn limits_are_kept_and_a_wanted_duration_is_met() {
    let limits = Limits { min_bar: 0.5, max_bar: 3.0, slew_bar_per_s: Some(4.0) };
    for duration_s in [None, Some(200.0), Some(900.0)] {
        let plan = Plan::new(&Wish { limits, duration_s, ..wish(&[]) }).expect("a plan");
        let (time_s, command) = columns(&plan);
        assert!(command.iter().all(|bar| (0.5..=3.0).contains(bar)));
        assert!(command.windows(2).all(|pair| (pair[1] - pair[0]).abs() <= 0.04 + 1e-9));
        assert!([command[0], command[command.len() - 1]].iter().all(|bar| (bar - 0.5).abs() < 1e-6));
        let last_s = time_s[time_s.len() - 1];
        assert!(duration_s.is_none_or(|wanted_s| (last_s - wanted_s).abs() < 0.02), "{last_s}");
    }
}

#[test]
fn what_cannot_be_planned_is_refused_with_the_limit() {
    let refusal = |wish: Wish| Plan::new(&wish).expect_err("refused").to_string();
    let range = |min_bar, max_bar| Wish { limits: Limits { min_bar, max_bar, ..LIMITS }, ..wish(&[]) };
    assert!(refusal(range(3.0, 3.0)).contains("3 to 3 bar; the lower must come first"));
    assert!(refusal(range(f64::NAN, 3.0)).contains("the lower must come first"));
    assert!(refusal(range(0.0, 600.0)).contains("600 bar is outside -1 to 100 bar"));
    let short = refusal(Wish { duration_s: Some(5.0), ..wish(&[]) });
    assert!(short.contains("5 s is too short: these parts take"), "{short}");
    assert!(refusal(Wish { duration_s: Some(1e6), ..wish(&[]) }).contains("play the plan twice"));
    assert!(refusal(Wish { rate_hz: 1e6, ..wish(&[]) }).contains("a lower rate has fewer"));
}
