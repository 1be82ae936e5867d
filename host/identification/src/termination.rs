//! How a search ended.

use std::fmt;

use levenberg_marquardt::TerminationReason;

/// How a search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Termination {
    /// Sum of squares and parameters settled.
    Settled,
    /// The sum of squares settled.
    SquaresSettled,
    /// The parameters settled.
    ParametersSettled,
    /// The gradient vanished.
    GradientVanished,
    /// No residual is left.
    NoResidual,
    /// Rounding hides any improvement.
    Rounding,
    /// The largest number of evaluations was reached.
    Evaluations,
    /// The numbers are beyond what the search can handle.
    Numerical,
}

impl Termination {
    /// Whether at a minimum.
    pub fn converged(self) -> bool {
        !matches!(self, Self::Evaluations | Self::Numerical)
    }
}

impl From<&TerminationReason> for Termination {
    fn from(reason: &TerminationReason) -> Self {
        match reason {
            TerminationReason::Converged { ftol: true, xtol: true } => Self::Settled,
            TerminationReason::Converged { ftol: true, .. } => Self::SquaresSettled,
            TerminationReason::Converged { .. } => Self::ParametersSettled,
            TerminationReason::Orthogonal => Self::GradientVanished,
            TerminationReason::ResidualsZero => Self::NoResidual,
            TerminationReason::NoImprovementPossible(_) => Self::Rounding,
            TerminationReason::LostPatience => Self::Evaluations,
            _ => Self::Numerical,
        }
    }
}

impl fmt::Display for Termination {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Settled => "converged: sum of squares and parameters settled",
            Self::SquaresSettled => "converged: sum of squares settled",
            Self::ParametersSettled => "converged: parameters settled",
            Self::GradientVanished => "converged: the gradient vanished",
            Self::NoResidual => "converged: no residual left",
            Self::Rounding => "converged: no improvement possible in double precision",
            Self::Evaluations => "stopped: largest number of evaluations reached",
            Self::Numerical => "stopped: numerical failure",
        })
    }
}
