//! Which causes a recording can show at all.
//!
//! # Design
//! Each cause needs an excitation, or a column, in which it acts otherwise than its rivals; without it the cause is not
//! examinable, and the reason says what the recording has and what it would need. Nothing is guessed from a residual here.
//!
//! # Limits
//! That a cause is examinable does not say that it can be told from every rival, only that it would be seen.

use serde::Serialize;

use super::excitation::{Excitation, Variation};
use crate::cause::Cause;
use recording::numbers::{apart, legible};

/// The least ratio of two speeds over the same range that shows an effect of the speed.
const SPEED_RATIO: f64 = 2.5;
/// Holds after movement in which what lags comes after.
const LAG_HOLDS: usize = 3;
/// A fast swing goes over so many spans in a second; what a mass does is not seen in slower ones. Unit: 1/s.
const FAST_SPANS: f64 = 0.4;
/// The most time between rows in which ringing is seen. Unit: s.
const RINGING_STEP_S: f64 = 0.05;
/// The shortest hold in which creep is told from a lag. Unit: s.
const CREEP_HOLD_S: f64 = 3.0;
/// So many plateaus after a jump do as well, but that creep is not told from a lag.
const CREEP_PLATEAUS: usize = 4;
/// Repeats of a swing that show a change with time, and the share of the recording between the first and the last of them:
/// where two stand at either end, what lies between says the rest.
const REPEATS: [(usize, f64); 2] = [(3, 0.3), (2, 0.8)];
/// The least travel in which running in is seen. Unit: strokes.
const WARM_UP_STROKES: f64 = 4.0;
/// The shortest recording in which a tone is told from anything else. Unit: s.
const TONE_S: f64 = 10.0;
/// Relative error of differences of times.
const ROUNDING: f64 = 1e-6;
/// The least number of different heights of swings in which the shape of inner loops shows.
const HEIGHTS: usize = 3;

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
        let judged = Judge { excitation, valve, unit }.judge(cause);
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

/// At one speed a delay and a lag shift the loop by the same; and without long holds the quick part of creep is a lag.
pub fn inseparable(judged: &[Examinable], excitation: &Excitation) -> Inseparable {
    let groups: [(bool, &[Cause], &str); 2] = [
        (
            excitation.speed_ratio < SPEED_RATIO,
            &[Cause::TransportDelay, Cause::ValveLag, Cause::ViscousLag],
            "the input swings at one speed",
        ),
        (
            excitation.longest_hold_s() < CREEP_HOLD_S,
            &[Cause::ViscousLag, Cause::Creep],
            "no hold is so long that a creep goes on where a lag has ended",
        ),
    ];
    let mut all = Inseparable::default();
    for (_, alike, why) in groups.into_iter().filter(|(holds, _, _)| *holds) {
        let shown = judged.iter().filter(|judged| judged.examinable && alike.contains(&judged.cause));
        let causes: Vec<Cause> = shown.map(|judged| judged.cause).collect();
        if causes.len() > 1 {
            all.causes
                .extend(causes.into_iter().filter(|cause| !all.causes.contains(cause)).collect::<Vec<_>>());
            all.why.push(why);
        }
    }
    all
}

/// What a cause needs, met or not, in words.
type Judged = Result<String, String>;

struct Judge<'a> {
    excitation: &'a Excitation,
    valve: ValveView<'a>,
    unit: &'a str,
}

