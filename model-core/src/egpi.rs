//! The extended generalized Prandtl-Ishlinskii model (EGPI): the asymmetric one and a memoryless
//! function.
//!
//! y = A\[x\] + g(x) with A the [`crate::agpi`] and g the cubic of [`crate::memoryless`].
//!
//! # The inverse, and its proof
//! There is no closed form. With s = A\[x\] the wanted s is the fixed point of s = y - g(A⁻¹\[s\]),
//! the iteration of the literature. Within one direction A⁻¹ is non-decreasing with slopes of at
//! most 1/μ, μ the least slope of A over the range, so that h = g ∘ A⁻¹ has slopes between a =
//! min(0, min g')/μ and b = max(0, max g')/μ. If 1 + a > 0, the residual y - s - h(s), which is the
//! error of forward of inverse, falls everywhere with slopes between -(1 + a) and -(1 + b): there
//! is one fixed point, and every residual says on which side of it s lies.
//!
//! The relaxed iteration s ← s + ω (y - s - h(s)) with ω = 2/(2 + a + b) contracts by ρ = (b -
//! a)/(2 + a + b). Where ρ is at most 1/2, that is the step; where it is not, the step goes to the
//! middle of the bracket of the residuals so far, which is at most max g - min g wide at first.
//! Either way the distance of the bound is halved in each step, so that log₂((max g - min g)(1 +
//! b)/tolerance) + 1 steps reach the tolerance. A model that needs more than [`STEPS`], or has 1 +
//! a ≤ 0, is refused when the inverse is made.
//!
//! # Accuracy
//! Forward of inverse within [`InverseEgpi::tolerance`]. What [`crate::agpi`] says of reversals
//! holds here.

use crate::agpi::{Agpi, AgpiParameters, InverseAgpi, is_rounding, leads_on};
use crate::error::{Check, InputError, ParameterError, finite_input};
use crate::hysteresis::{Hysteresis, HysteresisState, InverseHysteresis, Invertible, Sample};
use crate::memoryless::{Memoryless, MemorylessParameters};
use crate::play::PlayState;
use crate::range::Range;
use crate::real::Real;

/// The most steps that an inverse may need.
pub const STEPS: u16 = 64;
/// The tolerance of the inverse as a share of the output span, as far as the number type allows.
const TOLERANCE: f64 = 1e-10;

/// Raw parameters of an EGPI model with at most `N` plays.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "T: Real + serde::Serialize + serde::de::DeserializeOwned")
)]
pub struct EgpiParameters<T, const N: usize> {
    /// A.
    pub agpi: AgpiParameters<T, N>,
    /// g.
    pub memoryless: MemorylessParameters<T>,
}

impl<T: Real, const N: usize> EgpiParameters<T, N> {
    /// The same parameters in another number type or capacity.
    ///
    /// # Errors
    /// The other capacity is too small.
    pub fn convert<U: Real, const N2: usize>(&self) -> Result<EgpiParameters<U, N2>, ParameterError> {
        Ok(EgpiParameters { agpi: self.agpi.convert()?, memoryless: self.memoryless.convert() })
    }
}

/// A validated EGPI model with at most `N` plays.
#[derive(Clone, Debug, PartialEq)]
pub struct Egpi<T, const N: usize> {
    agpi: Agpi<T, N>,
    memoryless: Memoryless<T>,
}

impl<T: Real, const N: usize> Egpi<T, N> {
    /// # Errors
    /// The first parameter that no model can be made of.
    pub fn try_new(parameters: &EgpiParameters<T, N>) -> Result<Self, ParameterError> {
        let agpi = Agpi::try_new(&parameters.agpi)?;
        let memoryless = Memoryless::try_new(&parameters.memoryless, agpi.input_range())?;
        Ok(Self { agpi, memoryless })
    }

    /// The asymmetric part.
    pub fn agpi(&self) -> &Agpi<T, N> {
        &self.agpi
    }
}

impl<T: Real, const N: usize> Hysteresis<T, N> for Egpi<T, N> {
    fn input_range(&self) -> &Range<T> {
        self.agpi.input_range()
    }

    /// The state of the asymmetric part.
    fn rest_state(&self) -> HysteresisState<T, N> {
        self.agpi.rest_state()
    }

    fn step(&self, state: &mut HysteresisState<T, N>, x: T) -> Result<T, InputError> {
        Ok(self.agpi.step(state, x)? + self.memoryless.value(x))
    }
}

impl<T: Real, const N: usize> Invertible<T, N> for Egpi<T, N> {
    type Inverse = InverseEgpi<T, N>;

