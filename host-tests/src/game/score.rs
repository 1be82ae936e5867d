//! What came of the games: who was right in which group, what was said instead, how near the parameters are.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::time::Duration;

use rig::truth::Truth;
use serde_json::{Value, json};

use super::case::{Case, Group};
use super::finder::Found;
use super::judged::Truths;
use super::table::Played;

/// Parameters that a right diagnosis has to give within [`TOLERANCE`]: times, delays and amplitudes.
const HELD: [&str; 5] = ["time_constant_s", "delay_s", "amplitude_mm", "band_bar", "supply_bar"];

/// Relative error that is allowed to a parameter.
const TOLERANCE: f64 = 0.15;

/// One game and what came of it.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// The game.
    pub case: Case,
    /// What was hidden.
    pub truth: Truth,
    /// What was said, or why nothing was.
    pub found: Result<Found, String>,
    /// How long that took.
    pub duration: Duration,
}

impl Outcome {
    pub(super) fn new(case: Case, truth: Truth, found: Result<Found, String>, duration: Duration) -> Self {
        Self { case, truth, found, duration }
    }

    /// Whether the verdict is right: the exact set of causes; for an outsider `unexplained`, or its very name.
    pub fn is_right(&self) -> bool {
        let Truth { causes, outsiders } = &self.truth;
        self.found.as_ref().is_ok_and(|found| {
            let is_outside = !outsiders.is_empty() && found.verdict == "unexplained";
            is_outside || found.names(causes.keys().chain(outsiders.keys()).copied())
        })
    }

    /// The same for the table of all games. Both old protocols show everything.
    pub fn played(&self) -> Played {
        let outsider = self.truth.outsiders.keys().next().map(|name| ((*name).to_owned(), true));
        let shown = self.truth.causes.keys().map(|name| (*name).to_owned()).collect();
        Played {
            name: self.case.to_string(),
            part: "old plants",
            family: String::new(),
            excitation: "rich",
            is_sealed: false,
            group: self.case.group(),
            truths: Truths { shown, unseen: BTreeSet::new(), outsider },
            truth: json!(self.truth),
            found: self.found.clone(),
            seconds: self.duration.as_secs_f64(),
        }
    }

    /// Relative errors of the parameters that are both hidden and found, by cause and name.
    fn errors(&self) -> impl Iterator<Item = (String, f64)> {
        let found = self.found.as_ref().ok();
        self.truth.causes.iter().flat_map(move |(cause, hidden)| {
            let reported = found.and_then(|found| found.causes.get(*cause));
            hidden.iter().filter_map(move |(name, hidden)| {
                let (hidden, reported) = (hidden.as_f64()?, reported?.get(name).and_then(Value::as_f64)?);
                Some((format!("{cause}.{name}"), (reported / hidden - 1.0).abs()))
            })
        })
    }
}

/// How many of how many.
#[derive(Debug, Clone, Copy, Default)]
struct Tally {
    right: usize,
    all: usize,
}

impl Tally {
    fn of(right: impl Iterator<Item = bool>) -> Self {
        right.fold(Self::default(), |tally, right| Self {
            right: tally.right + usize::from(right),
            all: tally.all + 1,
        })
    }

    fn share(self) -> f64 {
        self.right as f64 / self.all as f64
    }
}

/// The result of many games.
#[derive(Debug)]
pub struct Score<'a> {
    outcomes: &'a [Outcome],
    /// Misses that each group is forgiven beyond its bound.
    forgiven: usize,
}

impl<'a> Score<'a> {
    /// Of the whole game.
    pub fn of_whole(outcomes: &'a [Outcome]) -> Self {
        Self { outcomes, forgiven: 0 }
    }

    /// Of a sample: a group of a few games is forgiven one of them.
    pub fn of_sample(outcomes: &'a [Outcome]) -> Self {
        Self { outcomes, forgiven: 1 }
    }

