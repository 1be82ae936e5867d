//! Which games are played: every cause alone and in pairs, nothing at all, and what is on no list.

use std::fmt;

use anyhow::{Result, ensure};
use rig::effect::Effect;
use rig::effects::Effects;
use rig::plant::{Kind, Setup};

/// A strength that is plainly visible, and one that is just so.
pub const STRENGTHS: [f64; 2] = [1.0, 0.33];

/// Both plants.
const KINDS: [Kind; 2] = [Kind::Rig, Kind::Mgpi];

/// What is asked of a diagnosis, each with a bound of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Group {
    /// Nothing is hidden.
    Nothing,
    /// One cause, plainly visible.
    Strong,
    /// One cause, just visible.
    Weak,
    /// Two causes, not both of them fast.
    SlowPair,
    /// Two causes that act within fractions of a second: delay, lag, inertia, rate-dependent width.
    FastPair,
    /// Something that is on no list, plainly visible.
    StrongOutsider,
    /// Something that is on no list, just visible.
    WeakOutsider,
}

impl Group {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Nothing,
        Self::Strong,
        Self::Weak,
        Self::SlowPair,
        Self::FastPair,
        Self::StrongOutsider,
        Self::WeakOutsider,
    ];

    /// That of a game with these effects hidden.
    pub fn of(effects: &[Effect], is_strong: bool) -> Self {
        match effects {
            [] => Self::Nothing,
            [effect] if Effect::outsiders().contains(effect) && is_strong => Self::StrongOutsider,
            [effect] if Effect::outsiders().contains(effect) => Self::WeakOutsider,
            [_] if is_strong => Self::Strong,
            [_] => Self::Weak,
            pair if pair.iter().all(|effect| effect.is_fast()) => Self::FastPair,
            _ => Self::SlowPair,
        }
    }

    /// The share of right verdicts that is asked for.
    pub fn bound(self) -> f64 {
        match self {
            Self::Nothing => 0.98,
            Self::Strong => 0.97,
            Self::Weak => 0.93,
            Self::SlowPair => 0.90,
            Self::FastPair => 0.75,
            Self::StrongOutsider => 0.95,
            Self::WeakOutsider => 0.85,
        }
    }
}

impl fmt::Display for Group {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Nothing => "nothing hidden",
            Self::Strong => "one cause, strong",
            Self::Weak => "one cause, weak",
            Self::SlowPair => "slow pair",
            Self::FastPair => "fast pair",
            Self::StrongOutsider => "outsider, strong",
            Self::WeakOutsider => "outsider, weak",
        })
    }
}

/// One game.
#[derive(Debug, Clone, PartialEq)]
pub struct Case {
    /// The plant.
    pub kind: Kind,
    /// What is hidden in it.
    pub effects: Vec<Effect>,
    /// How strongly.
    pub strength: f64,
    /// Seed of everything random.
    pub seed: u64,
}

impl Case {
    /// What is asked of a diagnosis here.
    pub fn group(&self) -> Group {
        Group::of(&self.effects, self.strength == STRENGTHS[0])
    }

    /// What is hidden, by name.
    pub fn hidden(&self) -> String {
        let names: Vec<_> = self.effects.iter().map(|effect| effect.name()).collect();
        if names.is_empty() { "none".to_owned() } else { names.join("+") }
    }

    pub(super) fn setup(&self) -> Setup {
        Setup {
            kind: self.kind,
            effects: Effects::drawn(&self.effects, self.strength, self.seed),
            ..Setup::sound(self.seed)
        }
    }
}

/// By the arguments of `rig record` that make its recording.
impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let plant = if self.kind == Kind::Mgpi { " --plant mgpi" } else { "" };
        write!(f, "--hide {} --strength {} --seed {}{plant}", self.hidden(), self.strength, self.seed)
    }
}

