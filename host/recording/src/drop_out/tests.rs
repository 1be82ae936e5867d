//! Drop-outs that are found, and steps of the muscle that are not taken for one.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::*;

/// Times, input and output of a recording. Units: s, bar, mm.
struct Recorded {
    time_s: Vec<f64>,
    input: Series,
    output: Series,
}

/// A muscle that follows an input, a value each `step_s`, through a play of 0.5 bar, by 10 mm/bar;
/// with a sensor's noise of 0.03 mm.
fn muscle(step_s: f64, input: Vec<f64>) -> Recorded {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut played: f64 = 0.0;
    let mut contraction = |&bar: &f64| {
        let noise: f64 = StandardNormal.sample(&mut rng);
        played = played.clamp(bar - 0.5, bar + 0.5);
        10.0 * played + 0.03 * noise
    };
    let output = input.iter().map(&mut contraction).collect();
    let series = |name: &str, values| Series { channel: Channel::of_column(name).expect("a unit"), values };
    Recorded {
        time_s: (0..input.len()).map(|at| at as f64 * step_s).collect(),
        input: series("pressure_bar", input),
        output: series("contraction_mm", output),
    }
}

/// Triangles of 20 s between 0 and 6 bar.
fn triangles(step_s: f64, samples: usize) -> Vec<f64> {
    let triangle = |at: usize| 6.0 * (1.0 - ((at as f64 * step_s / 10.0) % 2.0 - 1.0).abs());
    (0..samples).map(triangle).collect()
}

impl Recorded {
    /// The drop-outs, each column's name and samples; lines count from 2.
    fn found(&mut self) -> Vec<(String, Range<usize>)> {
        take_out(&self.time_s, &mut self.input, &mut self.output, |at| at + 2)
            .into_iter()
            .map(|drop_out| (drop_out.channel.name, drop_out.samples))
            .collect()
    }

    fn assert_sound(mut self, what: &str) {
        assert_eq!(self.found(), [], "{what}");
    }
}

#[test]
fn runs_of_one_to_fifty_samples_are_found_wherever_and_whatever_they_are() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let (mut found, mut all) = (0, 0);
    for step_s in [0.01, 0.1] {
        for case in 0..140 {
            let mut recorded = muscle(step_s, triangles(step_s, 2000));
            let samples = [1, 2, 3, 4, 10, 20, 50][case % 7];
            let first = rng.random_range(1..2000 - samples);
            let run = first..first + samples;
            let value = [0.0, -999.0, 75.0, rng.random_range(0.0..55.0)][case / 7 % 4];
            let values = &mut recorded.output.values;
            let is_off = run.clone().all(|at| (values[at] - value).abs() > 6.0);
            values[run.clone()].fill(value);
            if is_off {
                all += 1;
                found += usize::from(recorded.found() == [("contraction_mm".to_owned(), run)]);
            }
        }
    }
    // A tenth of the stroke off at least; nothing else is taken out beside them.
    assert!(all > 150 && f64::from(found as u32) >= 0.97 * f64::from(all as u32), "{found} of {all}");
}

#[test]
fn wild_samples_of_both_columns_are_bridged_and_told_with_their_lines() {
    let mut recorded = muscle(0.01, triangles(0.01, 4000));
    let before = (recorded.input.values[1500], recorded.output.values[1499]);
    recorded.output.values[1500] = 999.0;
    recorded.input.values[1500] = 8.0;
    recorded.input.values[2500] = 99.0;
    let Recorded { time_s, input, output } = &mut recorded;
    let found = take_out(time_s, input, output, |at| at + 2);
    let told: Vec<_> = found
        .iter()
        .map(|it| (it.channel.name.as_str(), it.samples.clone(), it.lines, it.values.0))
        .collect();
    assert_eq!(
        told,
        [
            ("contraction_mm", 1500..1501, (1502, 1502), 999.0),
            ("pressure_bar", 1500..1501, (1502, 1502), 8.0),
            ("pressure_bar", 2500..2501, (2502, 2502), 99.0),
        ]
    );
    assert!((input.values[1500] - before.0).abs() < 0.01);
    assert!((output.values[1500] - before.1).abs() < 0.3);
}

#[test]
fn a_sensor_that_comes_late_or_goes_early_is_found() {
    let mut recorded = muscle(0.01, triangles(0.01, 4000));
    recorded.output.values[..30].fill(-999.0);
    recorded.output.values[3970..].fill(-999.0);
    let column = || "contraction_mm".to_owned();
    assert_eq!(recorded.found(), [(column(), 0..30), (column(), 3970..4000)]);
}

#[test]
fn what_a_muscle_does_is_no_drop_out() {
    let slow = || muscle(0.01, triangles(0.01, 4000));
    slow().assert_sound("triangles");
    muscle(1.0, (0..600).map(|at| 3.0 + 3.0 * (f64::from(at) * 1.3).sin()).collect()).assert_sound("1 Hz");
    let pulses = |at: usize| if at % 400 < 30 { 5.0 } else { 0.5 };
    muscle(0.01, (0..4000).map(pulses).collect()).assert_sound("pulses of the input");
    muscle(0.1, (0..4000).map(pulses).collect()).assert_sound("pulses, samples far apart");
    let mut coarse = slow();
    coarse.output.values.iter_mut().for_each(|mm| *mm = mm.round());
    coarse.assert_sound("a sensor of 1 mm");
    let mut loaded = slow();
    loaded.output.values[1000..2000].iter_mut().for_each(|mm| *mm -= 12.0);
    loaded.assert_sound("a load that is put on and taken off");
    let mut rod = slow();
    let mut held: f64 = 0.0;
    for mm in &mut rod.output.values {
        held = if (*mm - held).abs() > 4.0 { *mm } else { held };
        *mm = held;
    }
    rod.assert_sound("a rod that sticks and slips");
    let mut ringing = slow();
    for (at, mm) in ringing.output.values.iter_mut().enumerate().skip(2100) {
        let late_s = (at - 2100) as f64 * 0.01;
        *mm += 15.0 * (-4.0 * late_s).exp() * (60.0 * late_s).sin();
    }
    ringing.assert_sound("ringing at 10 Hz");
}

#[test]
fn the_recordings_of_the_rig_have_none() {
    for name in ["rig-fig8.csv", "rig-ramps.csv"] {
        let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../recordings").join(name);
        let recording = crate::Recording::read(&file, &Default::default()).expect("a recording");
        assert_eq!(recording.left_out, Default::default(), "{name}");
    }
}