    /// What stays under its bound; nothing if all is well.
    pub fn failures(&self) -> Vec<String> {
        let groups = self.groups().filter_map(|(group, tally)| {
            let enough = (tally.right + self.forgiven) as f64 >= group.bound() * tally.all as f64;
            let share = 100.0 * tally.share();
            (!enough).then(|| format!("{group}: {share:.1} %, below {:.0} %", 100.0 * group.bound()))
        });
        let parameters = self.parameters().into_iter().filter_map(|(name, errors)| {
            let held = name.split('.').next_back().is_some_and(|name| HELD.contains(&name));
            let outside = errors.iter().filter(|error| **error > TOLERANCE).count();
            (held && outside > self.forgiven)
                .then(|| format!("{name}: {outside} of {} off by more than 15 %", errors.len()))
        });
        groups.chain(parameters).collect()
    }

    fn of_group(&self, group: Group) -> impl Iterator<Item = &Outcome> {
        self.outcomes.iter().filter(move |outcome| outcome.case.group() == group)
    }

    fn groups(&self) -> impl Iterator<Item = (Group, Tally)> {
        Group::ALL
            .into_iter()
            .map(|group| (group, Tally::of(self.of_group(group).map(Outcome::is_right))))
            .filter(|(_, tally)| tally.all > 0)
    }

    /// Relative errors at full strength where the verdict is right, in ascending order.
    fn parameters(&self) -> BTreeMap<String, Vec<f64>> {
        let mut parameters = BTreeMap::<String, Vec<f64>>::new();
        for outcome in self.of_group(Group::Strong).filter(|outcome| outcome.is_right()) {
            for (name, error) in outcome.errors() {
                parameters.entry(name).or_default().push(error);
            }
        }
        parameters.values_mut().for_each(|errors| errors.sort_by(f64::total_cmp));
        parameters
    }

    /// How often each answer was given, the most frequent first.
    fn answers<'b>(outcomes: impl Iterator<Item = &'b Outcome>) -> String {
        let mut counts = BTreeMap::<String, usize>::new();
        for outcome in outcomes {
            let answer =
                outcome.found.as_ref().map_or_else(|error| format!("error: {error}"), Found::to_string);
            *counts.entry(answer).or_default() += 1;
        }
        let mut counts: Vec<_> = counts.into_iter().collect();
        counts.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
        counts.iter().map(|(answer, count)| format!("{answer} x{count}")).collect::<Vec<_>>().join(", ")
    }
}

/// The confusion table: groups, then each hidden thing with what was said instead, then the parameters.
impl fmt::Display for Score<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{:<20} {:>11} {:>8} {:>8}", "group", "right", "share", "bound")?;
        for (group, tally) in self.groups() {
            let right = format!("{} of {}", tally.right, tally.all);
            let (share, bound) = (100.0 * tally.share(), 100.0 * group.bound());
            writeln!(f, "{group:<20} {right:>11} {share:>6.1} % {bound:>6.1} %")?;
        }
        writeln!(f, "\n{:<42} {:>11}  said instead", "hidden", "right")?;
        for group in Group::ALL {
            let mut hidden: Vec<String> = self.of_group(group).map(|outcome| outcome.case.hidden()).collect();
            hidden.sort();
            hidden.dedup();
            for hidden in hidden {
                let of_hidden = || self.of_group(group).filter(|outcome| outcome.case.hidden() == hidden);
                let tally = Tally::of(of_hidden().map(Outcome::is_right));
                let (right, wrong) = (
                    format!("{} of {}", tally.right, tally.all),
                    of_hidden().filter(|outcome| !outcome.is_right()),
                );
                let weak = if matches!(group, Group::Weak | Group::WeakOutsider) { ", weak" } else { "" };
                writeln!(f, "{:<42} {right:>11}  {}", format!("{hidden}{weak}"), Self::answers(wrong))?;
            }
        }
        writeln!(
            f,
            "\n{:<42} {:>8} {:>8} {:>8} {:>12}",
            "parameter", "cases", "median", "worst", "within 15 %"
        )?;
        for (name, errors) in self.parameters() {
            let within = Tally::of(errors.iter().map(|error| *error <= TOLERANCE));
            let [median, worst] = [errors.len() / 2, errors.len() - 1].map(|index| 100.0 * errors[index]);
            let share = 100.0 * within.share();
            writeln!(f, "{name:<42} {:>8} {median:>6.1} % {worst:>6.1} % {share:>10.0} %", errors.len())?;
        }
        let seconds = self.outcomes.iter().map(|outcome| outcome.duration.as_secs_f64());
        let (longest, sum) =
            seconds.fold((0.0, 0.0), |(longest, sum), seconds: f64| (seconds.max(longest), sum + seconds));
        let mean = sum / self.outcomes.len().max(1) as f64;
        writeln!(f, "\na diagnosis took {mean:.2} s in the mean, {longest:.2} s at most")
    }
}