/// The whole game from `first_seed` on: `seeds` seeds for everything that is alone and for fast pairs, ten
/// times as many for nothing, one for each slow pair; all on both plants.
pub fn whole(first_seed: u64, seeds: u64) -> Vec<Case> {
    let mut cases = Vec::new();
    let mut add = |effects: &[Effect], strengths: &[f64], seeds: u64| {
        for kind in KINDS {
            for &strength in strengths {
                cases.extend((first_seed..first_seed + seeds).map(|seed| Case {
                    kind,
                    effects: effects.to_vec(),
                    strength,
                    seed,
                }));
            }
        }
    };
    add(&[], &STRENGTHS[..1], 10 * seeds);
    for effect in Effect::ALL {
        add(&[effect], &STRENGTHS, seeds);
    }
    for pair in pairs() {
        let both_fast = pair.iter().all(|effect| effect.is_fast());
        add(&pair, &STRENGTHS[..1], if both_fast { seeds } else { 1 });
    }
    cases
}

/// Those of the games that have a text in their names, if one is given.
///
/// # Errors
/// There is none: a game of nothing would be passed by anybody.
pub fn only(mut cases: Vec<Case>, text: Option<&str>) -> Result<Vec<Case>> {
    if let Some(text) = text {
        cases.retain(|case| case.to_string().contains(text));
        ensure!(!cases.is_empty(), "no game has `{text}` in its name");
    }
    Ok(cases)
}

/// A small sample of the whole: every strong cause once and some of everything else, the plants in turn.
pub fn sample(first_seed: u64) -> Vec<Case> {
    let slow = pairs().filter(|pair| !pair.iter().all(|effect| effect.is_fast())).step_by(18);
    let fast = pairs().filter(|pair| pair.iter().all(|effect| effect.is_fast())).step_by(3);
    let strong = Effect::causes().iter().map(|cause| (vec![*cause], STRENGTHS[0]));
    let weak = Effect::causes().iter().step_by(3).map(|cause| (vec![*cause], STRENGTHS[1]));
    let outsiders = Effect::outsiders().iter().step_by(2).map(|outsider| (vec![*outsider], STRENGTHS[0]));
    let pairs = slow.chain(fast).map(|pair| (pair.to_vec(), STRENGTHS[0]));
    std::iter::repeat_n((Vec::new(), STRENGTHS[0]), 4)
        .chain(strong)
        .chain(weak)
        .chain(pairs)
        .chain(outsiders)
        .zip((first_seed..).zip(KINDS.into_iter().cycle()))
        .map(|((effects, strength), (seed, kind))| Case { kind, effects, strength, seed })
        .collect()
}

/// Every two causes.
fn pairs() -> impl Iterator<Item = [Effect; 2]> {
    let causes = Effect::causes();
    causes
        .iter()
        .enumerate()
        .flat_map(move |(index, &first)| causes[index + 1..].iter().map(move |&second| [first, second]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_whole_game_has_every_group_on_both_plants_in_the_numbers_that_its_bounds_are_for() {
        let cases = whole(1, 5);
        for (group, count) in Group::ALL.into_iter().zip([100, 130, 130, 144, 60, 80, 80]) {
            let of_group: Vec<_> = cases.iter().filter(|case| case.group() == group).collect();
            assert_eq!(of_group.len(), count, "{group}");
            assert_eq!(of_group.iter().filter(|case| case.kind == Kind::Rig).count(), count / 2, "{group}");
        }
    }

    #[test]
    fn a_text_that_no_game_has_is_refused() {
        let of_creep = only(sample(1), Some("creep")).expect("some");
        assert!(!of_creep.is_empty() && of_creep.iter().all(|case| case.hidden().contains("creep")));
        assert!(only(sample(1), Some("crepe")).is_err());
        assert_eq!(only(sample(1), None).expect("all").len(), sample(1).len());
    }

    #[test]
    fn the_sample_has_every_strong_cause_and_all_groups_but_weak_outsiders() {
        let cases = sample(1);
        let groups = Group::ALL.map(|group| cases.iter().filter(|case| case.group() == group).count());
        assert_eq!(groups, [4, 13, 5, 4, 2, 4, 0]);
    }
}
