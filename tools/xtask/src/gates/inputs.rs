//! What the control law is driven with: input that is meant to make it expensive or wrong.
//!
//! | phase | what it is after |
//! |---|---|
//! | first strokes | the dearest ends: those of a muscle that has not been through its range |
//! | standstill | the cheapest sample |
//! | full reversals | every play moves, and turns round, in every sample |
//! | small reversals | turning points that pile up around many places |
//! | nested reversals | the deepest memory, then samples that wipe all of it |
//! | ends and beyond | every jump between the ends, points just and far outside, and nearly the largest numbers |
//! | random | what nobody has thought of |
//! | smooth | what a controller is really asked for |
//! | mode changes | another mode in every sample |
//!
//! But for the smooth course and standstill, the muscle is where it should not be, so that the feedback and its limits
//! work hard.

use std::f64::consts::TAU;

use model_core::Mode;

/// One sample for the control law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// The phase that it belongs to.
    pub phase: &'static str,
    /// How the controller works.
    pub mode: Mode,
    /// Unit: mm.
    pub reference_mm: f32,
    /// Unit: mm.
    pub contraction_mm: f32,
}

const EVERY_MODE: &[Mode] = &[Mode::Both, Mode::FeedforwardOnly, Mode::FeedbackOnly, Mode::Hold];

/// The phases that ask the most of the controller.
const DEAREST: [&str; 2] = ["full reversals", "nested reversals"];

/// The samples that ask the most of the controller.
pub fn dearest(samples: &[Sample]) -> impl Iterator<Item = &Sample> {
    samples.iter().filter(|sample| DEAREST.contains(&sample.phase))
}

/// All samples in their order, for a muscle that contracts from `low_mm` to `high_mm`. The same in every run.
pub fn samples((low_mm, high_mm): (f64, f64)) -> Vec<Sample> {
    let phase = |phase, modes: &'static [Mode], muscle: fn(f64) -> f64, references: Vec<f64>| {
        let modes = modes.iter().cycle();
        let sample = move |(share, &mode)| sample((low_mm, high_mm), phase, mode, share, muscle(share));
        references.into_iter().zip(modes).map(sample)
    };
    let both = &[Mode::Both];
    let smooth = || (0..4000).map(smooth).collect();
    phase("first strokes", both, following, first_strokes())
        .chain(phase("standstill", both, following, vec![0.5; 300]))
        .chain(phase("full reversals", both, opposed, reversals(0.5, 600, |_| 0.5).collect()))
        .chain(phase("small reversals", both, opposed, (1..20).flat_map(small_reversals).collect()))
        .chain(phase("nested reversals", both, opposed, (1..10).flat_map(nested_reversals).collect()))
        .chain(phase("ends and beyond", both, opposed, ends_and_beyond()))
        .chain(phase("random", both, opposed, random().take(3000).map(|share| 1.1 * share - 0.05).collect()))
        .chain(phase("smooth", both, following, smooth()))
        .chain(phase("mode changes", EVERY_MODE, opposed, smooth()))
        .collect()
}

/// Strokes of a muscle that was never used, each a little longer than the one before: back to near the lower end, where another muscle
/// would be beyond it and this one may be or not, just beyond it, and far beyond; and each a second time, not quite as long.
fn first_strokes() -> Vec<f64> {
    let stroke = |(k, near): (u32, f64)| {
        let top = f64::from(k) / 400.0;
        [top, 0.15 * near - 0.02, -1e-6, top - 0.01, 0.15 * near - 0.02, -0.1]
    };
    (0..400).zip(random()).flat_map(stroke).collect()
}

/// Reference and contraction as shares of the muscle's way from the lower to the upper end.
fn sample(
    (low_mm, high_mm): (f64, f64),
    phase: &'static str,
    mode: Mode,
    reference: f64,
    contraction: f64,
) -> Sample {
    let at = |share: f64| (low_mm + share * (high_mm - low_mm)) as f32;
    Sample { phase, mode, reference_mm: at(reference), contraction_mm: at(contraction.clamp(0.0, 1.0)) }
}

fn following(share: f64) -> f64 {
    0.98 * share
}

