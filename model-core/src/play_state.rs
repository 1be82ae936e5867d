//! What a bank of plays remembers: the outputs of few plays, or the turning points of the input of
//! many.

use crate::few_plays::{FEW_PLAYS, Outputs};
use crate::real::Real;
use crate::turning_points::TurningPoints;

/// What a bank of at most `N` plays remembers.
///
/// ```
/// use model_core::play::{PlayBank, PlayParameters};
///
/// let bank = PlayBank::try_new(&PlayParameters::<f64, 2>::exponential(2, 0.3, 0.2, 5.0, 0.1)?)?;
/// let mut state = bank.rest_state(0.0);
/// bank.step(&mut state, 1.0)?;
/// // Each play follows at the distance of its threshold.
/// let outputs = bank.outputs(&state);
/// assert!((outputs[0] - 0.9).abs() < 1e-12 && (outputs[1] - 0.8).abs() < 1e-12);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "T: Real + serde::Serialize + serde::de::DeserializeOwned")
)]
#[repr(C)] // As for `InverseCascade`.
pub struct PlayState<T, const N: usize> {
    /// Where there are no turning points. Beside these it is left as it is.
    few: Outputs<T>,
    /// Of a bank of more than [`FEW_PLAYS`].
    many: Option<TurningPoints<T, N>>,
}

/// Either.
pub(crate) enum Memory<F, M> {
    Few(F),
    Many(M),
}

impl<T: Real, const N: usize> PlayState<T, N> {
    /// Of plays that are kept by their outputs.
    pub(crate) fn few(few: Outputs<T>) -> Self {
        Self { few, many: None }
    }

    /// Of plays that are kept by turning points, of a bank that has room for many.
    pub(crate) fn many(many: TurningPoints<T, N>) -> Self {
        Self { few: Outputs::none(), many: Some(many) }
    }

    /// What is remembered. A bank without room for many plays need not be asked which it is.
    #[inline(always)]
    pub(crate) fn memory(&self) -> Memory<&Outputs<T>, &TurningPoints<T, N>> {
        match &self.many {
            Some(many) if N > FEW_PLAYS => Memory::Many(many),
            _ => Memory::Few(&self.few),
        }
    }

    /// As [`memory`](Self::memory), to be changed.
    #[inline(always)]
    pub(crate) fn memory_mut(&mut self) -> Memory<&mut Outputs<T>, &mut TurningPoints<T, N>> {
        match &mut self.many {
            Some(many) if N > FEW_PLAYS => Memory::Many(many),
            _ => Memory::Few(&mut self.few),
        }
    }

    /// The last input of the bank. Unit: that of its input.
    pub fn input(&self) -> T {
        match self.memory() {
            Memory::Few(few) => few.v,
            Memory::Many(many) => many.last.v,
        }
    }

    /// The same memory where inputs count from `v` on and outputs from `u`, which the bank gives
    /// there when all plays are driven.
    pub(crate) fn counted_from(&self, v: f64, u: f64) -> Self {
        Self { few: self.few.counted_from(v), many: self.many.as_ref().map(|many| many.counted_from(v, u)) }
    }

    /// Makes it the same as another one of the same bank; copies no more than is remembered.
    pub(crate) fn copy_from(&mut self, other: &Self) {
        self.few.clone_from(&other.few);
        match (&mut self.many, &other.many) {
            (Some(many), Some(other)) => many.copy_from(other),
            (None, None) => {}
            (many, other) => many.clone_from(other),
        }
    }
}
