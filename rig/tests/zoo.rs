//! The zoo as its users see it: recordings and truths by seed.

use rig::effect::Effect;
use rig::zoo::excitation::Excitation;
use rig::zoo::exhibit::Exhibit;
use rig::zoo::family::{Family, Part};
use rig::zoo::valve::ValveKind;

fn csv(exhibit: &Exhibit) -> String {
    let mut csv = Vec::new();
    exhibit.recording().write(&mut csv).expect("written");
    String::from_utf8(csv).expect("text")
}

/// Short recordings of the first seeds.
fn short(seeds: std::ops::Range<u64>) -> impl Iterator<Item = Exhibit> {
    seeds.map(Exhibit::of).map(|mut exhibit| {
        exhibit.clock.duration_s = 20.0;
        exhibit
    })
}

#[test]
fn the_same_seed_gives_the_same_recording_and_truth_and_another_seed_another_one() {
    for exhibit in short(1..12) {
        let again = short(exhibit.seed..exhibit.seed + 1).next().expect("one");
        assert_eq!(csv(&exhibit), csv(&again));
        let truth = |exhibit: &Exhibit| serde_json::to_string(&exhibit.truth()).expect("JSON");
        assert_eq!(truth(&exhibit), truth(&again));
        let other = short(exhibit.seed + 1..exhibit.seed + 2).next().expect("one");
        assert_ne!(csv(&exhibit), csv(&other));
    }
}

#[test]
fn every_family_valve_experiment_and_effect_is_drawn_and_parts_share_no_family() {
    let exhibits: Vec<_> = (0..600).map(Exhibit::of).collect();
    for family in Family::all() {
        assert!(exhibits.iter().any(|exhibit| exhibit.family == family), "{family:?}");
        assert_eq!(Part::ALL.iter().filter(|part| family.part() == **part).count(), 1);
    }
    assert!(ValveKind::ALL.iter().all(|valve| exhibits.iter().any(|exhibit| exhibit.valve == *valve)));
    assert!(Excitation::ALL.iter().all(|excitation| exhibits.iter().any(|e| e.excitation == *excitation)));
    for effect in Effect::ALL {
        assert!(exhibits.iter().any(|exhibit| exhibit.hidden == [effect]), "{effect:?} alone");
    }
}

#[test]
fn an_effect_of_no_strength_is_not_there_and_hiding_one_changes_no_other_draw() {
    for (seed, effect) in (1..).zip(Effect::ALL) {
        let [mut none, mut sound] = [Exhibit::with(seed, vec![effect], 0.0), Exhibit::sound(seed)];
        [none.clock.duration_s, sound.clock.duration_s] = [10.0; 2];
        assert_eq!(none.recording().rows, sound.recording().rows, "{effect:?}");
    }
}

#[test]
fn every_effect_changes_a_recording_that_shows_all_and_a_sound_plant_has_nothing_to_see() {
    for effect in Effect::ALL {
        let mut exhibit = Exhibit::with(7, vec![effect], 1.0);
        exhibit.excitation = Excitation::Mix;
        exhibit.channels.command = true;
        exhibit.channels.pressure = true;
        let truth = exhibit.truth();
        let [visible] = truth.visible.as_slice() else { panic!("{effect:?}") };
        assert!(visible.change > 0.0 && visible.after_refit <= visible.change * 1.2, "{visible:?}");
        assert!(visible.examinable, "{visible:?} beside noise of {} mm", truth.noise_mm);
    }
    assert!(Exhibit::sound(7).truth().visible.is_empty());
}

#[test]
fn what_the_valve_does_cannot_be_seen_where_only_the_pressure_is_recorded() {
    let mut exhibit = Exhibit::with(7, vec![Effect::ValveLag], 1.0);
    (exhibit.channels.command, exhibit.channels.pressure) = (false, true);
    assert!(!exhibit.truth().visible[0].examinable);
    (exhibit.channels.command, exhibit.channels.pressure) = (true, false);
    let truth = exhibit.truth();
    assert!(truth.visible[0].examinable && truth.also_true == ["valve_lag"]);
}
