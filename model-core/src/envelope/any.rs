//! One of the envelopes, chosen at run time.

use crate::convert;
use crate::envelope::{
    Envelope, Identity, PiecewiseLinear, PiecewiseLinearParameters, TanhEnvelope, TanhParameters,
};
use crate::error::ParameterError;
use crate::range::Range;
use crate::real::Real;

/// The largest number of knots of a piecewise-linear envelope that is chosen at run time.
pub const KNOTS: usize = 32;

/// Raw parameters of one of the envelopes.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "T: Real + serde::Serialize + serde::de::DeserializeOwned")
)]
// Boxing the knots needs a heap, which the board does not have.
#[allow(clippy::large_enum_variant)]
pub enum EnvelopeParameters<T> {
    /// γ(x) = x.
    Identity,
    /// The paper's, equation (11).
    Tanh(TanhParameters<T>),
    /// Through free knots.
    PiecewiseLinear(PiecewiseLinearParameters<T, KNOTS>),
}

/// One of the validated envelopes.
///
/// ```
/// use model_core::envelope::{AnyEnvelope, Envelope, EnvelopeParameters};
///
/// let envelope = AnyEnvelope::try_new(&EnvelopeParameters::Tanh(model_core::paper::ENVELOPE))?;
/// let AnyEnvelope::Tanh(tanh) = &envelope else { panic!("another kind") };
/// assert_eq!(envelope.value(2.0), tanh.value(2.0));
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[allow(clippy::large_enum_variant)] // as above
pub enum AnyEnvelope<T> {
    /// γ(x) = x.
    Identity(Identity),
    /// The paper's, equation (11).
    Tanh(TanhEnvelope<T>),
    /// Through free knots.
    PiecewiseLinear(PiecewiseLinear<T, KNOTS>),
}

impl<T: Real> EnvelopeParameters<T> {
    /// The same parameters in another number type.
    ///
    /// # Errors
    /// None: the capacities are the same. The type is that of the steps that lead here.
    pub fn convert<U: Real>(&self) -> Result<EnvelopeParameters<U>, ParameterError> {
        Ok(match self {
            Self::Identity => EnvelopeParameters::Identity,
            Self::Tanh(tanh) => EnvelopeParameters::Tanh(tanh.convert()),
            Self::PiecewiseLinear(PiecewiseLinearParameters { inputs, values }) => {
                EnvelopeParameters::PiecewiseLinear(PiecewiseLinearParameters {
                    inputs: convert::list("knots", inputs)?,
                    values: convert::list("knots", values)?,
                })
            }
        })
    }
}

impl<T: Real> AnyEnvelope<T> {
    /// # Errors
    /// Those of the envelope that it is.
    pub fn try_new(parameters: &EnvelopeParameters<T>) -> Result<Self, ParameterError> {
        Ok(match parameters {
            EnvelopeParameters::Identity => Self::Identity(Identity),
            EnvelopeParameters::Tanh(tanh) => Self::Tanh(TanhEnvelope::try_new(*tanh)?),
            EnvelopeParameters::PiecewiseLinear(knots) => {
                Self::PiecewiseLinear(PiecewiseLinear::try_new(knots)?)
            }
        })
    }
}

impl<T: Real> Envelope<T> for AnyEnvelope<T> {
    fn value(&self, x: T) -> T {
        match self {
            Self::Identity(envelope) => envelope.value(x),
            Self::Tanh(envelope) => envelope.value(x),
            Self::PiecewiseLinear(envelope) => envelope.value(x),
        }
    }

    fn inverse(&self, v: T) -> T {
        match self {
            Self::Identity(envelope) => envelope.inverse(v),
            Self::Tanh(envelope) => envelope.inverse(v),
            Self::PiecewiseLinear(envelope) => envelope.inverse(v),
        }
    }

    #[inline(always)]
    fn inverse_inside(&self, v: T) -> T {
        match self {
            Self::Identity(envelope) => envelope.inverse_inside(v),
            Self::Tanh(envelope) => envelope.inverse_inside(v),
            Self::PiecewiseLinear(envelope) => envelope.inverse_inside(v),
        }
    }

    fn counted_from(&self, v: f64) -> Option<Self> {
        match self {
            Self::Identity(_) => None,
            Self::Tanh(envelope) => envelope.counted_from(v).map(Self::Tanh),
            Self::PiecewiseLinear(envelope) => envelope.counted_from(v).map(Self::PiecewiseLinear),
        }
    }

    fn values(&self) -> (T, T) {
        match self {
            Self::Identity(envelope) => envelope.values(),
            Self::Tanh(envelope) => envelope.values(),
            Self::PiecewiseLinear(envelope) => envelope.values(),
        }
    }

    fn least_slope(&self, range: &Range<T>) -> T {
        match self {
            Self::Identity(envelope) => envelope.least_slope(range),
            Self::Tanh(envelope) => envelope.least_slope(range),
            Self::PiecewiseLinear(envelope) => envelope.least_slope(range),
        }
    }
}
