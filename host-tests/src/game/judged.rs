//! A verdict held against the truth: exact, confounded with the truth among the names, unexplained, or wrong.

use std::collections::BTreeSet;

use super::finder::Found;

/// What is true of a recording.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Truths {
    /// Causes that the recording can show: an exact answer names them.
    pub shown: BTreeSet<String>,
    /// Causes that are hidden or true besides, but that the recording cannot show: an answer may name them.
    pub unseen: BTreeSet<String>,
    /// An effect that is on no list, and whether the recording can show it. An exact answer is `unexplained`,
    /// or explained by its very name.
    pub outsider: Option<(String, bool)>,
}

/// What an answer is worth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Judgement {
    /// The very causes, said to explain the recording; for an outsider that it is unexplained.
    Exact,
    /// Confounded, the truth among the sets that are named.
    Confounded,
    /// Unexplained where a cause of the list is hidden, or nothing.
    Unexplained,
    /// Confounded without the truth, or no answer.
    Wrong,
    /// Explained by a wrong set, or adequate where the recording shows a cause.
    ConfidentlyWrong,
}

impl Truths {
    /// What `found` is worth.
    pub fn judge(&self, found: &Found) -> Judgement {
        let named: BTreeSet<String> = found.causes.keys().cloned().collect();
        match found.verdict.as_str() {
            "explained" | "adequate" if self.is_met_by(&named) => Judgement::Exact,
            "explained" | "adequate" => Judgement::ConfidentlyWrong,
            "unexplained" if self.outsider.is_some() => Judgement::Exact,
            "unexplained" => Judgement::Unexplained,
            _ if found.alternatives.iter().chain([&named]).any(|set| self.is_met_by(set)) => {
                Judgement::Confounded
            }
            _ => Judgement::Wrong,
        }
    }

    /// Whether these names are the truth as far as the recording shows it.
    fn is_met_by(&self, names: &BTreeSet<String>) -> bool {
        let mut names = names.clone();
        let outsider_is_met = match &self.outsider {
            Some((outsider, is_shown)) => names.remove(outsider) || !is_shown,
            None => true,
        };
        outsider_is_met
            && self.shown.is_subset(&names)
            && names.iter().all(|name| self.shown.contains(name) || self.unseen.contains(name))
    }
}

#[cfg(test)]
mod tests {
    use serde_json::Map;

    use super::*;

    fn said(verdict: &str, names: &[&str], alternatives: &[&[&str]]) -> Found {
        let set = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<BTreeSet<_>>();
        Found {
            verdict: verdict.to_owned(),
            causes: set(names).into_iter().map(|name| (name, Map::new())).collect(),
            alternatives: alternatives.iter().map(|names| set(names)).collect(),
        }
    }

    fn truths(shown: &[&str], unseen: &[&str]) -> Truths {
        let set = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
        Truths { shown: set(shown), unseen: set(unseen), outsider: None }
    }

    #[test]
    fn a_cause_that_the_recording_cannot_show_may_be_named_or_not() {
        use Judgement::{ConfidentlyWrong, Exact, Unexplained};
        let truths = truths(&["creep"], &["drift"]);
        for (found, judgement) in [
            (said("explained", &["creep"], &[]), Exact),
            (said("explained", &["creep", "drift"], &[]), Exact),
            (said("explained", &["drift"], &[]), ConfidentlyWrong),
            (said("explained", &["creep", "load"], &[]), ConfidentlyWrong),
            (said("adequate", &[], &[]), ConfidentlyWrong),
            (said("unexplained", &[], &[]), Unexplained),
        ] {
            assert_eq!(truths.judge(&found), judgement, "{found}");
        }
    }

    #[test]
    fn confounded_is_right_in_part_where_one_of_its_sets_is_the_truth() {
        let truths = truths(&["inertia"], &[]);
        let among = said("confounded", &["viscous_lag"], &[&["inertia"], &["transport_delay"]]);
        assert_eq!(truths.judge(&among), Judgement::Confounded);
        let not_among = said("confounded", &["viscous_lag"], &[&["transport_delay"]]);
        assert_eq!(truths.judge(&not_among), Judgement::Wrong);
    }

    #[test]
    fn an_outsider_is_unexplained_or_has_its_own_name() {
        let shown = Truths { outsider: Some(("leak".to_owned(), true)), ..Truths::default() };
        let unseen = Truths { outsider: Some(("leak".to_owned(), false)), ..Truths::default() };
        for (found, of_shown, of_unseen) in [
            (said("unexplained", &[], &[]), Judgement::Exact, Judgement::Exact),
            (said("explained", &["leak"], &[]), Judgement::Exact, Judgement::Exact),
            (said("adequate", &[], &[]), Judgement::ConfidentlyWrong, Judgement::Exact),
            (said("explained", &["drift"], &[]), Judgement::ConfidentlyWrong, Judgement::ConfidentlyWrong),
        ] {
            assert_eq!((shown.judge(&found), unseen.judge(&found)), (of_shown, of_unseen), "{found}");
        }
    }
}
