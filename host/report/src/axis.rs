//! An axis of a plot: where a value stands on it, and the round numbers beside it.

/// Share of an axis that is left free at either end.
const MARGIN: f64 = 0.04;
/// Powers of ten that are written out.
const PLAIN: std::ops::RangeInclusive<i32> = -4..=5;
/// Most numbers at a logarithmic axis: where three stand in a decade, four letters have room
/// between two of them.
const MOST_LOGARITHMIC: usize = 10;
/// Fewer round numbers than these tell nothing of a logarithmic axis.
const LEAST_LOGARITHMIC: usize = 3;

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

    /// Round values, `most` of them at most, each as its share of the axis and its label. `plot.js`
    /// does the same when it enlarges a plot.
    pub fn ticks(&self, most: usize) -> Vec<(f64, String)> {
        let share = |coordinate: f64| (coordinate - self.low) / (self.high - self.low);
        let values = match self.scale {
            Scale::Linear => round_values(self.low, self.high, most),
            Scale::Logarithm => self.logarithmic_ticks(most),
        };
        values.into_iter().map(|(value, label)| (share(self.scale.coordinate(value)), label)).collect()
    }

    /// 1, 2 and 5 of each decade where there is room, else its 1; below a decade the round values
    /// of a linear axis.
    fn logarithmic_ticks(&self, most: usize) -> Vec<(f64, String)> {
        let decades = self.low.floor() as i32..=self.high.ceil() as i32;
        let of = |digits: &[u32]| -> Vec<(f64, String)> {
            let all = decades.clone().flat_map(|exponent| digits.iter().map(move |&digit| (digit, exponent)));
            let values = all.map(|(digit, exponent)| (logarithmic_value(digit, exponent), digit, exponent));
            let inside = values.filter(|(value, ..)| (self.low..=self.high).contains(&value.log10()));
            inside.map(|(value, digit, exponent)| (value, plain(digit, exponent))).collect()
        };
        let close = of(&[1, 2, 5]);
        if close.len() < LEAST_LOGARITHMIC {
            return round_values(10f64.powf(self.low), 10f64.powf(self.high), most);
        }
        if close.len() <= MOST_LOGARITHMIC {
            return close;
        }
        let whole = of(&[1]);
        let every = whole.len().div_ceil(most);
        whole.into_iter().step_by(every).collect()
    }
}

/// Multiples of 1, 2 or 5 times a power of ten between two ends, `most` of them at most, with their
/// labels.
fn round_values(low: f64, high: f64, most: usize) -> Vec<(f64, String)> {
    let least = (high - low) / most as f64;
    let ten = 10f64.powf(least.log10().floor());
    let rounds = [1.0, 2.0, 5.0, 10.0].map(|digit| digit * ten);
    let step = rounds.into_iter().find(|step| *step >= least).unwrap_or(10.0 * ten);
    let decimals = (-step.log10()).ceil().clamp(0.0, 12.0) as usize;
    let (first, last) = ((low / step).ceil() as i64, (high / step).floor() as i64);
    let values = (first..=last).map(|count| if count == 0 { 0.0 } else { count as f64 * step });
    values.map(|value| (value, format!("{value:.decimals$}"))).collect()
}

/// A digit times a power of ten.
fn logarithmic_value(digit: u32, exponent: i32) -> f64 {
    f64::from(digit) * 10f64.powi(exponent)
}

/// A digit times a power of ten as a label.
fn plain(digit: u32, exponent: i32) -> String {
    if PLAIN.contains(&exponent) {
        return format!("{:.*}", (-exponent).max(0) as usize, logarithmic_value(digit, exponent));
    }
    let raised = |letter| match letter {
        '-' => '⁻',
        _ => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][letter.to_digit(10).unwrap_or(0) as usize],
    };
    let power: String = "10".chars().chain(exponent.to_string().chars().map(raised)).collect();
    if digit == 1 { power } else { format!("{digit}·{power}") }
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
        for span in [1e-9, 0.7, 3.3, 99.0, 1e7] {
            let count = labels([0.0, span], Scale::Linear).len();
            assert!((2..=6).contains(&count), "{span}: {count}");
        }
    }

    #[test]
    fn logarithmic_ticks_are_1_2_and_5_where_there_is_room_and_plain() {
        let logarithm = |low, high| labels([low, high], Scale::Logarithm);
        assert_eq!(logarithm(0.9, 12.0), ["1", "2", "5", "10"]);
        assert_eq!(logarithm(0.01, 10.0), ["0.01", "0.02", "0.05", "0.1", "0.2", "0.5", "1", "2", "5", "10"]);
        assert_eq!(logarithm(1e-6, 1e-1), ["10⁻⁶", "10⁻⁵", "0.0001", "0.001", "0.01", "0.1"]);
        assert_eq!(logarithm(1e-5, 3e-4), ["10⁻⁵", "2·10⁻⁵", "5·10⁻⁵", "0.0001", "0.0002"]);
        assert_eq!(logarithm(3.1, 4.2), ["3.0", "3.2", "3.4", "3.6", "3.8", "4.0", "4.2"][1..]);
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
