//! A model of the family that is chosen at run time: what a model file holds and the board gets.

use core::fmt;

use crate::agpi::{Agpi, AgpiParameters, InverseAgpi};
use crate::cascade::{Cascade, CascadeParameters, InverseCascade};
use crate::egpi::{Egpi, EgpiParameters, InverseEgpi};
use crate::envelope::{AnyEnvelope, EnvelopeParameters};
use crate::error::{InputError, ParameterError};
use crate::hysteresis::{Hysteresis, HysteresisState, InverseHysteresis, Invertible};
use crate::range::Range;
use crate::real::Real;

/// The members of the family.
///
/// ```
/// use model_core::Kind;
///
/// assert_eq!(Kind::ALL.map(Kind::name), ["cpi", "sgpi", "agpi", "mpi", "egpi", "mgpi"]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Classical, see [`crate::cpi`].
    Cpi,
    /// Symmetric generalized, see [`crate::sgpi`].
    Sgpi,
    /// Asymmetric generalized, see [`crate::agpi`].
    Agpi,
    /// Kuhnen's modified, see [`crate::mpi`].
    Mpi,
    /// Extended generalized, see [`crate::egpi`].
    Egpi,
    /// Modified generalized, see [`crate::mgpi`].
    Mgpi,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 6] = [Self::Cpi, Self::Sgpi, Self::Agpi, Self::Mpi, Self::Egpi, Self::Mgpi];

    /// The name in commands and model files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cpi => "cpi",
            Self::Sgpi => "sgpi",
            Self::Agpi => "agpi",
            Self::Mpi => "mpi",
            Self::Egpi => "egpi",
            Self::Mgpi => "mgpi",
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Raw parameters of a model with at most `N` plays and `M` dead zones.
///
/// ```
/// use model_core::{Kind, ModelParameters};
///
/// let muscle = ModelParameters::Cascade(model_core::paper::mgpi()?);
/// assert_eq!((muscle.kind(), muscle.input()), (Kind::Mgpi, (0.0, 6.0)));
/// let on_board: ModelParameters<f32, 16, 16> = muscle.convert()?;
/// assert!(muscle.convert::<f32, 4, 4>().is_err()); // ten plays do not fit in four places
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "T: Real + serde::Serialize + serde::de::DeserializeOwned")
)]
pub enum ModelParameters<T, const N: usize, const M: usize> {
    /// CPI, SGPI, MPI or MGPI.
    Cascade(CascadeParameters<T, N, M>),
    /// AGPI.
    Agpi(AgpiParameters<T, N>),
    /// EGPI.
    Egpi(EgpiParameters<T, N>),
}

impl<T: Real, const N: usize, const M: usize> ModelParameters<T, N, M> {
    /// Which model it is: for a cascade, the poorest one of these parameters.
    pub fn kind(&self) -> Kind {
        match self {
            Self::Cascade(cascade) => match (&cascade.envelope, cascade.dead_zones.weights.len()) {
                (EnvelopeParameters::Identity, 0 | 1) => Kind::Cpi,
                (EnvelopeParameters::Identity, _) => Kind::Mpi,
                (_, 0 | 1) => Kind::Sgpi,
                _ => Kind::Mgpi,
            },
            Self::Agpi(_) => Kind::Agpi,
            Self::Egpi(_) => Kind::Egpi,
        }
    }

    /// Lower and upper end of the inputs that the model is valid for. Input unit.
    pub fn input(&self) -> (T, T) {
        match self {
            Self::Cascade(CascadeParameters { input_min, input_max, .. })
            | Self::Agpi(AgpiParameters { input_min, input_max, .. })
            | Self::Egpi(EgpiParameters { agpi: AgpiParameters { input_min, input_max, .. }, .. }) => {
                (*input_min, *input_max)
            }
        }
    }

