//! How large a gain has to be, in its standard errors, not to be by chance.
//!
//! Of several things that gain nothing in truth the luckiest one gains something. Where `judges` that do not see the same have all to find
//! a gain of so many standard errors z, one thing passes by chance with the probability (1 - Φ(z))^judges, and one of `asked` with at most
//! `asked` times that, which is the level that is stated; a cause that may be many things ([`hypotheses`](super::causes::Kind::hypotheses)) is
//! asked as often. Φ is the normal distribution's.

/// The level of errors at which a cause that was not named is said not to be excluded, the usual one of such statements.
pub const NOT_EXCLUDED: f64 = 0.05;
/// The level at which a larger set is, that the search alone is for.
pub const FOUND: f64 = 0.01;
/// Halvings of the interval in which z is: to far below what it is worth.
const HALVINGS: usize = 40;
/// The largest z that is looked for, in standard errors: beyond it a chance is below one in 10^15.
const LARGEST: f64 = 8.0;

/// That many standard errors: at least 0.
pub fn standard_errors(level: f64, asked: usize, judges: i32) -> f64 {
    let share = (level / asked.max(1) as f64).powf(1.0 / f64::from(judges));
    let (mut low, mut high) = (0.0, LARGEST);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        let beyond = 0.5 * libm::erfc(middle * std::f64::consts::FRAC_1_SQRT_2);
        if beyond > share { low = middle } else { high = middle }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_is_so_many_standard_errors_of_the_normal_distribution() {
        let within = |z: f64, expected: f64| assert!((z - expected).abs() < 0.005, "{z} {expected}");
        within(standard_errors(0.05, 1, 1), 1.645);
        within(standard_errors(0.01, 1, 1), 2.326);
        // The more are asked the larger, the more judges the smaller.
        within(standard_errors(0.01, 8, 1), 3.023);
        within(standard_errors(0.05, 8, 2), 1.412);
        assert_eq!(standard_errors(0.6, 1, 1), 0.0);
    }
}
