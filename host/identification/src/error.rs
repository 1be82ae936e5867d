//! Why nothing can be identified.

use std::fmt;

use model_core::ParameterError;

/// Why nothing can be identified.
///
/// ```
/// use identification::{IdentificationError, Options, Problem, identify};
///
/// let still = Problem { input: &[1.0; 50], output: &[5.0; 50], scored: &[true; 50] };
/// let refused: IdentificationError = identify(&still, &Options::default(), &|_| ()).unwrap_err();
/// assert!(!refused.to_string().is_empty()); // an input that never moves tells nothing
/// ```
#[derive(Clone, Debug, PartialEq)]
pub enum IdentificationError {
    /// Lists of different length.
    Lengths,
    /// A size outside its limits: its name, value, least and largest value.
    Size(&'static str, usize, [usize; 2]),
    /// Fewer rows that count than parameters.
    TooFewRows {
        /// Rows that count.
        rows: usize,
        /// Parameters to find.
        parameters: usize,
    },
    /// A number that is not finite: the list's name and the row, counted from 0.
    NotFinite(&'static str, usize),
    /// The input never changes; its value.
    ConstantInput(f64),
    /// The output never changes; its value.
    ConstantOutput(f64),
    /// The best model found is not valid.
    Invalid(ParameterError),
    /// The threads could not be started.
    Threads(String),
}

impl fmt::Display for IdentificationError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Lengths => write!(f, "input, output and scored rows differ in number"),
            Self::Size(name, value, [min, max]) => {
                write!(f, "number of {name} is {value}, must be {min} to {max}")
            }
            Self::TooFewRows { rows, parameters } => {
                write!(
                    f,
                    "{rows} rows count, but the model has {parameters} parameters: record more, or use fewer"
                )
            }
            Self::NotFinite(list, row) => write!(f, "{list} of row {row} is not a finite number"),
            Self::ConstantInput(value) => {
                write!(f, "the input is constant ({value}): nothing can be identified")
            }
            Self::ConstantOutput(value) => {
                write!(f, "the output is constant ({value}): nothing can be identified")
            }
            Self::Invalid(error) => write!(f, "the best model found is not valid: {error}"),
            Self::Threads(error) => write!(f, "the threads of the search could not be started: {error}"),
        }
    }
}

impl std::error::Error for IdentificationError {}
