//! Which causes a recording can show at all.
//!
//! # Design
//! Each cause says what excitation, or which column, it needs, in which it acts otherwise than its rivals; without it the cause is not
//! examinable, and the reason says what the recording has and what it would need. Nothing is guessed from a residual here.
//!
//! # Limits
//! That a cause is examinable does not say that it can be told from every rival, only that it would be seen.

use serde::Serialize;

use super::excitation::Excitation;
use crate::causes::Cause;
use crate::causes::needs::{Judge, Lack, ValveView};

/// Whether a recording can show a cause.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Examinable {
    /// The cause.
    #[serde(serialize_with = "by_name")]
    pub cause: Cause,
    /// Whether it can.
    pub examinable: bool,
    /// Why, or why not, with figures.
    pub why: String,
}

fn by_name<S: serde::Serializer>(cause: &Cause, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(cause.name())
}

/// Judges every cause; `unit` is the input's symbol.
pub fn examinable(excitation: &Excitation, valve: ValveView<'_>, unit: &str) -> Vec<Examinable> {
    let judge = |cause: Cause| {
        let judged = cause.needs(&Judge { excitation, valve, unit });
        let examinable = judged.is_ok();
        let (Ok(why) | Err(why)) = judged;
        Examinable { cause, examinable, why }
    };
    Cause::ALL.map(judge).to_vec()
}

/// Causes that a recording shows, and not apart.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Inseparable {
    /// None, or at least two.
    pub causes: Vec<Cause>,
    /// Why.
    pub why: Vec<&'static str>,
}

impl Inseparable {
    /// Leaves out those that were told apart all the same: of one that is left alone nothing is to be said.
    pub fn leave_out(&mut self, told: &[Cause]) {
        self.causes.retain(|cause| !told.contains(cause));
        if self.causes.len() < 2 {
            *self = Self::default();
        }
    }
}

/// The causes that the excitation shows alike for what it lacks.
pub fn inseparable(judged: &[Examinable], excitation: &Excitation) -> Inseparable {
    let mut all = Inseparable::default();
    for lack in Lack::ALL.into_iter().filter(|lack| lack.is_of(excitation)) {
        let shown = judged.iter().filter(|judged| judged.examinable).map(|judged| judged.cause);
        let causes: Vec<Cause> = shown.filter(|cause| cause.about().alike_without.contains(&lack)).collect();
        if causes.len() > 1 {
            all.causes
                .extend(causes.into_iter().filter(|cause| !all.causes.contains(cause)).collect::<Vec<_>>());
            all.why.push(lack.why());
        }
    }
    all
}

#[cfg(test)]
mod tests;
