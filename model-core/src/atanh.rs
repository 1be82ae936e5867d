//! Inverse hyperbolic tangent of a ratio in single precision, for the tick.
//!
//! atanh((a - b)/(a + b)) = ½ ln(a/b). A power of two brings a within a factor of 2/3 to 3/2 of b,
//! taken from the difference of their bits: a step of 2²³ there is a factor of two. Then (a -
//! b)/(a + b) lies within ±1/5, where an odd polynomial of degree 5 (minimax, 5.1e-8) gives the
//! inverse hyperbolic tangent; the power adds its multiple of ½ ln 2. One division, no table, no
//! branch; `libm`'s takes four times the instructions.
//!
//! # Accuracy
//! Of atanh(t), which is that of a = 1 + t and b = 1 - t: absolute error at most [`ERROR`] for
//! every `f32` from -1 to 1, both excluded, and [`ERROR_INSIDE`] from -0.98 to 0.98; a test goes
//! through all floats from 2⁻²⁰ on. The relative error near 0 is not bounded, nor needed: the
//! result is added to a constant.

/// Largest absolute error from -1 to 1, both excluded: near the ends half a unit in the last place
/// of the result.
pub const ERROR: f32 = 5.6e-7;
/// Largest absolute error from -0.98 to 0.98.
pub const ERROR_INSIDE: f32 = 2e-7;

/// Coefficients of s³ and s⁵.
const COEFFICIENTS: [f32; 2] = [0.333_209_35, 0.208_839_04];
/// Bits of the mantissa.
const MANTISSA_BITS: u32 = 23;
const HALF_LN_2: f32 = 0.346_573_6;

/// atanh((a - b)/(a + b)) for a and b above 0 and below a quarter of the largest number.
///
/// ```
/// use model_core::atanh::{ERROR, atanh_of_ratio};
///
/// let exact = (-1.0_f64 / 3.0).atanh(); // of (1 - 2)/(1 + 2)
/// assert!((f64::from(atanh_of_ratio(1.0, 2.0)) - exact).abs() <= f64::from(ERROR));
/// ```
#[inline(always)]
pub fn atanh_of_ratio(a: f32, b: f32) -> f32 {
    let (a_bits, b_bits) = (a.to_bits() as i32, b.to_bits() as i32);
    // The nearest whole number of doublings from b to a.
    let doublings = (a_bits.wrapping_sub(b_bits).wrapping_add(1 << (MANTISSA_BITS - 1))) >> MANTISSA_BITS;
    let a = f32::from_bits(a_bits.wrapping_sub(doublings << MANTISSA_BITS) as u32);
    let s = (a - b) / (a + b);
    let z = s * s;
    let [c3, c5] = COEFFICIENTS;
    (s + s * z * (c3 + z * c5)) + doublings as f32 * HALF_LN_2
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;

    fn atanh(t: f32) -> f32 {
        atanh_of_ratio(1.0 + t, 1.0 - t)
    }

    /// The largest error over the floats between two bit patterns, every `stride`-th.
    fn worst(bits: core::ops::Range<u32>, stride: usize) -> f64 {
        let error = |bits: u32| {
            let t = f32::from_bits(bits);
            (f64::from(atanh(t)) - libm::atanh(f64::from(t))).abs()
        };
        bits.step_by(stride).map(error).fold(0.0, f64::max)
    }

    #[test]
    fn the_error_is_bounded_over_all_floats_of_the_range() {
        let (zero, small, inside, one) = (0, 2_f32.powi(-20).to_bits(), 0.98_f32.to_bits(), 1_f32.to_bits());
        let below = dense(small..inside).max(worst(zero..small, 1009));
        let above = dense(inside..one);
        std::println!("largest error of atanh: {below:.2e} below 0.98, {above:.2e} above");
        for (found, bound) in [(below, ERROR_INSIDE), (above, ERROR)] {
            assert!(found <= f64::from(bound), "{found:e} is above {bound:e}");
            assert!(found >= 0.5 * f64::from(bound), "{found:e}: {bound:e} is loose, tighten it");
        }
    }

    /// [`worst`] over every bit pattern, side by side.
    fn dense(bits: core::ops::Range<u32>) -> f64 {
        const PARTS: u32 = 8;
        let part = (bits.end - bits.start).div_ceil(PARTS);
        let searches: std::vec::Vec<_> = (0..PARTS)
            .map(|k| bits.start + k * part..(bits.start + (k + 1) * part).min(bits.end))
            .map(|bits| std::thread::spawn(move || worst(bits, 1)))
            .collect();
        searches.into_iter().map(|search| search.join().expect("no panic")).fold(0.0, f64::max)
    }

    #[test]
    fn it_is_nearly_odd_and_right_for_ratios_of_all_magnitudes() {
        for k in -1990..=1990 {
            let t = k as f32 / 2000.0;
            assert!((atanh(-t) + atanh(t)).abs() <= 2.0 * ERROR, "{t}");
        }
        for (a, b) in [(1e30, 1e-30), (1e-30, 1e30), (6e37, 4e37), (2e-38, 4e-38), (7.0, 7.0)] {
            let exact = 0.5 * (libm::log(f64::from(a)) - libm::log(f64::from(b)));
            assert!(
                (f64::from(atanh_of_ratio(a, b)) - exact).abs() <= 1e-7 * exact.abs().max(2.0),
                "{a}, {b}"
            );
        }
    }
}
