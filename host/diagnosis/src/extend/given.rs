//! An operator model that the user has: whether it is of this muscle, and whether its form is rich enough.

use model_core::ExtensionParameters;

use super::task::Task;
use super::{Extension, Operator};
use identification::HostExtendedModel;

/// Another muscle: the model's error is so many times that of the same form fitted to the recording.
const OTHER: f64 = 2.0;
/// Too poor a form: the error of the same form, fitted, is so many times that of the richer one.
const POORER: f64 = 1.25;

/// What is said of a given operator model, with the same extensions as its rivals. Errors are root mean squares in output
/// unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Given {
    /// As it was given.
    pub rmse: f64,
    /// Of the same form, fitted to the recording.
    pub refitted_rmse: f64,
    /// Of the richer form.
    pub richer_rmse: f64,
    /// As it was given, without extensions, over the error of the richer form without.
    pub plain_ratio: f64,
}

impl Given {
    /// Whether it describes another muscle, or this one in another state; not where it is as good as can be without extensions:
    /// it was then found with what they stand for in it.
    pub fn is_of_another_muscle(&self) -> bool {
        self.rmse > OTHER * self.refitted_rmse && self.plain_ratio > OTHER
    }

    /// Whether its form is what is wrong.
    pub fn is_too_poor(&self) -> bool {
        self.refitted_rmse > POORER * self.richer_rmse
    }

    /// The share of the square of its error, fitted, that the richer form takes away.
    pub fn share(&self) -> f64 {
        1.0 - (self.richer_rmse / self.refitted_rmse).powi(2)
    }
}

/// A given operator beside the richer one, plain and extended; with it, the given one fitted with the same extensions, or, where
/// it cannot have these, with those `before` it. None where it does not run through the rows.
pub(super) fn judge(
    task: &Task<'_>,
    operator: &Operator,
    (plain, richer): (&Extension, &Extension),
    before: impl Fn(&ExtensionParameters<f64>) -> ExtensionParameters<f64>,
) -> Option<(Given, Extension)> {
    let same = operator.with(richer.extensions.clone());
    let can_have = HostExtendedModel::try_new(&same.parameters, &same.extensions).is_ok();
    let as_given =
        if can_have { same } else { operator.with(before(&richer.extensions)) }.jumping(richer.jump);
    let rmse = task.rms(&as_given)?;
    let (refitted, _) = task.refined(as_given)?;
    let given = Given {
        rmse,
        refitted_rmse: task.rms(&refitted)?,
        richer_rmse: task.rms(richer)?,
        plain_ratio: task.rms(&operator.with(ExtensionParameters::default()))? / task.rms(plain)?,
    };
    Some((given, refitted))
}
