//! The controller's settings of a new configuration: what is asked for, else what was tuned for
//! the model, else what the board has, else the default.
//!
//! Tuned gains go with their model: where it has some, those that the board has for another model
//! do not stay, unless that is asked for. An observer never stays for another model.
//! A limit of the command that is an end of the model's range was not set by anybody: it follows
//! the new model. One that the new model does not allow is brought to the end of its range.

use wire::BoardParameters;
use wire::registers::fields::{CONTROLLER, OBSERVER, of_controller};
use wire::registers::{Access, Id, Value};

use super::error::BoardError;

/// A setting by its register, before and after.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    /// Its register, which names it with its unit.
    pub id: Id,
    /// What the board has; none on a board without a model. The register's unit.
    pub before: Option<f32>,
    /// What it gets. The register's unit.
    pub after: f32,
    /// Why, where that is more than "it stays".
    pub reason: Option<Reason>,
}

/// Why a setting is what it gets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reason {
    /// An option says so.
    Asked,
    /// The board has none yet, and no option says otherwise.
    Default,
    /// It was tuned for the model.
    Tuned,
    /// The end of the model's range, as it was of the model before.
    Follows,
    /// What was asked for, or set before, is beyond the model's range.
    Limited,
}

impl Setting {
    /// Whether the board has this already.
    pub fn stays(&self) -> bool {
        self.before == Some(self.after)
    }
}

/// For a line of a list: `command_max_bar  2 -> 5.98: as asked for`.
impl std::fmt::Display for Setting {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { id, before, after, reason } = self;
        write!(f, "{:<24}", id.register().name)?;
        match before {
            Some(_) if self.stays() => write!(f, "{after}, stays")?,
            Some(before) => write!(f, "{before} -> {after}")?,
            None => write!(f, "{after}")?,
        }
        match reason {
            Some(Reason::Asked) if !self.stays() => write!(f, ": as asked for"),
            Some(Reason::Default) => write!(f, ": the default"),
            Some(Reason::Tuned) if !self.stays() => write!(f, ": tuned for this model"),
            Some(Reason::Follows) if !self.stays() => {
                write!(f, ": the end of the model's range, as before")
            }
            Some(Reason::Limited) => write!(f, ": the model's range ends there"),
            _ => Ok(()),
        }
    }
}

/// What is tuned for a model.
pub const GAINS: [Id; 8] = [
    Id::Kp,
    Id::Ki,
    Id::Kd,
    Id::DerivativeFilter,
    Id::TrackingTime,
    Id::ObserverSlope,
    Id::ObserverReach,
    Id::ObserverBand,
];

/// Puts the settings into a new configuration, whose own are the defaults or, if `is_tuned`, those
/// tuned for its model, and the ends of its model's range. `installed` is what the board has,
/// `asked` what options say.
///
/// # Errors
/// What is asked for is outside the register's limits, or the lowest command is not below the
/// highest.
pub fn settle(
    new: &mut BoardParameters,
    installed: Option<&BoardParameters>,
    asked: &[(Id, f32)],
    is_tuned: bool,
) -> Result<Vec<Setting>, BoardError> {
    for &(id, value) in asked {
        let register = id.register();
        if let Access::Write(min, max) = register.access
            && !register.takes(Value::F32(value))
        {
            return Err(BoardError::Setting { name: register.name, value, min, max });
        }
    }
    let model_ends = ends(new);
    let is_other = installed.is_some_and(|installed| installed.model != new.model);
    let setting = |id| {
        let asked = asked.iter().find(|(of, _)| *of == id).map(|(_, value)| *value);
        let before = installed.map(|installed| value(installed, id));
        let own = value(new, id);
        let follows = installed
            .is_some_and(|installed| end(ends(installed), id).is_some_and(|end| Some(end) == before));
        let (after, reason) = match (asked, before) {
            (Some(asked), _) => (asked, Some(Reason::Asked)),
            (None, _) if is_tuned && GAINS.contains(&id) => (own, Some(Reason::Tuned)),
            // A slope of another muscle says nothing of this one's.
            (None, Some(_)) if OBSERVER.contains(&id) && is_other => (own, Some(Reason::Default)),
            (None, Some(_)) if follows => (own, Some(Reason::Follows)),
            (None, Some(before)) => (before, None),
            (None, None) => (own, Some(Reason::Default)),
        };
        Setting { id, before, after, reason }
    };
    let mut settings = CONTROLLER.map(setting);
    let [lowest, highest] = [Id::CommandMin, Id::CommandMax]
        .map(|id| CONTROLLER.iter().position(|of| *of == id).unwrap_or_default());
    limit(&mut settings[highest], |bar| bar > model_ends.1, model_ends.1);
    let highest_bar = settings[highest].after;
    if settings[lowest].reason != Some(Reason::Asked) {
        limit(&mut settings[lowest], |bar| bar >= highest_bar, model_ends.0);
    }
    let lowest_bar = settings[lowest].after;
    if lowest_bar >= highest_bar {
        return Err(BoardError::Limits { lowest_bar, highest_bar });
    }
    for Setting { id, after, .. } in settings {
        of_controller(new, id).into_iter().for_each(|field| field.set(Value::F32(after)));
    }
    Ok(settings.to_vec())
}

/// Brings a setting to an end of the model's range where it is beyond.
fn limit(setting: &mut Setting, is_beyond: impl Fn(f32) -> bool, end: f32) {
    if is_beyond(setting.after) {
        (setting.after, setting.reason) = (end, Some(Reason::Limited));
    }
}

/// What a board's parameters have at a register of the group "Controller".
pub fn value(parameters: &BoardParameters, id: Id) -> f32 {
    // The fields are found by exclusive reference only; a copy is a page of numbers.
    let mut parameters = parameters.clone();
    of_controller(&mut parameters, id).map_or(f32::NAN, |field| field.get().number() as f32)
}

/// The commands at the ends of the model's range: a valve cannot suck, and noise around 0 bar may
/// have put the model's lower end below. Unit: bar.
pub fn ends(parameters: &BoardParameters) -> (f32, f32) {
    let (lowest, highest) = parameters.model.input();
    (lowest.max(0.0), highest)
}

/// That of the two ends which a limit of the command follows.
fn end((lowest, highest): (f32, f32), id: Id) -> Option<f32> {
    match id {
        Id::CommandMin => Some(lowest),
        Id::CommandMax => Some(highest),
        _ => None,
    }
}
