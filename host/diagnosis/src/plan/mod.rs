//! Excitations: commands whose recording tells apart what another recording has left confounded.
//!
//! # Design
//! Each cause needs some parts; a plan has those of its causes, after the parts that every plan has,
//! in a fixed order. All begins and ends at the lowest command. A wanted duration is met by stretching slow pieces and
//! holds; fast pieces stay as fast as they are, since their speed is what they are for.
//!
//! # Limits
//! A slew limit slows the fast pieces down; how fast they still are is the user's to judge.

pub mod part;
#[cfg(test)]
mod tests;

use std::cmp::Ordering;
use std::fmt::Write as _;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use thiserror::Error;

use self::part::Part;
use crate::causes::Cause;
use recording::TOOL;
use recording::course::{Course, Limits};

/// How far slow pieces may be stretched, as a factor.
const STRETCH: (f64, f64) = (0.5, 20.0);
/// The most rows of a plan.
const MOST_ROWS: f64 = 1e7;
/// Pressures that a muscle can be asked for. Unit: bar.
const PLAUSIBLE_BAR: (f64, f64) = (-1.0, 100.0);

/// What is to be planned.
#[derive(Clone, Debug)]
pub struct Wish {
    /// The causes to tell apart; none for all that need no hand.
    pub causes: Vec<Cause>,
    /// What the command must keep to.
    pub limits: Limits,
    /// How long it shall take. Unit: s.
    pub duration_s: Option<f64>,
    /// Rows a second, above 0.
    pub rate_hz: f64,
    /// Seed of the random ramps.
    pub seed: u64,
}

/// A planned excitation.
#[derive(Clone, Debug)]
pub struct Plan {
    causes: Vec<Cause>,
    rate_hz: f64,
    course: Course,
    /// The parts, each with its end. Unit: s.
    parts: Vec<(Part, f64)>,
}

/// Why there is no plan.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs, reason = "the messages say what the variants and their fields are")]
pub enum PlanError {
    #[error("the range of the command is {min_bar} to {max_bar} bar; the lower must come first")]
    Range { min_bar: f64, max_bar: f64 },
    #[error("{value} bar is outside {} to {} bar, what a muscle can be asked for", PLAUSIBLE_BAR.0, PLAUSIBLE_BAR.1)]
    Implausible { value: f64 },
    #[error("a duration of {wanted_s} s is too short: these parts take {least_s:.0} s at least")]
    TooShort { wanted_s: f64, least_s: f64 },
    #[error(
        "a duration of {wanted_s} s is too long: these parts take {most_s:.0} s at most; play the plan twice"
    )]
    TooLong { wanted_s: f64, most_s: f64 },
    #[error("{rows:.0} rows are too many, the limit is {MOST_ROWS:.0}; a lower rate has fewer")]
    TooManyRows { rows: f64 },
}

impl Plan {
    /// Plans.
    ///
    /// # Errors
    /// The range is none or no muscle's, the parts do not fit the duration, or there would be too many rows.
    pub fn new(wish: &Wish) -> Result<Self, PlanError> {
        let Limits { min_bar, max_bar, .. } = wish.limits;
        // A NaN is no range either.
        if min_bar.partial_cmp(&max_bar) != Some(Ordering::Less) {
            return Err(PlanError::Range { min_bar, max_bar });
        }
        let (least, most) = PLAUSIBLE_BAR;
        if let Some(value) = [min_bar, max_bar].into_iter().find(|bar| !(least..=most).contains(bar)) {
            return Err(PlanError::Implausible { value });
        }
        let causes = if wish.causes.is_empty() { without_hand() } else { wish.causes.clone() };
        let parts: Vec<Part> = Part::ALL
            .into_iter()
            .filter(|part| part.is_always() || causes.iter().any(|cause| cause.about().parts.contains(part)))
            .collect();
        let plan = |stretch: f64| {
            let (course, parts) = draw(&parts, wish, stretch);
            Self { causes: causes.clone(), rate_hz: wish.rate_hz, course, parts }
        };
        let plan = plan(match wish.duration_s {
            Some(wanted_s) => stretch(wanted_s, |stretch| plan(stretch).duration_s())?,
            None => 1.0,
        });
        let rows = plan.duration_s() * wish.rate_hz;
        if rows > MOST_ROWS {
            return Err(PlanError::TooManyRows { rows });
        }
        Ok(plan)
    }

