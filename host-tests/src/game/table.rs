//! The figures of many games, by the part of their families and by what is hidden.

use std::collections::BTreeSet;
use std::fmt;

use serde_json::{Value, json};

use super::case::Group;
use super::finder::Found;
use super::judged::{Judgement, Truths};

/// One game that was played.
#[derive(Debug, Clone)]
pub struct Played {
    /// The arguments of `rig` that make its recording.
    pub name: String,
    /// The part of its family, or that it is of the two old plants.
    pub part: &'static str,
    /// Its family.
    pub family: String,
    /// Its experiment.
    pub excitation: &'static str,
    /// Whether only totals of it are printed.
    pub is_sealed: bool,
    /// What is asked.
    pub group: Group,
    /// What is true.
    pub truths: Truths,
    /// The same with all parameters.
    pub truth: Value,
    /// What was said, or why nothing was.
    pub found: Result<Found, String>,
    /// How long that took, s.
    pub seconds: f64,
}

impl Played {
    /// What the answer is worth.
    pub fn judgement(&self) -> Judgement {
        self.found.as_ref().map_or(Judgement::Wrong, |found| self.truths.judge(found))
    }

    /// The game as JSON.
    pub fn to_json(&self) -> Value {
        let found = self.found.as_ref();
        json!({
            "recording": self.name,
            "part": self.part,
            "family": self.family,
            "group": self.group.to_string(),
            "truth": self.truth,
            "verdict": found.map_or("error", |found| &found.verdict),
            "causes": found.map_or(json!(null), |found| json!(found.causes)),
            "alternatives": found.map_or(json!(null), |found| json!(found.alternatives)),
            "error": found.err(),
            "judgement": format!("{:?}", self.judgement()),
            "seconds": self.seconds,
        })
    }
}

/// A game and what was said, in a line.
impl fmt::Display for Played {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let join = |names: &BTreeSet<String>| names.iter().cloned().collect::<Vec<_>>().join("+");
        let said = self.found.as_ref().map_or_else(Clone::clone, ToString::to_string);
        write!(f, "{}: {:?}: {} in {}", self.name, self.judgement(), self.group, self.excitation)?;
        let Truths { shown, unseen, outsider } = &self.truths;
        write!(
            f,
            " ({}); shown {}",
            self.family,
            if shown.is_empty() { "none".to_owned() } else { join(shown) }
        )?;
        if !unseen.is_empty() {
            write!(f, ", unseen {}", join(unseen))?;
        }
        if let Some((outsider, is_shown)) = outsider {
            write!(f, ", outsider {outsider}{}", if *is_shown { "" } else { " unseen" })?;
        }
        write!(f, "; said {said}, {:.1} s", self.seconds)?;
        if let Ok(found) = &self.found {
            found.alternatives.iter().try_for_each(|set| write!(f, " or {}", join(set)))?;
        }
        Ok(())
    }
}

/// Where the true share lies with a confidence of 95 %, by Wilson's interval.
pub fn wilson(count: usize, of: usize) -> (f64, f64) {
    // Standard deviations of a normal distribution that hold 95 % of it.
    const DEVIATIONS: f64 = 1.96;
    let (of, square) = (of.max(1) as f64, DEVIATIONS * DEVIATIONS);
    let share = count as f64 / of;
    let centre = share + square / (2.0 * of);
    let half = DEVIATIONS * (share * (1.0 - share) / of + square / (4.0 * of * of)).sqrt();
    ((centre - half) / (1.0 + square / of), (centre + half) / (1.0 + square / of))
}

/// How often something is named where nothing is hidden.
pub struct FalseNames<'a>(pub &'a [Played]);

impl fmt::Display for FalseNames<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let is_named = |played: &&Played| {
            let named = |found: &Found| {
                let unseen = &played.truths.unseen;
                found.verdict != "unexplained" && found.causes.keys().any(|cause| !unseen.contains(cause))
            };
            played.found.as_ref().is_ok_and(named)
        };
        let of_verdict = |verdict: &str| {
            self.0.iter().filter(|p| p.found.as_ref().is_ok_and(|f| f.verdict == verdict)).count()
        };
        let (named, all) = (self.0.iter().filter(is_named).count(), self.0.len());
        let (low, high) = wilson(named, all);
        let share = 100.0 * named as f64 / all.max(1) as f64;
        let (low, high) = (100.0 * low, 100.0 * high);
        writeln!(
            f,
            "nothing hidden: a cause is named in {named} of {all}, {share:.2} % ({low:.2} to {high:.2} %)"
        )?;
        let verdicts = ["adequate", "explained", "confounded", "unexplained"];
        let counts: Vec<_> =
            verdicts.iter().map(|verdict| format!("{verdict} {}", of_verdict(verdict))).collect();
        let errors = self.0.iter().filter(|played| played.found.is_err()).count();
        writeln!(f, "verdicts: {}; no answer {errors}", counts.join(", "))
    }
}

/// Figures of many games.
pub struct Figures<'a>(pub &'a [Played]);

/// How often each judgement was made.
#[derive(Default)]
struct Counts([usize; 5]);

impl Counts {
    fn of<'a>(games: impl Iterator<Item = &'a Played>) -> Self {
        games.fold(Self::default(), |mut counts, played| {
            counts.0[played.judgement() as usize] += 1;
            counts
        })
    }

    fn write(&self, f: &mut fmt::Formatter<'_>, part: &str, group: &str) -> fmt::Result {
        let Self([exact, confounded, unexplained, wrong, confident]) = *self;
        let games: usize = self.0.iter().sum();
        let share = |count: usize| 100.0 * count as f64 / games.max(1) as f64;
        write!(f, "{part:<12} {group:<18} {games:>5} {exact:>6} {:>5.1} % {confounded:>10}", share(exact))?;
        write!(f, " {unexplained:>11} {:>6} {confident:>11} {:>5.1} %", wrong + confident, share(confident))?;
        writeln!(f)
    }
}

impl fmt::Display for Figures<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:<12} {:<18} {:>5} {:>14} {:>10}", "families", "hidden", "games", "exact", "confounded")?;
        writeln!(f, " {:>11} {:>6} {:>19}", "unexplained", "wrong", "confidently wrong")?;
        let mut parts: Vec<_> = self.0.iter().map(|played| played.part).collect();
        parts.sort_unstable();
        parts.dedup();
        for part in parts {
            let of_part = || self.0.iter().filter(move |played| played.part == part);
            for group in Group::ALL {
                let of_group = || of_part().filter(move |played| played.group == group);
                if of_group().next().is_some() {
                    Counts::of(of_group()).write(f, part, &group.to_string())?;
                }
            }
            Counts::of(of_part()).write(f, part, "all")?;
        }
        let mut seconds: Vec<_> = self.0.iter().map(|played| played.seconds).collect();
        seconds.sort_by(f64::total_cmp);
        let Some(longest) = seconds.last() else { return Ok(()) };
        let of = |share: f64| seconds[((seconds.len() - 1) as f64 * share) as usize];
        writeln!(f, "seconds: median {:.1}, 95 % below {:.1}, longest {longest:.1}", of(0.5), of(0.95))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wilsons_interval_is_that_of_the_tables() {
        let (low, high) = wilson(0, 100);
        assert!(low.abs() < 1e-12 && (high - 0.0370).abs() < 1e-4, "{low} {high}");
        let (low, high) = wilson(10, 100);
        assert!((low - 0.0552).abs() < 1e-4 && (high - 0.1744).abs() < 1e-4, "{low} {high}");
    }
}
