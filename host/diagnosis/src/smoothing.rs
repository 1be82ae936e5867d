//! A noisy signal smoothed in time, as far as its noise hides what it does.
//!
//! # Design
//! At each sample straight lines are fitted to windows of 2, 4, 8, … samples before it, after it and on both sides. A window
//! grows while the intervals of all smaller ones, [`confidence`] standard errors wide on each side, have a value in common
//! (intersection of confidence intervals: Goldenshluger and Nemirovski 1997, Katkovnik 1999): up to there the line departs from
//! the signal by no more than the noise shows. In a quarter of that window its standard error is twice as large, and what it departs
//! by, which grows with the square of the width, a sixteenth: small beside it. Where the widest window is so small that it has no quarter,
//! as where rows are so far apart that the signal turns within a few of them, nothing is smoothed. Before and after the sample the lines may differ, so
//! that corners and jumps stay; what is taken is the window on both sides, where it agrees with the other two, or their mean,
//! whichever has the smaller standard error.
//!
//! # Limits
//! White noise of one size. Windows count samples: what moves within a gap of time is seen as a jump.

/// A smoothed signal.
#[derive(Clone, Debug)]
pub struct Smoothed {
    /// A value a sample. Unit: that of the signal.
    pub values: Vec<f64>,
    /// What is left of the noise, root mean square of the standard errors. Unit: that of the signal.
    pub error: f64,
}

/// By how many standard deviations so many samples of normal noise are off at most, about: √(2 ln n) (Donoho and Johnstone
/// 1994). At that level noise alone stops hardly any window.
pub fn confidence(samples: usize) -> f64 {
    (2.0 * (samples.max(2) as f64).ln()).sqrt()
}

/// A signal with white noise of this standard deviation, smoothed.
pub fn smoothed(values: &[f64], noise: f64) -> Smoothed {
    let sums = Sums::new(values);
    let reach = confidence(values.len());
    let one = |at: usize| {
        let [before, after, both] = [Side::Before, Side::After, Side::Both]
            .map(|side| sums.quarter_of_widest(at, side, values[at], reach * noise));
        let mean = before.and(after);
        // Across a jump the two sides balance: the line on both sides has to be what each of them shows.
        let agrees =
            |one: Estimate| (one.value - both.value).abs() <= reach * noise * (one.error + both.error);
        if both.error < mean.error && agrees(before) && agrees(after) { both } else { mean }
    };
    let estimates: Vec<Estimate> = (0..values.len()).map(one).collect();
    let square = estimates.iter().map(|estimate| estimate.error.powi(2)).sum::<f64>();
    Smoothed {
        values: estimates.iter().map(|estimate| estimate.value).collect(),
        error: noise * (square / values.len().max(1) as f64).sqrt(),
    }
}

/// A value of a line, and its standard error in standard deviations of the noise.
#[derive(Clone, Copy)]
struct Estimate {
    value: f64,
    error: f64,
}

impl Estimate {
    /// Two lines that end at one sample, in the best mean of both: what they share is that sample, of which either has as much in it as its
    /// squared error (the leverage of the end of a line).
    fn and(self, other: Self) -> Self {
        let (one, two) = (self.error.powi(2), other.error.powi(2));
        let [of_self, of_other] = [two * (1.0 - one), one * (1.0 - two)];
        let total = of_self + of_other;
        if total <= 0.0 {
            // Both are the sample itself.
            return self;
        }
        Self {
            value: (self.value * of_self + other.value * of_other) / total,
            error: (one * two * (1.0 - one * two) / total).sqrt(),
        }
    }
}

/// The straight line through `count` values x, at one end of it: Σ w x with w = 2 (2 n - 1 - 3 k) / (n (n + 1)), k values from that end.
/// `sum`: Σ x; `moment`: Σ k x.
pub fn end_of_line(count: f64, sum: f64, moment: f64) -> f64 {
    2.0 * ((2.0 * count - 1.0) * sum - 3.0 * moment) / (count * (count + 1.0))
}

/// Where a window lies from its sample.
#[derive(Clone, Copy)]
enum Side {
    Before,
    After,
    Both,
}

/// Sums of all values before a sample, and of their products with their places; about the mean of all.
struct Sums {
    mean: f64,
    values: Vec<f64>,
    moments: Vec<f64>,
}

impl Sums {
    fn new(values: &[f64]) -> Self {
        let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
        let running = |of: &dyn Fn(usize, f64) -> f64| {
            let mut sum = 0.0;
            let next = |(place, value): (usize, &f64)| {
                sum += of(place, value - mean);
                sum
            };
            std::iter::once(0.0).chain(values.iter().enumerate().map(next)).collect()
        };
        Self {
            mean,
            values: running(&|_, value| value),
            moments: running(&|place, value| place as f64 * value),
        }
    }

    /// The estimate of a quarter of the widest window whose interval has a value in common with those of all smaller ones, or of
    /// the smallest window; the sample's own value where even that window
    /// disagrees with it, as beside a jump, or reaches beyond the recording.
    /// `reach`: half the width of the interval of one sample.
    fn quarter_of_widest(&self, at: usize, side: Side, own: f64, reach: f64) -> Estimate {
        let (mut low, mut high) = (own - reach, own + reach);
        // Of a sample, of the sample, and of the windows of 2, 4, 8: the quarter of 4 is the sample.
        let mut last = [Estimate { value: own, error: 1.0 }; 3];
        for power in 1..usize::BITS {
            let Some(estimate) = self.line(at, side, 1 << power) else { break };
            let off = reach * estimate.error;
            (low, high) = (low.max(estimate.value - off), high.min(estimate.value + off));
            if low > high {
                break;
            }
            last = [last[1], last[2], estimate];
        }
        last[0]
    }