fn opposed(share: f64) -> f64 {
    1.0 - share
}

/// Turning points on alternate sides of a centre; `amplitude` takes their number.
fn reversals(centre: f64, count: u32, amplitude: impl Fn(u32) -> f64) -> impl Iterator<Item = f64> {
    (0..count).map(move |k| centre + if k % 2 == 0 { amplitude(k) } else { -amplitude(k) })
}

fn small_reversals(place: u32) -> impl Iterator<Item = f64> {
    reversals(f64::from(place) / 20.0, 40, |_| 0.005)
}

/// Ever smaller swings around a centre, many more than there are plays, and then the whole range twice.
fn nested_reversals(place: u32) -> impl Iterator<Item = f64> {
    const COUNT: u32 = 60;
    let centre = f64::from(place) / 10.0;
    let widest = centre.min(1.0 - centre);
    let shrinking = move |k| widest * (1.0 - f64::from(k) / f64::from(COUNT));
    reversals(centre, COUNT, shrinking).chain([1.0, 0.0, 1.0, 0.0])
}

/// Every point after every other one, with steps between that build a memory for the jump to wipe.
fn ends_and_beyond() -> Vec<f64> {
    let points = [0.0, 1.0, -1e-7, 1.0 + 1e-7, 0.5, -0.1, 1.1, -100.0, 100.0, -1e36, 1e36];
    let pairs = points.into_iter().flat_map(|from| points.into_iter().map(move |to| (from, to)));
    pairs.flat_map(|(from, to)| [0.3, 0.6, 0.4, 0.5, from, to]).collect()
}

/// Evenly distributed over 0 to 1: Steele, Lea and Flood's SplitMix64.
fn random() -> impl Iterator<Item = f64> {
    (1_u64..).map(|k| {
        let mut bits = k.wrapping_mul(0x9E37_79B9_7F4A_7C15);
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (bits ^ (bits >> 31)) as f64 / u64::MAX as f64
    })
}

/// Two raised cosines, the second of them with a ripple.
fn smooth(k: u32) -> f64 {
    let turns = f64::from(k) / 2000.0;
    let ripple = if turns > 1.0 { 0.05 * (1.0 - (10.0 * TAU * turns).cos()) } else { 0.0 };
    0.45 * (1.0 - (TAU * turns).cos()) + ripple
}

#[cfg(test)]
mod tests {
    use super::{Sample, samples};

    const LOW_MM: f32 = -10.0;
    const HIGH_MM: f32 = 90.0;

    fn of_phase(name: &str) -> Vec<Sample> {
        let mut samples = samples((LOW_MM.into(), HIGH_MM.into()));
        samples.retain(|sample| sample.phase == name);
        samples
    }

    /// Samples at which the reference turns round.
    fn turns(samples: &[Sample]) -> usize {
        let rises: Vec<_> =
            samples.windows(2).map(|pair| pair[1].reference_mm > pair[0].reference_mm).collect();
        rises.windows(2).filter(|pair| pair[0] != pair[1]).count()
    }

    #[test]
    fn reversals_turn_round_in_every_sample() {
        for name in ["full reversals", "nested reversals"] {
            let samples = of_phase(name);
            // Where one nest ends and the next begins, two samples may go the same way.
            assert!(turns(&samples) + 2 * 9 + 2 >= samples.len(), "{name}: {}", turns(&samples));
        }
    }

    #[test]
    fn all_numbers_are_finite_and_some_are_far_outside() {
        let samples = samples((LOW_MM.into(), HIGH_MM.into()));
        assert!(samples.iter().all(|s| s.reference_mm.is_finite()));
        assert!(samples.iter().all(|s| (LOW_MM..=HIGH_MM).contains(&s.contraction_mm)));
        assert!(samples.iter().any(|s| s.reference_mm > 1e37));
        assert!(samples.iter().any(|s| s.reference_mm < -1e37));
    }

    #[test]
    fn every_mode_follows_another_one() {
        let samples = of_phase("mode changes");
        assert!(samples.windows(2).all(|pair| pair[0].mode != pair[1].mode));
    }
}
