//! The model without extensions: what an extended one is compared with, and what is written where none is better.

use model_core::ExtensionParameters;

use super::beginnings::plainer;
use super::task::Task;
use super::{Extension, Operator, Split, start};
use crate::Columns;
use identification::{IdentificationError, Termination};

/// The model without extensions.
#[derive(Clone, Debug)]
pub struct Plain {
    /// Fitted to the scored rows that teach: what an extended one is compared with.
    pub(super) taught: Extension,
    /// Fitted to all of them, from there.
    pub(super) whole: Extension,
    pub(super) termination: Termination,
}

impl Plain {
    /// Of a recording: with all scored rows the better of what `mgpi identify` finds and of what the rows that
    /// teach have taught, continued.
    ///
    /// # Errors
    /// No operator can be identified.
    pub fn new(columns: &Columns, scored: &[usize]) -> Result<Self, IdentificationError> {
        let Split { taught: first, .. } = Split::of(columns, scored);
        let plainly = |operator: &Operator| operator.with(ExtensionParameters::default());
        let operator = start::operator(&start::Seen::plain(columns), &first)?;
        let (identified, mut termination) = start::identified(columns)?;
        let (task, mut whole) = (Task::alone(columns, &first), plainly(&identified));
        let taught = plainly(&operator);
        let taught = task.refined(taught.clone()).map_or(taught, |(refined, _)| refined);
        let taught = plainer(&task, taught, &whole);
        if let Some((refined, ended)) = Task::alone(columns, scored).refined(taught.clone())
            && refined.rmse(columns) < whole.rmse(columns)
        {
            (whole, termination) = (refined, ended);
        }
        Ok(Self { taught, whole, termination })
    }
}