    /// Whether the muscle has been through its whole range before.
    pub fn is_preconditioned(&self) -> bool {
        match self {
            Self::Cascade(CascadeParameters { preconditioned, .. })
            | Self::Agpi(AgpiParameters { preconditioned, .. })
            | Self::Egpi(EgpiParameters { agpi: AgpiParameters { preconditioned, .. }, .. }) => {
                *preconditioned
            }
        }
    }

    /// These parameters, with that said of the muscle.
    #[must_use]
    pub fn with_preconditioned(mut self, said: bool) -> Self {
        match &mut self {
            Self::Cascade(CascadeParameters { preconditioned, .. })
            | Self::Agpi(AgpiParameters { preconditioned, .. })
            | Self::Egpi(EgpiParameters { agpi: AgpiParameters { preconditioned, .. }, .. }) => {
                *preconditioned = said;
            }
        }
        self
    }

    /// The same parameters in another number type or capacity, for instance those of the board.
    ///
    /// # Errors
    /// The other capacity is too small.
    pub fn convert<U: Real, const N2: usize, const M2: usize>(
        &self,
    ) -> Result<ModelParameters<U, N2, M2>, ParameterError> {
        Ok(match self {
            Self::Cascade(cascade) => ModelParameters::Cascade(cascade.convert()?),
            Self::Agpi(agpi) => ModelParameters::Agpi(agpi.convert()?),
            Self::Egpi(egpi) => ModelParameters::Egpi(egpi.convert()?),
        })
    }
}

/// A validated model.
///
/// ```
/// use model_core::{Hysteresis, Model, ModelParameters};
///
/// let muscle = Model::try_new(&ModelParameters::Cascade(model_core::paper::mgpi()?))?;
/// assert!(muscle.smallest_output_slope() > 0.0); // mm/bar: more pressure, more contraction
///
/// let mut state = muscle.rest_state();
/// let before = state.clone();
/// assert!(muscle.step(&mut state, f64::NAN).is_err());
/// assert_eq!(state, before); // a refused input leaves no trace
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub enum Model<T, const N: usize, const M: usize> {
    /// CPI, SGPI, MPI or MGPI.
    Cascade(Cascade<T, AnyEnvelope<T>, N, M>),
    /// AGPI.
    Agpi(Agpi<T, N>),
    /// EGPI.
    Egpi(Egpi<T, N>),
}

impl<T: Real, const N: usize, const M: usize> Model<T, N, M> {
    /// # Errors
    /// The first parameter that no model can be made of.
    pub fn try_new(parameters: &ModelParameters<T, N, M>) -> Result<Self, ParameterError> {
        match parameters {
            ModelParameters::Cascade(cascade) => apart(|| Cascade::try_new(cascade).map(Self::Cascade)),
            ModelParameters::Agpi(agpi) => apart(|| Agpi::try_new(agpi).map(Self::Agpi)),
            ModelParameters::Egpi(egpi) => apart(|| Egpi::try_new(egpi).map(Self::Egpi)),
        }
    }

    /// The smallest slope of the plays, the distance from being non-invertible. Unit: 1.
    pub fn smallest_play_slope(&self) -> T {
        match self {
            Self::Cascade(cascade) => cascade.plays().smallest_slope(),
            Self::Agpi(agpi) => agpi.plays().smallest_slope(),
            Self::Egpi(egpi) => egpi.agpi().plays().smallest_slope(),
        }
    }

    /// The smallest slope of the output over the plays, the distance from being non-invertible.
    /// Unit: output unit.
    pub fn smallest_output_slope(&self) -> T {
        match self {
            Self::Cascade(cascade) => cascade.dead_zones().smallest_slope(),
            Self::Agpi(agpi) => agpi.gain(),
            Self::Egpi(egpi) => egpi.agpi().gain(),
        }
    }
}