#[cfg(test)]
mod tests {
    use serde_json::Map;

    use super::*;
    use crate::game::case::{sample, whole};

    /// Somebody who knows the truth and reports it with every number `factor` times as large.
    fn knowing(case: Case, factor: f64) -> Outcome {
        let truth = case.plant().truth();
        let scaled = |parameters: &Map<String, Value>| {
            let scaled = parameters
                .iter()
                .filter_map(|(name, value)| Some((name.clone(), json!(value.as_f64()? * factor))));
            scaled.collect()
        };
        let causes = truth.causes.iter().map(|(name, parameters)| ((*name).to_owned(), scaled(parameters)));
        let verdict = if truth.outsiders.is_empty() { "explained" } else { "unexplained" };
        let found = Found { verdict: verdict.to_owned(), causes: causes.collect(), alternatives: Vec::new() };
        Outcome::new(case, truth, Ok(found), Duration::ZERO)
    }

    fn saying(case: Case, verdict: &str) -> Outcome {
        let truth = case.plant().truth();
        let found = Found { verdict: verdict.to_owned(), causes: BTreeMap::new(), alternatives: Vec::new() };
        Outcome::new(case, truth, Ok(found), Duration::ZERO)
    }

    #[test]
    fn whoever_knows_the_truth_fails_nowhere() {
        let outcomes: Vec<_> = whole(1, 1).into_iter().map(|case| knowing(case, 1.1)).collect();
        assert!(outcomes.iter().all(Outcome::is_right));
        assert_eq!(Score::of_whole(&outcomes).failures(), Vec::<String>::new());
    }

    #[test]
    fn whoever_says_the_same_of_everything_fails_in_every_other_group() {
        for (verdict, passed) in [
            ("adequate", &[Group::Nothing][..]),
            ("unexplained", &[Group::StrongOutsider]),
            ("confounded", &[]),
        ] {
            let outcomes: Vec<_> = sample(1).into_iter().map(|case| saying(case, verdict)).collect();
            let failures = Score::of_sample(&outcomes).failures();
            let groups: Vec<_> = Score::of_sample(&outcomes).groups().map(|(group, _)| group).collect();
            for group in groups {
                let failed = failures.iter().any(|failure| failure.starts_with(&group.to_string()));
                assert_eq!(failed, !passed.contains(&group), "{verdict} of {group}");
            }
        }
    }

    #[test]
    fn parameters_that_are_off_by_more_than_fifteen_percent_fail_by_name() {
        let outcomes: Vec<_> = sample(1).into_iter().map(|case| knowing(case, 1.2)).collect();
        let failures = Score::of_whole(&outcomes).failures();
        for name in ["transport_delay.delay_s", "viscous_lag.time_constant_s", "valve_deadband.band_bar"] {
            assert!(
                failures.iter().any(|failure| failure.starts_with(name)),
                "{name} is not in {failures:?}"
            );
        }
    }

    #[test]
    fn a_cause_too_many_one_too_few_and_a_second_thought_are_wrong() {
        let case = whole(1, 1).into_iter().find(|case| case.hidden() == "drift+warm_up").expect("a pair");
        let right = knowing(case, 1.0);
        let changed = |change: &dyn Fn(&mut Found)| {
            let mut outcome = right.clone();
            outcome.found.as_mut().map(change).expect("found");
            outcome.is_right()
        };
        assert!(changed(&|_| ()));
        assert!(!changed(&|found| drop(found.causes.remove("drift"))));
        assert!(!changed(&|found| drop(found.causes.insert("creep".to_owned(), Map::new()))));
        assert!(!changed(&|found| found.verdict = "confounded".to_owned()));
    }
}