    /// The line through so many samples before or after one, or on each side of it, at that sample, which is one of them.
    fn line(&self, at: usize, side: Side, count: usize) -> Option<Estimate> {
        let end = self.values.len() - 1;
        let from = match side {
            Side::Before | Side::Both => (at + 1).checked_sub(count)?,
            Side::After => at,
        };
        let to = match side {
            Side::Before => at + 1,
            Side::After | Side::Both => at + count,
        };
        if to > end {
            return None;
        }
        let n = (to - from) as f64;
        let sum = self.values[to] - self.values[from];
        if let Side::Both = side {
            return Some(Estimate { value: self.mean + sum / n, error: n.sqrt().recip() });
        }
        // About the sample, which is one end.
        let moment = self.moments[to] - self.moments[from] - at as f64 * sum;
        let apart = if let Side::Before = side { -moment } else { moment };
        let value = end_of_line(n, sum, apart);
        let error = (2.0 * (2.0 * n - 1.0) / (n * (n + 1.0))).sqrt();
        Some(Estimate { value: self.mean + value, error })
    }
}

#[cfg(test)]
mod tests {
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;
    use recording::numbers::root_mean_square;

    const NOISE: f64 = 0.1;

    /// Triangles of 2,000 samples between 0 and 6, jumps between them, and then a rest.
    fn pressure(row: usize) -> f64 {
        let phase = (row % 2000) as f64 / 2000.0;
        match row {
            0..6000 => 6.0 * (1.0 - (2.0 * phase - 1.0).abs()),
            6000..9000 => [1.0, 5.0, 2.0][(row - 6000) / 1000],
            _ => 3.0,
        }
    }

    #[test]
    fn noise_goes_down_to_a_fifth_and_corners_and_jumps_stay() {
        let truth: Vec<f64> = (0..12_000).map(pressure).collect();
        for seed in 0..5 {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let mut noise = || {
                let value: f64 = StandardNormal.sample(&mut rng);
                NOISE * value
            };
            let noisy: Vec<f64> = truth.iter().map(|value| value + noise()).collect();
            let Smoothed { values, error } = smoothed(&noisy, NOISE);
            let off: Vec<f64> = values.iter().zip(&truth).map(|(value, truth)| value - truth).collect();
            let rms = root_mean_square(&off);
            assert!(rms < 0.2 * NOISE, "{rms}");
            assert!(error < 0.2 * NOISE && error > 0.2 * rms, "{error} {rms}");
            let most = off.iter().fold(0.0, |most: f64, off| most.max(off.abs()));
            assert!(most < 5.0 * NOISE, "{most}");
        }
    }

    #[test]
    fn what_turns_within_a_few_samples_stays() {
        // Arcs of seven samples between rests, of less than the noise's reach from one sample to the next.
        let arc = |row: usize| if row % 40 < 7 { 0.06 * (row % 40 * (6 - row % 40)) as f64 } else { 0.0 };
        let truth: Vec<f64> = (0..4_000).map(arc).collect();
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let noisy: Vec<f64> = truth
            .iter()
            .map(|value| {
                let noise: f64 = StandardNormal.sample(&mut rng);
                value + NOISE * noise
            })
            .collect();
        let Smoothed { values, .. } = smoothed(&noisy, NOISE);
        let tops = (3..4_000).step_by(40);
        let lost = tops.clone().map(|row| truth[row] - values[row]).sum::<f64>() / tops.count() as f64;
        assert!(lost.abs() < 0.6 * NOISE, "{lost}");
    }

    #[test]
    fn two_lines_through_one_sample_are_no_better_than_what_they_do_not_share() {
        // Least squares of lines through four and five samples on either side of one that they share: by a simulation of the noise.
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let (mut square, mut promised) = (0.0, 0.0);
        const DRAWS: usize = 20_000;
        for _ in 0..DRAWS {
            let values: Vec<f64> = (0..12).map(|_| StandardNormal.sample(&mut rng)).collect();
            let sums = Sums::new(&values);
            let line = |side, count| sums.line(5, side, count).expect("samples enough");
            let both = line(Side::Before, 4).and(line(Side::After, 5));
            square += both.value.powi(2) / DRAWS as f64;
            promised = both.error.powi(2);
        }
        assert!((square / promised - 1.0).abs() < 0.03, "{square} {promised}");
        let own = Estimate { value: 2.0, error: 1.0 };
        assert_eq!(own.and(own).error, 1.0);
    }

    #[test]
    fn without_noise_nothing_changes() {
        let truth: Vec<f64> = (0..3_000).map(|row| (0.01 * row as f64).sin()).collect();
        let Smoothed { values, error } = smoothed(&truth, 1e-9);
        assert!(values.iter().zip(&truth).all(|(one, other)| (one - other).abs() < 1e-6));
        assert!(error <= 1e-9);
        assert!(smoothed(&[], 0.1).values.is_empty());
        assert_eq!(smoothed(&[2.0], 0.1).values, [2.0]);
    }
}
