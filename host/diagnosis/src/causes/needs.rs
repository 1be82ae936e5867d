//! What several causes need of a recording, met or not, in words with figures.

use crate::anatomy::excitation::{Excitation, Variation};
use recording::numbers::{apart, legible};

/// The least ratio of two speeds over the same range that shows an effect of the speed: a lag shifts a loop in proportion to the speed, so
/// the shifts differ by as much. A choice; no error level is calibrated for it.
const SPEED_RATIO: f64 = 2.5;
/// Holds after movement in which what lags comes after.
const LAG_HOLDS: usize = 3;
/// The shortest hold in which creep is told from a lag: one of 1 s is over by 95 % then. A choice; no error level is calibrated for it.
/// Unit: s.
pub const CREEP_HOLD_S: f64 = 3.0;
/// Repeats of a swing that show a change with time, and the share of the recording between the first and the last of them:
/// where two stand at either end, what lies between says the rest.
const REPEATS: [(usize, f64); 2] = [(3, 0.3), (2, 0.8)];
/// Relative error of differences of times.
pub const ROUNDING: f64 = 1e-6;

/// What a cause needs, met or not, in words.
pub type Judged = Result<String, String>;

/// Where the valve is, as the recording sees it.
#[derive(Clone, Copy, Debug)]
pub enum ValveView<'a> {
    /// The pressure alone is known, and drives the model.
    Unseen,
    /// The command alone is known, and drives the model: valve and muscle are one chain.
    InChain,
    /// Command and pressure are both known; this is what the command excites.
    Beside(&'a Excitation),
}

/// What an excitation may lack, so that it shows several causes alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lack {
    /// At one speed a delay and a lag shift the loop by the same.
    Speeds,
    /// Without long holds the quick part of creep is a lag.
    LongHolds,
}

impl Lack {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Speeds, Self::LongHolds];

    /// Whether an excitation lacks it.
    pub fn is_of(self, excitation: &Excitation) -> bool {
        match self {
            Self::Speeds => excitation.speed_ratio < SPEED_RATIO,
            Self::LongHolds => excitation.longest_hold_s() < CREEP_HOLD_S,
        }
    }

    /// What it comes to, in words.
    pub fn why(self) -> &'static str {
        match self {
            Self::Speeds => "the input swings at one speed",
            Self::LongHolds => "no hold is so long that a creep goes on where a lag has ended",
        }
    }
}

/// A recording, as causes ask it for what they need.
#[derive(Clone, Copy, Debug)]
pub struct Judge<'a> {
    /// What drives the model, and what comes of it.
    pub excitation: &'a Excitation,
    /// The valve.
    pub valve: ValveView<'a>,
    /// The input's symbol.
    pub unit: &'a str,
}

impl Judge<'_> {
    /// Something of the valve.
    pub fn valve_seen(&self) -> Judged {
        match self.valve {
            ValveView::Unseen => {
                Err("there is no command beside the pressure, so nothing of the valve shows".to_owned())
            }
            ValveView::InChain => {
                Ok("the command alone was recorded: what the valve does cannot be told from what the muscle does \
                    likewise"
                    .to_owned())
            }
            ValveView::Beside(_) => Ok("command and pressure were both recorded".to_owned()),
        }
    }

    /// Several speeds over the same range.
    pub fn speeds(&self) -> Judged {
        let Excitation { slowest, fastest, speed_ratio, .. } = self.excitation;
        let unit = self.unit;
        self.swings()?;
        let (slowest, fastest) = (legible(*slowest, 2), legible(*fastest, 2));
        if *speed_ratio >= SPEED_RATIO {
            return Ok(format!(
                "swings of {slowest} to {fastest} {unit}/s, over the same range up to {speed_ratio:.1} times as fast"
            ));
        }
        Err(format!(
            "swings over the same range differ in speed by a factor of {} at most, and {SPEED_RATIO} is \
             needed ({slowest} to {fastest} {unit}/s in all)",
            apart(*speed_ratio, SPEED_RATIO, 1)
        ))
    }

    /// Several speeds, or holds.
    pub fn lag(&self) -> Judged {
        let holds = self.excitation.holds.len();
        match self.speeds() {
            Err(why) if holds >= LAG_HOLDS => Ok(format!(
                "{holds} holds in which what lags comes after, the longest {:.1} s; but {why}",
                self.excitation.longest_hold_s()
            )),
            Err(why) => {
                Err(format!("{why}; holds would do as well, {LAG_HOLDS} at least, and there are {holds}"))
            }
            seen => seen,
        }
    }

    /// Any swing.
    pub fn swings(&self) -> Result<(), String> {
        if self.excitation.swings == 0 { Err("the input never swings".to_owned()) } else { Ok(()) }
    }

    /// A column that varies by more than its noise.
    pub fn column(&self, name: &str, unit: &str, column: Option<Variation>) -> Judged {
        match column {
            None => Err(format!("there is no column of the {name}")),
            Some(Variation { low, high, varies: false, .. }) => {
                Err(format!("the {name} varies by {:.3} {unit} only, no more than its noise", high - low))
            }
            Some(Variation { low, high, follows_time: true, .. }) => Ok(format!(
                "the {name} goes over {:.3} {unit}, but steadily with time: it cannot be told from a drift",
                high - low
            )),
            Some(Variation { low, high, .. }) => Ok(format!("the {name} goes over {:.3} {unit}", high - low)),
        }
    }

    /// The same swing again, later.
    pub fn repeats(&self) -> Judged {
        let Excitation { repeats, repeated_over_s, duration_s, .. } = self.excitation;
        let words = match repeats {
            0 | 1 => "no two swings are alike".to_owned(),
            _ => format!("{repeats} swings alike, over {repeated_over_s:.0} of {duration_s:.0} s"),
        };
        let is_enough =
            |&(count, share): &(usize, f64)| *repeats >= count && *repeated_over_s >= share * duration_s;
        if REPEATS.iter().any(is_enough) {
            return Ok(words);
        }
        let needed = REPEATS.map(|(count, share)| format!("{count}, over {:.0} s", share * duration_s));
        Err(format!("{words}; a change with time needs {} at least", needed.join(", or ")))
    }
}
