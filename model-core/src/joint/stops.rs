//! The bank of stops: friction over the angle.
//!
//! A stop is a spring that slips: σ follows the angle, but no farther than its reach to either
//! side. It is what a play leaves of its input, σ = φ - play(φ), and its memory is of the same
//! kind.

use crate::error::{Check, ParameterError};
use crate::list::List;
use crate::real::Real;

/// The validated reaches of at most `N` stops. Unit: rad.
#[derive(Clone, Debug, PartialEq)]
pub struct Thresholds<T, const N: usize> {
    reaches: List<T, N>,
}

/// Where the stops are.
///
/// ```
/// use model_core::List;
/// use model_core::joint::stops::{Stops, Thresholds};
///
/// let thresholds = Thresholds::<f64, 2>::try_new(&List::from([0.1, 0.5]))?;
/// let mut stops = Stops::relaxed(0.0);
/// thresholds.turn(&mut stops, 0.3);
/// assert_eq!(stops.moved(), &[0.1, 0.3]); // rad: the first one slips
/// thresholds.turn(&mut stops, 0.25);
/// assert!((stops.moved()[0] - 0.05).abs() < 1e-12); // and sticks behind the reversal
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Stops<T, const N: usize> {
    /// Unit: rad.
    angle: T,
    /// σ of each. Unit: rad.
    pub(super) moved: [T; N],
}

impl<T: Real, const N: usize> Stops<T, N> {
    /// Stops without tension at an angle (rad).
    pub fn relaxed(angle: T) -> Self {
        Self { angle, moved: [T::ZERO; N] }
    }

    /// The angle that they are at. Unit: rad.
    pub fn angle(&self) -> T {
        self.angle
    }

    /// How far each is from where it has no tension, as far as there are stops. Unit: rad.
    pub fn moved(&self) -> &[T] {
        &self.moved
    }
}

impl<T: Real, const N: usize> Thresholds<T, N> {
    /// # Errors
    /// A reach that is not above the one before, or the first not above 0.
    pub fn try_new(reaches: &List<T, N>) -> Result<Self, ParameterError> {
        let mut last = T::ZERO;
        for (i, reach) in reaches.iter().enumerate() {
            last = Check::at("reaches", i, "rad").above(*reach, last)?;
        }
        Ok(Self { reaches: reaches.clone() })
    }

    /// Turns the stops to an angle (rad).
    #[inline(always)]
    pub fn turn(&self, stops: &mut Stops<T, N>, angle: T) {
        let by = angle - stops.angle;
        stops.angle = angle;
        for (moved, reach) in stops.moved.iter_mut().zip(&self.reaches) {
            *moved = (*moved + by).limit(-*reach, *reach);
        }
    }
}