    fn inverse(&self) -> Result<Self::Inverse, ParameterError> {
        let least = self.agpi.least_slope();
        let (falls, rises) = self.memoryless.slopes();
        let share = |slope: T| slope / least;
        let a = if falls < T::ZERO { share(falls) } else { T::ZERO };
        let b = if rises > T::ZERO { share(rises) } else { T::ZERO };
        Check::new("least slope of the output over the input, relative to that of its hysteretic part", "")
            .above(T::ONE + a, T::ZERO)?;
        let two = T::from_f64(2.0);
        let (low, high) = self.output_range();
        let span = (high - low).abs();
        let resolution = 32.0 * T::EPSILON.to_f64();
        let tolerance = Check::new("output range", "output unit").above(
            span * T::from_f64(if TOLERANCE > resolution { TOLERANCE } else { resolution }),
            T::ZERO,
        )?;
        let (least, most) = self.memoryless.values();
        let inverse = InverseEgpi {
            agpi: self.agpi.inverse()?,
            memoryless: self.memoryless,
            relaxation: (b - a <= (two + a + b) / two).then_some(two / (two + a + b)),
            memoryless_range: (least, most),
            tolerance,
        };
        let steps = steps(((most - least) * (T::ONE + b) / tolerance).to_f64());
        Check::new("steps of the fixed-point inverse", "").at_most(steps, f64::from(STEPS))?;
        Ok(inverse)
    }
}

/// How many halving steps bring the residual down by a ratio, and one more; more than [`STEPS`] are
/// not counted.
fn steps(ratio: f64) -> f64 {
    let (mut left, mut steps) = (ratio, 1.0);
    for _ in 0..STEPS {
        if left <= 1.0 {
            break;
        }
        left /= 2.0;
        steps += 1.0;
    }
    steps
}

/// The inverse of an [`Egpi`].
#[derive(Clone, Debug, PartialEq)]
pub struct InverseEgpi<T, const N: usize> {
    agpi: InverseAgpi<T, N>,
    memoryless: Memoryless<T>,
    /// ω, where the relaxed iteration contracts by a half or better.
    relaxation: Option<T>,
    /// Least and largest value of g.
    memoryless_range: (T, T),
    tolerance: T,
}

impl<T: Real, const N: usize> InverseEgpi<T, N> {
    /// How near forward of inverse comes to the wanted output. Unit: output unit.
    pub fn tolerance(&self) -> T {
        self.tolerance
    }

    /// Input and output at the end of the range in a direction.
    fn end(&self, plays: &PlayState<T, N>, rising: bool) -> (T, T) {
        let (x, s) = self.agpi.end(plays, rising);
        (x, s + self.memoryless.value(x))
    }
}

impl<T: Real, const N: usize> InverseHysteresis<T, N> for InverseEgpi<T, N> {
    fn state_of(&self, state: &HysteresisState<T, N>) -> HysteresisState<T, N> {
        let mut inverse = self.agpi.state_of(state);
        inverse.last.y += self.memoryless.value(inverse.last.x);
        inverse
    }

    fn rest_state(&self) -> HysteresisState<T, N> {
        let mut inverse = self.agpi.rest_state();
        inverse.last.y += self.memoryless.value(inverse.last.x);
        inverse
    }

    fn last_output(&self, state: &HysteresisState<T, N>) -> T {
        state.last.y
    }

    /// Not inlined, to avoid register spills of the cascade where the model is chosen at run time.
    #[inline(never)]
    fn step(&self, state: &mut HysteresisState<T, N>, y: T) -> Result<T, InputError> {
        let y = finite_input(y)?;
        let last = state.last;
        let rising = y > last.y;
        if is_rounding(y, last.y)
            || (rising != last.rising && !leads_on(&last, self.end(&state.plays, rising)))
        {
            return Ok(last.x);
        }
        let (mut low, mut high) = (y - self.memoryless_range.1, y - self.memoryless_range.0);
        let mut s = (y - self.memoryless.value(last.x)).limit(low, high);
        for _ in 0..STEPS {
            let x = self.agpi.drive(&mut state.plays.clone(), last.x, self.agpi.inner(s), rising);
            let residual = y - s - self.memoryless.value(x);
            if residual.abs() <= self.tolerance {
                break;
            }
            if residual > T::ZERO {
                low = s;
            } else {
                high = s;
            }
            let next = match self.relaxation {
                Some(relaxation) => s + relaxation * residual,
                None => low + (high - low) * T::from_f64(0.5),
            };
            // The number type has no value between the two sides of the fixed point.
            if next == s {
                break;
            }
            s = next;
        }
        let u = self.agpi.inner(s);
        let x = self.agpi.drive(&mut state.plays, last.x, u, rising);
        // Beyond an end of the range the end is remembered, not the demand, as everywhere in the
        // family.
        let is_reached = state.plays.input() == u;
        let y = if is_reached { y } else { self.agpi.reached(&state.plays) + self.memoryless.value(x) };
        state.last = Sample { x, y, rising };
        Ok(x)
    }
}