    /// From the first row to the last. Unit: s.
    pub fn duration_s(&self) -> f64 {
        self.course.duration_s()
    }

    /// Time (s) and command (bar) of every row.
    pub fn rows(&self) -> impl Iterator<Item = (f64, f64)> {
        // The last row is at the end or just behind it. The margin is for an end that rounding puts behind a row.
        let count = (self.duration_s() * self.rate_hz - 1e-6).ceil() as usize + 1;
        let time_s = move || (0..count).map(|row| row as f64 / self.rate_hz);
        time_s().zip(self.course.samples(time_s()))
    }

    /// What the plan is for, its parts with their times, and what to see to: a line each.
    pub fn words(&self) -> Vec<String> {
        let names: Vec<&str> = self.causes.iter().map(|cause| cause.name()).collect();
        let mut from_s = 0.0;
        let parts = self.parts.iter().map(|(part, to_s)| {
            let line = format!("{from_s:.1} to {to_s:.1} s: {}", part.purpose());
            from_s = *to_s;
            line
        });
        [format!("excitation for {}", names.join(", "))]
            .into_iter()
            .chain(parts)
            .chain(told_apart(&self.causes))
            .chain(notes(&self.causes).into_iter().map(str::to_owned))
            .collect()
    }

    /// The file: the words as comments, then `time_s,command_bar`.
    pub fn to_csv(&self) -> String {
        let mut text = String::new();
        for line in self.words() {
            text += &format!("# {line}\n");
        }
        text += &format!("# {TOOL}\ntime_s,command_bar\n");
        for (time_s, command_bar) in self.rows() {
            // Writing to a string does not fail.
            let _ = writeln!(text, "{},{}", rounded(time_s, 1e6), rounded(command_bar, 1e5));
        }
        text
    }
}

/// The causes that show without a hand on the muscle.
fn without_hand() -> Vec<Cause> {
    Cause::ALL.into_iter().filter(|cause| !cause.about().by_hand).collect()
}

/// Where causes part that are easily taken for each other: a line a pair.
fn told_apart(causes: &[Cause]) -> Vec<String> {
    let mut lines = Vec::new();
    for one in Cause::ALL.into_iter().filter(|cause| causes.contains(cause)) {
        let told = one.about().told_from.iter();
        let told = told.filter(|(other, _)| causes.iter().any(|cause| cause.name() == *other));
        lines.extend(told.map(|(other, words)| format!("{one} or {other}: {words}")));
    }
    lines
}

/// What has to be done beside playing the command, each thing once.
fn notes(causes: &[Cause]) -> Vec<&'static str> {
    let mut notes: Vec<&str> = causes.iter().filter_map(|cause| cause.about().note).collect();
    notes.sort_unstable();
    notes.dedup();
    notes
}

/// All parts, and where each ends (s).
fn draw(parts: &[Part], wish: &Wish, stretch: f64) -> (Course, Vec<(Part, f64)>) {
    let mut random = ChaCha8Rng::seed_from_u64(wish.seed);
    let mut course = Course::new(wish.limits);
    let parts = parts.iter().map(|&part| {
        part.draw(&mut course, stretch, &mut random);
        (part, course.duration_s())
    });
    let parts = parts.collect();
    (course, parts)
}

/// How far slow pieces are stretched for all to take so long.
fn stretch(wanted_s: f64, duration_s: impl Fn(f64) -> f64) -> Result<f64, PlanError> {
    const HALVINGS: usize = 40;
    let (mut low, mut high) = STRETCH;
    let (least_s, most_s) = (duration_s(low), duration_s(high));
    if wanted_s < least_s {
        return Err(PlanError::TooShort { wanted_s, least_s });
    }
    if wanted_s > most_s {
        return Err(PlanError::TooLong { wanted_s, most_s });
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if duration_s(middle) < wanted_s {
            low = middle;
        } else {
            high = middle;
        }
    }
    Ok(high)
}

/// A number with so many parts of 1.
fn rounded(value: f64, parts: f64) -> f64 {
    (value * parts).round() / parts
}
