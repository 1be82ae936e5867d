//! Figures of a list of numbers that several modules need.

/// The median of the size of a normal variable, in standard deviations.
pub const NORMAL_MEDIAN: f64 = 0.6745;
/// Standard errors that a bound stands above a mean: 95 % of a normal error.
pub const STANDARD_ERRORS: f64 = 2.0;

/// The lowest and the highest value; of none, the highest and the lowest that there are.
pub fn range<'a>(values: impl IntoIterator<Item = &'a f64>) -> (f64, f64) {
    let widen = |(low, high): (f64, f64), &v: &f64| (low.min(v), high.max(v));
    values.into_iter().fold((f64::INFINITY, f64::NEG_INFINITY), widen)
}

/// The middle value, in whatever order they come; 0 of none. Leaves the list in another order.
pub fn median(values: &mut [f64]) -> f64 {
    let middle = values.len() / 2;
    if values.is_empty() {
        return 0.0;
    }
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Whether the mean of differences is no more than [`STANDARD_ERRORS`] of its own above nothing.
pub fn is_within_chance(differences: &[f64]) -> bool {
    let count = differences.len() as f64;
    let mean = differences.iter().sum::<f64>() / count;
    let squares: f64 = differences.iter().map(|one| (one - mean).powi(2)).sum();
    mean <= STANDARD_ERRORS * (squares / (count * (count - 1.0))).sqrt()
}

/// A number in words that does not look like a limit that it differs from: with as many decimals as
/// that takes, and at least so many.
pub fn apart(value: f64, limit: f64, decimals: usize) -> String {
    const MOST: usize = 9;
    let mut texts = (decimals..=MOST).map(|decimals| format!("{value:.decimals$}"));
    texts.clone().find(|text| text.parse() != Ok(limit)).or(texts.next_back()).unwrap_or_default()
}

/// A number with so many decimals, and with as many more as show two digits of it: small units make
/// small numbers. What is smaller than a nanometre in metres is the rounding of a 0, and gets no
/// more decimals.
pub fn legible(value: f64, decimals: usize) -> String {
    const MOST: f64 = 10.0;
    let needed = if value == 0.0 { 0.0 } else { 1.0 - value.abs().log10().floor() };
    let decimals = if needed > MOST { decimals } else { decimals.max(needed.max(0.0) as usize) };
    format!("{value:.decimals$}")
}

/// The values that the given share lies below and above; 0 of none.
pub fn quantiles(values: &[f64], share: f64) -> (f64, f64) {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().saturating_sub(1);
    let at = |share: f64| sorted.get((share * last as f64).round() as usize).copied().unwrap_or(0.0);
    (at(share), at(1.0 - share))
}

/// Root of the mean square; 0 of none.
pub fn root_mean_square(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

/// The way so far of what follows the values at the distance of `band`, as a play does: noise
/// within it adds none.
///
/// ```
/// use recording::numbers::travel;
///
/// assert_eq!(travel(&[0.0, 0.1, -0.1, 2.0], 0.5), [0.0, 0.0, 0.0, 1.5]); // noise within the band adds none
/// ```
pub fn travel(values: &[f64], band: f64) -> Vec<f64> {
    let mut held = values.first().copied().unwrap_or(0.0);
    let mut way = 0.0;
    let mut go = |&value: &f64| {
        let next = held.clamp(value - band, value + band);
        way += (next - held).abs();
        held = next;
        way
    };
    values.iter().map(&mut go).collect()
}

/// A number with three digits that count.
pub fn significant(value: f64) -> String {
    let size = value.abs();
    let decimals = if size > 0.0 { (2.0 - size.log10().floor()).clamp(0.0, 12.0) as usize } else { 0 };
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_of_five_numbers_are_those_by_hand() {
        let values = [3.0, -1.0, 4.0, 0.0, 2.0];
        assert_eq!(range(&values), (-1.0, 4.0));
        assert_eq!(median(&mut values.to_vec()), 2.0);
        assert_eq!(quantiles(&values, 0.25), (0.0, 3.0));
        assert_eq!(root_mean_square(&values), 6.0_f64.sqrt());
    }

    #[test]
    fn differences_are_within_chance_unless_their_mean_is_two_standard_errors_above_nothing() {
        // A mean of 1 with a standard error of 0.58, and one with 0.29.
        assert!(is_within_chance(&[0.0, 1.0, 2.0]));
        assert!(!is_within_chance(&[0.5, 1.0, 1.5]));
        assert!(is_within_chance(&[-0.5, -1.0, -1.5]));
    }

    #[test]
    fn a_number_does_not_look_like_the_limit_that_it_differs_from() {
        assert_eq!(
            [apart(19.98, 20.0, 0), apart(9.99, 10.0, 1), apart(3.2, 10.0, 1)],
            ["19.98", "9.99", "3.2"]
        );
        assert_eq!(apart(20.0, 20.0, 0), "20.000000000");
    }

    #[test]
    fn two_digits_of_a_number_are_shown_however_small_its_unit_makes_it() {
        let texts = [(12.3456, "12.346"), (0.0123, "0.012"), (0.000_123, "0.00012"), (-0.004, "-0.0040")];
        for (value, text) in texts {
            assert_eq!(legible(value, 3), text);
        }
        assert_eq!(legible(3e-14, 4), "0.0000");
        assert_eq!((legible(0.0, 2), legible(f64::NAN, 2)), ("0.00".to_owned(), "NaN".to_owned()));
    }

    #[test]
    fn nothing_has_figures_too() {
        assert_eq!((median(&mut []), quantiles(&[], 0.1), root_mean_square(&[])), (0.0, (0.0, 0.0), 0.0));
        assert!(travel(&[], 1.0).is_empty());
    }

    #[test]
    fn a_reversal_costs_the_band_and_noise_within_it_adds_no_way() {
        assert_eq!(travel(&[0.0, 0.4, -0.4, 3.0, 2.6, 0.0], 0.5), [0.0, 0.0, 0.0, 2.5, 2.5, 4.5]);
    }
}
