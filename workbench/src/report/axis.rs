//! An axis of a plot: where a value stands on it, and the round numbers beside it.

/// Share of an axis that is left free at either end.
const MARGIN: f64 = 0.04;
/// Powers of ten that are written out.
const PLAIN: std::ops::RangeInclusive<i32> = -3..=3;

/// How values lie on an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scale {
    /// Equal differences are equally far apart.
    #[default]
    Linear,
    /// Equal ratios are; values that are not above 0 have no place.
    Logarithm,
}

impl Scale {
    fn coordinate(self, value: f64) -> f64 {
        match self {
            Self::Linear => value,
            Self::Logarithm if value > 0.0 => value.log10(),
            Self::Logarithm => f64::NAN,
        }
    }
}

/// An axis from its lowest to its highest coordinate.
#[derive(Clone, Copy, Debug)]
pub struct Axis {
    low: f64,
    high: f64,
    scale: Scale,
}

impl Axis {
    /// An axis for these values, and a margin; those without a place are left out.
    pub fn of(values: impl Iterator<Item = f64>, scale: Scale) -> Self {
        let (low, high) = values
            .map(|value| scale.coordinate(value))
            .filter(|coordinate| coordinate.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
        if low > high {
            return Self { low: 0.0, high: 1.0, scale };
        }
        let margin = if high > low { MARGIN * (high - low) } else { 1.0 };
        Self { low: low - margin, high: high + margin, scale }
    }

    /// Lowest and highest coordinate: the values, or their decimal logarithms.
    pub fn ends(&self) -> (f64, f64) {
        (self.low, self.high)
    }

    /// Where a value stands, from 0 at the low end to 1 at the high one; NaN without a place.
    pub fn share(&self, value: f64) -> f64 {
        (self.scale.coordinate(value) - self.low) / (self.high - self.low)
    }

    /// Round values, `most` of them at most, each as its share and its label.
    pub fn ticks(&self, most: usize) -> Vec<(f64, String)> {
        let least = (self.high - self.low) / most as f64;
        let ten = 10f64.powf(least.log10().floor());
        let rounds = [1.0, 2.0, 5.0, 10.0].map(|digit| digit * ten);
        let step = rounds.into_iter().find(|step| *step >= least).unwrap_or(10.0 * ten);
        // Between powers of ten there is no round value of a logarithm.
        let step = if self.scale == Scale::Logarithm { step.max(1.0).ceil() } else { step };
        let decimals = (-step.log10()).ceil().clamp(0.0, 12.0) as usize;
        let (first, last) = ((self.low / step).ceil() as i64, (self.high / step).floor() as i64);
        (first..=last)
            .map(|count| count as f64 * step)
            .map(|at| {
                let label = match self.scale {
                    Scale::Linear => format!("{:.decimals$}", if at == 0.0 { 0.0 } else { at }),
                    Scale::Logarithm => power(at as i32),
                };
                ((at - self.low) / (self.high - self.low), label)
            })
            .collect()
    }
}

/// A power of ten.
fn power(exponent: i32) -> String {
    if PLAIN.contains(&exponent) {
        format!("{:.*}", (-exponent).max(0) as usize, 10f64.powi(exponent))
    } else {
        format!("1e{exponent}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(values: [f64; 2], scale: Scale) -> Vec<String> {
        Axis::of(values.into_iter(), scale).ticks(6).into_iter().map(|(_, label)| label).collect()
    }

    #[test]
    fn ticks_are_round_and_no_more_than_wanted() {
        assert_eq!(labels([0.0, 6.0], Scale::Linear), ["0", "2", "4", "6"]);
        assert_eq!(labels([-0.031, 0.029], Scale::Linear), ["-0.02", "0.00", "0.02"]);
        assert_eq!(labels([1e-5, 1e-2], Scale::Logarithm), ["1e-5", "1e-4", "0.001", "0.01"]);
        for span in [1e-9, 0.7, 3.3, 99.0, 1e7] {
            let count = labels([0.0, span], Scale::Linear).len();
            assert!((2..=6).contains(&count), "{span}: {count}");
        }
    }

    #[test]
    fn a_value_stands_where_its_share_says() {
        let axis = Axis::of([1.0, 100.0].into_iter(), Scale::Logarithm);
        assert!((axis.share(10.0) - 0.5).abs() < 1e-12);
        assert!(axis.share(0.0).is_nan());
    }

    #[test]
    fn an_axis_of_one_value_or_none_has_a_width() {
        for values in [vec![3.0], vec![], vec![f64::NAN]] {
            let (low, high) = Axis::of(values.into_iter(), Scale::Linear).ends();
            assert!(high > low);
        }
    }
}