impl Judge<'_> {
    fn judge(&self, cause: Cause) -> Judged {
        match cause {
            Cause::ValveLag => self.valve_lag(),
            Cause::ValveDeadband => self.valve_beside(),
            Cause::SupplySaturation => self.valve_seen(),
            Cause::TransportDelay | Cause::ViscousLag => self.lag(),
            Cause::RateDependentWidth => self.speeds(),
            Cause::Inertia => self.ringing(),
            Cause::Creep => self.creep(),
            Cause::Load => self.column("load", "N", self.excitation.load),
            Cause::Temperature => self.column("temperature", "K", self.excitation.temperature),
            Cause::Drift => self.repeats(),
            Cause::WarmUp => self.travel(),
            Cause::PeriodicDisturbance => self.tone(),
            Cause::HysteresisShape => self.shape(),
        }
    }

    fn valve_seen(&self) -> Judged {
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

    fn valve_lag(&self) -> Judged {
        let valve = self.valve_seen()?;
        let seen = match self.valve {
            ValveView::Beside(excitation) => Judge { excitation, ..*self }.lag()?,
            ValveView::Unseen | ValveView::InChain => self.lag()?,
        };
        Ok(format!("{valve}; {seen}"))
    }

    /// In one chain with the muscle, a dead band is the muscle's own hysteresis.
    fn valve_beside(&self) -> Judged {
        match self.valve {
            ValveView::InChain => {
                Err("the command alone was recorded: a dead band looks like the muscle's own hysteresis"
                    .to_owned())
            }
            ValveView::Unseen | ValveView::Beside(_) => self.valve_seen(),
        }
    }

    fn speeds(&self) -> Judged {
        let Excitation { slowest, fastest, speed_ratio, swings, .. } = self.excitation;
        let unit = self.unit;
        if *swings == 0 {
            return Err("the input never swings".to_owned());
        }
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

    fn lag(&self) -> Judged {
        let holds = self.excitation.holds.len();
        match self.speeds() {
            Err(why) if holds >= LAG_HOLDS => Ok(format!(
                "{holds} holds in which what lags comes after, the longest {:.1} s; but {why}",
                self.longest()
            )),
            Err(why) => {
                Err(format!("{why}; holds would do as well, {LAG_HOLDS} at least, and there are {holds}"))
            }
            seen => seen,
        }
    }

    fn ringing(&self) -> Judged {
        let Excitation { fastest, jumps, input_span, step_s, .. } = self.excitation;
        let unit = self.unit;
        // Differences of times are rounded.
        if *step_s > RINGING_STEP_S * (1.0 + ROUNDING) {
            let (rate_hz, least_hz) = (1.0 / step_s, 1.0 / RINGING_STEP_S);
            return Err(format!(
                "{} rows a second are too few for ringing, at least {least_hz:.0} are needed",
                apart(rate_hz, least_hz, 0)
            ));
        }
        let needed = FAST_SPANS * input_span;
        if *fastest < needed {
            return Err(format!(
                "the fastest swing has {} {unit}/s, and {} {unit}/s is needed to excite a mass",
                legible(*fastest, 2),
                legible(needed, 2)
            ));
        }
        Ok(format!("swings of up to {} {unit}/s, {jumps} jumps that end in a hold", legible(*fastest, 2)))
    }

    fn creep(&self) -> Judged {
        let (holds, longest) = (self.excitation.holds.len(), self.longest());
        let words = match holds {
            0 => "there is no hold of 1 s or more".to_owned(),
            _ => format!("{holds} holds, the longest {longest:.1} s"),
        };
        let plateaus_s = &self.excitation.plateaus_s;
        if longest >= CREEP_HOLD_S {
            Ok(words)
        } else if plateaus_s.len() >= CREEP_PLATEAUS {
            let longest_s = plateaus_s.iter().fold(0.0_f64, |longest, length| longest.max(*length));
            Ok(format!(
                "{words}; but after {} jumps the input moves by little, for {longest_s:.1} s at most",
                plateaus_s.len()
            ))
        } else {
            Err(format!("{words}; creep needs one of {CREEP_HOLD_S} s at least"))
        }
    }

    fn column(&self, name: &str, unit: &str, column: Option<Variation>) -> Judged {
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

    fn repeats(&self) -> Judged {
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

    fn travel(&self) -> Judged {
        let strokes = self.excitation.travel_strokes;
        let repeats = self.repeats()?;
        if strokes >= WARM_UP_STROKES {
            Ok(format!("{repeats}; a travel of {strokes:.1} strokes"))
        } else {
            let strokes = apart(strokes, WARM_UP_STROKES, 1);
            Err(format!("a travel of {strokes} strokes, and {WARM_UP_STROKES} are needed"))
        }
    }

    fn tone(&self) -> Judged {
        let Excitation { duration_s, step_s, .. } = self.excitation;
        // The last row lasts as long as the others.
        let lasts_s = duration_s + step_s;
        if lasts_s < TONE_S * (1.0 - ROUNDING) {
            return Err(format!("{} s are too short, {TONE_S} s are needed", apart(lasts_s, TONE_S, 1)));
        }
        Ok(format!("frequencies from {:.3} to {:.1} Hz", 4.0 / duration_s, 0.5 / step_s))
    }

    fn shape(&self) -> Judged {
        let Excitation { heights, swings, .. } = self.excitation;
        match (*swings, *heights) {
            (0, _) => Err("the input never swings".to_owned()),
            (_, heights) if heights < HEIGHTS => {
                Ok(format!("swings of {heights} different heights only: inner loops hardly show"))
            }
            (_, heights) => Ok(format!("swings of {heights} different heights")),
        }
    }

    fn longest(&self) -> f64 {
        self.excitation.longest_hold_s()
    }
}

#[cfg(test)]
mod tests;
