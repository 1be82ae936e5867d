//! Tails of the distributions that the tests need.

/// The probability that a chi-squared variable of so many degrees of freedom is above `value`, to some 0.001 from five
/// degrees on (Wilson and Hilferty 1931).
pub fn chi_squared_tail(value: f64, freedom: f64) -> f64 {
    let variance = 2.0 / (9.0 * freedom);
    let normal = ((value / freedom).cbrt() - (1.0 - variance)) / variance.sqrt();
    0.5 * libm::erfc(normal / 2.0_f64.sqrt())
}

/// The probability that an F-distributed variable of `above` and `below` degrees of freedom is above `value` >= 0.
pub fn f_tail(value: f64, above: f64, below: f64) -> f64 {
    incomplete_beta(below / 2.0, above / 2.0, below / (below + above * value))
}

/// The regularised incomplete beta function I_x(a, b), by its continued fraction (NIST DLMF 8.17.22), which converges fast
/// below the mean; above it by I_x(a, b) = 1 - I_{1-x}(b, a).
fn incomplete_beta(a: f64, b: f64, x: f64) -> f64 {
    const TERMS: usize = 200;
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - incomplete_beta(b, a, 1.0 - x);
    }
    let term = |k: usize| {
        let m = (k / 2) as f64;
        if k.is_multiple_of(2) {
            m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m))
        } else {
            -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0))
        }
    };
    // From the last term to the first.
    let fraction = (1..=TERMS).rev().fold(1.0, |rest, k| 1.0 + term(k) / rest);
    let ln_beta = libm::lgamma(a) + libm::lgamma(b) - libm::lgamma(a + b);
    (a * x.ln() + b * (1.0 - x).ln() - ln_beta).exp() / (a * fraction)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn five_percent_lie_above_the_tabled_quantiles() {
        for (quantile, freedom) in [(11.070, 5.0), (18.307, 10.0), (31.410, 20.0)] {
            assert!((chi_squared_tail(quantile, freedom) - 0.05).abs() < 1e-3, "{freedom}");
        }
        for (quantile, above, below) in
            [(7.7086, 1.0, 4.0), (3.4903, 3.0, 12.0), (2.9582, 5.0, 14.0), (4.9646, 1.0, 10.0)]
        {
            assert!((f_tail(quantile, above, below) - 0.05).abs() < 1e-5, "{above} {below}");
        }
    }

    #[test]
    fn the_tails_end_at_one_and_zero() {
        assert!((f_tail(0.0, 3.0, 12.0) - 1.0).abs() < 1e-12);
        assert!(f_tail(1e9, 3.0, 12.0) < 1e-12);
        assert!(chi_squared_tail(1e6, 20.0) < 1e-12);
    }
}
