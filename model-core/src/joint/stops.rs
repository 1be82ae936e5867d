//! The banks of stops: friction over the angle, a bank for each muscle.
//!
//! A stop is a spring that slips: σ follows the angle, but no farther than its reach to either
//! side. It is what a play leaves of its input, σ = φ - play(φ), and its memory is of the same
//! kind.
//!
//! The force at which a thread slips on another grows with what presses them together; how stiffly
//! they hold before does not. So a muscle's pressure widens the reaches of its bank, all by one
//! factor, and when it falls what is stuck farther than the reach slips, though the angle stands
//! still (Maxwell slip, for muscles Vo-Minh et al. 2011).

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
/// thresholds.turn(&mut stops, 0.3, [1.0, 2.0]);
/// assert_eq!(stops.moved(), [&[0.1, 0.3], &[0.2, 0.3]]); // rad: the first ones slip
/// thresholds.turn(&mut stops, 0.25, [1.0, 2.0]);
/// assert!((stops.moved()[0][0] - 0.05).abs() < 1e-12); // and stick behind the reversal
/// thresholds.turn(&mut stops, 0.25, [0.4, 2.0]);
/// assert!((stops.moved()[0][0] - 0.04).abs() < 1e-12); // the first muscle's pressure falls
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Stops<T, const N: usize> {
    /// Unit: rad.
    angle: T,
    /// σ of each, of both banks. Unit: rad.
    pub(super) moved: [[T; N]; 2],
}

impl<T: Real, const N: usize> Stops<T, N> {
    /// Stops without tension at an angle (rad).
    pub fn relaxed(angle: T) -> Self {
        Self { angle, moved: [[T::ZERO; N]; 2] }
    }

    /// The angle that they are at. Unit: rad.
    pub fn angle(&self) -> T {
        self.angle
    }

    /// How far each is from where it has no tension, of both banks, as far as there are stops.
    /// Unit: rad.
    pub fn moved(&self) -> [&[T]; 2] {
        self.moved.each_ref().map(<[T; N]>::as_slice)
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

    /// The reaches. Unit: rad.
    pub(super) fn reaches(&self) -> &[T] {
        &self.reaches
    }

    /// Turns the stops to an angle (rad), the reaches of either bank wider by a factor.
    #[inline(always)]
    pub fn turn(&self, stops: &mut Stops<T, N>, angle: T, factors: [T; 2]) {
        let by = angle - stops.angle;
        stops.angle = angle;
        for (bank, factor) in stops.moved.iter_mut().zip(factors) {
            for (moved, reach) in bank.iter_mut().zip(&self.reaches) {
                let reach = factor * *reach;
                *moved = (*moved + by).limit(-reach, reach);
            }
        }
    }
}
