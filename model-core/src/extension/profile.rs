//! How strong an effect is over the contraction: piecewise linear through a few knots, constant
//! outside them.

use crate::convert;
use crate::error::{Check, ParameterError, Requirement};
use crate::list::List;
use crate::real::Real;

/// The most knots of a profile.
pub const PROFILE_KNOTS: usize = 4;
/// The largest value of a profile, whatever its unit: no finite sample then leads out of the number
/// type.
const LARGEST: f64 = 1e9;

/// Raw parameters of a profile: one knot, a constant, or more.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "T: Real + serde::Serialize + serde::de::DeserializeOwned")
)]
pub struct ProfileParameters<T> {
    /// Contractions, strictly increasing. Output unit.
    pub knots: List<T, PROFILE_KNOTS>,
    /// The strength at each knot. Unit: that of the effect.
    pub values: List<T, PROFILE_KNOTS>,
}

impl<T: Real> ProfileParameters<T> {
    /// The same strength at every contraction.
    pub fn constant(value: T) -> Self {
        // One fits.
        let list = |number| List::try_from_iter([number]).unwrap_or_default();
        Self { knots: list(T::ZERO), values: list(value) }
    }

    /// The same parameters in another number type.
    pub(crate) fn convert<U: Real>(&self) -> Result<ProfileParameters<U>, ParameterError> {
        Ok(ProfileParameters {
            knots: convert::list("knots", &self.knots)?,
            values: convert::list("values", &self.values)?,
        })
    }
}

/// From a knot to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Piece<T> {
    knot: T,
    value: T,
    slope: T,
}

/// A validated profile.
///
/// ```
/// use model_core::List;
/// use model_core::extension::profile::{Profile, ProfileParameters};
///
/// let list = |numbers: [f64; 2]| List::from_iter(numbers);
/// let profile = ProfileParameters { knots: list([0.0, 100.0]), values: list([1.0, 3.0]) };
/// let profile = Profile::try_new(&profile, "viscous_lag", "bar s/mm")?;
/// assert!((profile.value(50.0) - 2.0).abs() < 1e-12); // straight between knots
/// assert_eq!(profile.value(-10.0), 1.0); // and level before the first
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Profile<T> {
    /// By rising knot. Unused ones begin nowhere.
    pieces: [Piece<T>; PROFILE_KNOTS],
}

impl<T: Real> Profile<T> {
    /// `parameter` and `unit` name the strength in errors.
    ///
    /// # Errors
    /// No knot, lists of different length, knots that do not increase, anything not finite or
    /// beyond 1e9.
    pub fn try_new(
        parameters: &ProfileParameters<T>,
        parameter: &'static str,
        unit: &'static str,
    ) -> Result<Self, ParameterError> {
        let ProfileParameters { knots, values } = parameters;
        if values.len() != knots.len() {
            let requirement = Requirement::Exactly(knots.len() as f64);
            return Err(Check::new(parameter, "").length(values.len(), requirement));
        }
        let Some((&first, &start)) = knots.first().zip(values.first()) else {
            return Err(Check::new("knots", "").length(0, Requirement::AtLeast(1.0)));
        };
        let never = Piece { knot: T::INFINITY, value: T::ZERO, slope: T::ZERO };
        let mut pieces = [never; PROFILE_KNOTS];
        let mut last: Option<&mut Piece<T>> = None;
        let (mut knot, mut value) = (first, start);
        for (i, (piece, (&next_knot, &next_value))) in
            pieces.iter_mut().zip(knots.iter().zip(values)).enumerate()
        {
            let check = Check::at(parameter, i, unit);
            check.at_least(check.at_most(next_value, T::from_f64(LARGEST))?, T::from_f64(-LARGEST))?;
            match last {
                None => Check::at("knots", i, "output unit").finite(next_knot)?,
                Some(ref mut last) => {
                    Check::at("knots", i, "output unit").above(next_knot, knot)?;
                    last.slope = check.finite((next_value - value) / (next_knot - knot))?;
                    next_knot
                }
            };
            (knot, value) = (next_knot, next_value);
            *piece = Piece { knot, value, slope: T::ZERO };
            last = Some(piece);
        }
        Ok(Self { pieces })
    }

    /// As [`try_new`](Self::try_new), and nowhere below 0.
    ///
    /// # Errors
    /// Those, and a negative value.
    pub(super) fn try_positive(
        parameters: &ProfileParameters<T>,
        parameter: &'static str,
        unit: &'static str,
    ) -> Result<Self, ParameterError> {
        for (i, &value) in parameters.values.iter().enumerate() {
            Check::at(parameter, i, unit).at_least(value, T::ZERO)?;
        }
        Self::try_new(parameters, parameter, unit)
    }

    /// The strength at a contraction (output unit).
    #[inline(always)]
    pub fn value(&self, y: T) -> T {
        let [first, others @ ..] = &self.pieces;
        let mut piece = first;
        for other in others {
            if other.knot <= y {
                piece = other;
            }
        }
        piece.value + piece.slope * (y.at_least(first.knot) - piece.knot)
    }
}
