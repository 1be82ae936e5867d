//! A row of the recordings, as the search sees it, and the span that their inputs are normalised
//! over.

/// Lowest input and span of the inputs. Input unit.
pub type Span = (f64, f64);

/// A row of a recording.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// The input, 0 … 1 over the span of all inputs.
    pub input: f64,
    /// The measured output. Output unit.
    pub output: f64,
    /// How many rows that count it stands for; 0 if it is history only.
    pub weight: f32,
    /// Whether it is on a rising branch; one that rests keeps its branch.
    pub rising: bool,
    /// Whether a recording begins with it: the muscle comes from rest.
    pub begins: bool,
    /// Whether its recording has rested at the lowest input up to here: its branch is that of what
    /// was before.
    pub rests: bool,
}
