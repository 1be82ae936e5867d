//! What a bank of plays remembers: the outputs of few plays, or the turning points of the input of many.

use crate::few_plays::Outputs;
use crate::real::Real;
use crate::turning_points::TurningPoints;

/// What a bank of at most `N` plays remembers.
#[derive(Clone, Debug, PartialEq)]
pub struct PlayState<T, const N: usize> {
    pub(crate) memory: Memory<T, N>,
}

#[derive(Clone, Debug, PartialEq)]
// Boxing the turning points needs a heap, which the board does not have.
#[allow(clippy::large_enum_variant)]
pub(crate) enum Memory<T, const N: usize> {
    /// Of at most [`FEW_PLAYS`](crate::few_plays::FEW_PLAYS).
    Few(Outputs<T>),
    /// Of more.
    Many(TurningPoints<T, N>),
}

impl<T: Real, const N: usize> PlayState<T, N> {
    /// The last input of the bank. Unit: that of its input.
    pub fn input(&self) -> T {
        match &self.memory {
            Memory::Few(few) => few.v,
            Memory::Many(many) => many.last.v,
        }
    }

    /// Makes it the same as another one of the same bank; copies no more than is remembered.
    pub(crate) fn copy_from(&mut self, other: &Self) {
        match (&mut self.memory, &other.memory) {
            (Memory::Many(many), Memory::Many(other)) => many.copy_from(other),
            (memory, other) => memory.clone_from(other),
        }
    }
}
