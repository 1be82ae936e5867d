//! Games on the zoo of plants: each is drawn whole by its seed.

use std::collections::BTreeSet;
use std::time::Instant;

use rayon::prelude::*;
use rig::effect::Effect;
use rig::zoo::exhibit::{Exhibit, ExhibitTruth};
use rig::zoo::family::Part;

use super::case::Group;
use super::finder::Finder;
use super::judged::Truths;
use super::table::Played;

/// The first `games` seeds from `first_seed` on whose families are of these parts.
pub fn games(first_seed: u64, games: usize, parts: &[Part]) -> Vec<Exhibit> {
    exhibits(first_seed, games, parts, Exhibit::of)
}

/// The same with nothing hidden.
pub fn sound(first_seed: u64, games: usize, parts: &[Part]) -> Vec<Exhibit> {
    exhibits(first_seed, games, parts, Exhibit::sound)
}

fn exhibits(first_seed: u64, games: usize, parts: &[Part], of: fn(u64) -> Exhibit) -> Vec<Exhibit> {
    let all = (first_seed..).map(of).filter(|exhibit| parts.contains(&exhibit.family.part()));
    all.take(games).collect()
}

/// What is asked of a diagnosis of an exhibit.
fn group(exhibit: &Exhibit) -> Group {
    Group::of(&exhibit.hidden, exhibit.is_strong())
}

/// What is true of an exhibit's recording.
fn truths(exhibit: &Exhibit, truth: &ExhibitTruth) -> Truths {
    let is_cause = |name: &str| Effect::causes().iter().any(|cause| cause.name() == name);
    let visible = || truth.visible.iter();
    let of = |shown: bool| -> BTreeSet<String> {
        let causes = visible().filter(|visible| is_cause(visible.effect) && visible.examinable == shown);
        causes.map(|visible| visible.effect.to_owned()).collect()
    };
    let mut unseen = of(false);
    unseen.extend(truth.also_true.iter().map(|name| (*name).to_owned()));
    let outsider = visible()
        .find(|visible| !is_cause(visible.effect))
        .map(|visible| (visible.effect.to_owned(), visible.examinable));
    debug_assert_eq!(exhibit.hidden.len(), truth.visible.len());
    Truths { shown: of(true), unseen, outsider }
}

/// Plays one game.
fn play_one(exhibit: &Exhibit, finder: &impl Finder) -> Played {
    let truth = exhibit.truth();
    let mut csv = Vec::new();
    let written = exhibit.recording().write(&mut csv);
    let start = Instant::now();
    let found = written.map_err(Into::into).and_then(|()| finder.find(&csv));
    Played {
        name: format!("zoo --seed {}", exhibit.seed),
        part: exhibit.family.part().name(),
        family: format!("{} {}", exhibit.family.law.name(), exhibit.family.friction.name()),
        excitation: exhibit.excitation.name(),
        is_sealed: exhibit.family.part() == Part::Sealed,
        group: group(exhibit),
        truths: truths(exhibit, &truth),
        truth: serde_json::json!(truth),
        found: found.map_err(|error| format!("{error:#}")),
        seconds: start.elapsed().as_secs_f64(),
    }
}

/// Plays all games side by side, telling `finished` after each.
pub fn play(exhibits: &[Exhibit], finder: &impl Finder, finished: impl Fn(&Played) + Sync) -> Vec<Played> {
    let one = |exhibit: &Exhibit| {
        let played = play_one(exhibit, finder);
        finished(&played);
        played
    };
    exhibits.par_iter().map(one).collect()
}