impl<T: Real, const N: usize, const M: usize> Hysteresis<T, N> for Model<T, N, M> {
    fn input_range(&self) -> &Range<T> {
        match self {
            Self::Cascade(cascade) => cascade.input_range(),
            Self::Agpi(agpi) => agpi.input_range(),
            Self::Egpi(egpi) => egpi.input_range(),
        }
    }

    fn rest_state(&self) -> HysteresisState<T, N> {
        match self {
            Self::Cascade(cascade) => cascade.rest_state(),
            Self::Agpi(agpi) => agpi.rest_state(),
            Self::Egpi(egpi) => egpi.rest_state(),
        }
    }

    fn step(&self, state: &mut HysteresisState<T, N>, x: T) -> Result<T, InputError> {
        match self {
            Self::Cascade(cascade) => cascade.step(state, x),
            Self::Agpi(agpi) => agpi.step(state, x),
            Self::Egpi(egpi) => egpi.step(state, x),
        }
    }
}

impl<T: Real, const N: usize, const M: usize> Invertible<T, N> for Model<T, N, M> {
    type Inverse = InverseModel<T, N, M>;

    fn inverse(&self) -> Result<Self::Inverse, ParameterError> {
        match self {
            Self::Cascade(cascade) => apart(|| cascade.inverse().map(InverseModel::Cascade)),
            Self::Agpi(agpi) => apart(|| agpi.inverse().map(InverseModel::Agpi)),
            Self::Egpi(egpi) => apart(|| egpi.inverse().map(InverseModel::Egpi)),
        }
    }
}

/// Does this in a function of its own, so that what it needs of the stack, which on a board is
/// small, is needed by nothing else.
#[inline(never)]
fn apart<R>(work: impl FnOnce() -> R) -> R {
    work()
}

/// The inverse of a [`Model`].
#[derive(Clone, Debug, PartialEq)]
pub enum InverseModel<T, const N: usize, const M: usize> {
    /// Of a CPI, SGPI, MPI or MGPI.
    Cascade(InverseCascade<T, AnyEnvelope<T>, N, M>),
    /// Of an AGPI.
    Agpi(InverseAgpi<T, N>),
    /// Of an EGPI.
    Egpi(InverseEgpi<T, N>),
}

impl<T: Real, const N: usize, const M: usize> InverseHysteresis<T, N> for InverseModel<T, N, M> {
    fn state_of(&self, state: &HysteresisState<T, N>) -> HysteresisState<T, N> {
        match self {
            Self::Cascade(cascade) => cascade.state_of(state),
            Self::Agpi(agpi) => agpi.state_of(state),
            Self::Egpi(egpi) => egpi.state_of(state),
        }
    }

    fn rest_state(&self) -> HysteresisState<T, N> {
        match self {
            Self::Cascade(cascade) => cascade.rest_state(),
            Self::Agpi(agpi) => agpi.rest_state(),
            Self::Egpi(egpi) => egpi.rest_state(),
        }
    }

    fn last_output(&self, state: &HysteresisState<T, N>) -> T {
        match self {
            Self::Cascade(cascade) => cascade.last_output(state),
            Self::Agpi(agpi) => agpi.last_output(state),
            Self::Egpi(egpi) => egpi.last_output(state),
        }
    }

    #[inline(always)]
    fn step(&self, state: &mut HysteresisState<T, N>, y: T) -> Result<T, InputError> {
        match self {
            Self::Cascade(cascade) => step_apart(cascade, state, y),
            Self::Agpi(agpi) => agpi.step(state, y),
            Self::Egpi(egpi) => egpi.step(state, y),
        }
    }
}

/// A step of the cascade: in one function with the rest of a controller there are too few
/// registers.
#[inline(never)]
fn step_apart<T: Real, const N: usize, const M: usize>(
    cascade: &InverseCascade<T, AnyEnvelope<T>, N, M>,
    state: &mut HysteresisState<T, N>,
    y: T,
) -> Result<T, InputError> {
    cascade.step(state, y)
}
