//! Two muscles at a joint: angle, stiffness and cross-talk over joints that are drawn, and what is
//! recognised of a joint that is wired wrongly or is another one.

use board_client::joint::{JointWanted, Loop, parameters};
use board_client::pil::PilError;
use board_client::stop::Stop;
use host_tests::joint::{HostJoint, Tried, Wired, Wrong, csv, identified, recording, tried};
use identification::joint::{SWING_RAD, identify_joint};
use rayon::prelude::*;
use recording::joint::columns::JointRecording;
use recording::joint::file::JointFile;
use wire::Protection;
use wire::joint::JointFault;

/// Joints that are tried: seeds that nothing was chosen by.
const SEEDS: std::ops::RangeInclusive<u64> = 101..=108;

/// The most that the stiffness of any joint is off by, in percent: what is aimed at.
const STIFFNESS_PERCENT: f64 = 5.0;

#[test]
fn joints_follow_their_angle_and_are_as_stiff_as_asked_without_the_one_disturbing_the_other() {
    let all: Vec<(u64, Tried)> = SEEDS
        .into_par_iter()
        .map(|seed| (seed, tried(seed, &[0.1, 0.25]).expect("a joint that is controlled")))
        .collect();
    for (seed, tried) in &all {
        println!("{seed}: {tried:?}");
    }
    for (seed, tried) in &all {
        assert!(tried.rmse_percent.iter().all(|percent| *percent <= 0.3), "{seed}: {tried:?}");
        assert!(tried.cross_talk_percent <= 0.5, "{seed}: {tried:?}");
        assert!(tried.stiffness_percent <= STIFFNESS_PERCENT, "{seed}: {tried:?}");
        assert!(tried.slackest_n > 0.0, "{seed}: a tendon is slack: {tried:?}");
        let (lowest, highest) = tried.commands_bar;
        assert!(lowest >= 0.0 && highest <= 6.0, "{seed}: {tried:?}");
    }
}

/// The start of a joint by a model.
fn started(file: &JointFile, seed: u64, wrong: Wrong) -> Result<(), PilError> {
    let parameters = parameters(&file.parameters, 1e-3).expect("a joint in single precision");
    let mut plant = Wired::new(seed, wrong);
    let (soft, _) = file.joint.stiffness_range(0.0);
    let mut board = HostJoint::new(Protection::STANDARD);
    let wanted = JointWanted { angle_deg: 0.0, stiffness: 1.2 * soft, torque_nm: 0.0 };
    Loop::new((&parameters, None), &mut board, &mut plant, Stop::default())?.start(&wanted)
}

#[test]
fn what_is_wired_wrongly_is_recognised_at_the_first_motion() {
    let file = identified(1).expect("identified");
    started(&file, 1, Wrong::Nothing).expect("the joint of the model");
    for wrong in [Wrong::Angle, Wrong::Channels, Wrong::Sensors, Wrong::Frozen] {
        let fault = match started(&file, 1, wrong) {
            Err(PilError::Joint { fault, .. }) => fault,
            other => panic!("{wrong:?}: {other:?}"),
        };
        let is_named = match wrong {
            Wrong::Angle | Wrong::Channels => matches!(fault, JointFault::WrongWay(_)),
            Wrong::Sensors => fault == JointFault::Crossed,
            _ => matches!(fault, JointFault::Still(_)),
        };
        assert!(is_named, "{wrong:?}: {fault}");
    }
}

/// The torque that feedback takes up where a torque is on a joint, of which so much is known. Unit:
/// N m, in the mean over two seconds at rest.
fn fed_back(torque_nm: f64, known_nm: f64) -> f64 {
    let file = identified(1).expect("identified");
    let parameters = parameters(&file.parameters, 1e-3).expect("a joint in single precision");
    let mut plant = Wired::new(1, Wrong::Nothing);
    plant.put_on(torque_nm);
    let mut board = HostJoint::new(Protection::STANDARD);
    let mut joint =
        Loop::new((&parameters, None), &mut board, &mut plant, Stop::default()).expect("configured");
    let wanted = JointWanted { angle_deg: 0.0, stiffness: 55.0, torque_nm: known_nm };
    joint.start(&wanted).expect("the joint of the model");
    joint.approach(&wanted).expect("it follows");
    let samples = joint.follow([wanted; 2000].into_iter(), |_, _| ()).expect("it follows");
    samples.iter().map(|sample| f64::from(sample.reply.feedback_nm)).sum::<f64>() / samples.len() as f64
}

#[test]
fn a_torque_that_is_known_is_fed_forward_and_one_that_is_not_is_left_to_feedback() {
    // Where friction has left the joint differs from start to start by some of it.
    let [unknown, known, large] =
        [(2.0, 0.0), (2.0, 2.0), (4.0, 4.0)].map(|(torque, known)| fed_back(torque, known));
    assert!((-3.0..-1.0).contains(&(unknown - known)), "{unknown} and {known} N m");
    assert!(known.abs() < 1.0 && large.abs() < 1.0, "{known} and {large} N m");
}

/// Why nothing is identified from a recording that was changed.
fn refused(change: impl FnOnce(&mut JointRecording)) -> String {
    let mut changed = recording(&csv(1).expect("recorded")).expect("a recording");
    change(&mut changed);
    identify_joint(&changed, SWING_RAD).expect_err("no joint").to_string()
}

fn negate(values: &mut [f64]) {
    values.iter_mut().for_each(|value| *value = -*value);
}

#[test]
fn a_recording_with_a_wrong_sign_or_swapped_channels_is_refused_with_the_reason() {
    let backwards = refused(|recording| negate(&mut recording.angle_rad));
    assert!(backwards.contains("the angle sensor counts backwards"), "{backwards}");
    let swapped = refused(|recording| {
        recording.pressures_bar.swap(0, 1);
        recording.commands_bar.swap(0, 1);
    });
    assert!(swapped.contains("the channels are swapped"), "{swapped}");
    let torque = refused(|recording| negate(&mut recording.torque_nm));
    assert!(torque.contains("the torque has the other sign"), "{torque}");
    let crossed = refused(|recording| recording.commands_bar.swap(0, 1));
    assert!(crossed.contains("does not go towards its command"), "{crossed}");
}

#[test]
fn a_recording_that_does_not_tell_enough_is_refused_with_what_is_missing() {
    let unloaded = refused(|recording| recording.torque_nm.fill(0.0));
    assert!(unloaded.contains("hang a weight"), "{unloaded}");
    let still = refused(|recording| recording.angle_rad.fill(0.1));
    assert!(still.contains("angle_deg moves by 0.000 degrees only"), "{still}");
    let short = refused(|recording| recording.scored[100..].fill(false));
    assert!(short.contains("rows count, at least"), "{short}");
}

#[test]
fn each_of_several_recordings_is_filled_and_simulated_from_where_it_counts_on() {
    let one = recording(&csv(1).expect("recorded")).expect("a recording");
    let counts_from = one.scored.iter().position(|scored| *scored).expect("rows that count");
    let rows = one.time_s.len();
    let both = one.clone().followed_by(one);
    let found = identify_joint(&both, SWING_RAD).expect("a joint");
    let is_measured = |row: usize| found.simulated_rad[row] == both.angle_rad[row];
    assert!((rows..rows + counts_from).all(is_measured), "it is where it was measured while it is filled");
    let simulated = (rows + counts_from + 1..2 * rows).filter(|row| !is_measured(*row)).count();
    assert!(simulated > (rows - counts_from) * 9 / 10, "{simulated} rows");
}

#[test]
fn a_short_recording_is_held_out_in_blocks_too() {
    let mut short = recording(&csv(1).expect("recorded")).expect("a recording");
    // As if all had gone faster, in less than the five blocks of a long recording.
    let faster = 30.0 / short.time_s[short.time_s.len() - 1];
    short.time_s.iter_mut().for_each(|time_s| *time_s *= faster);
    let found = identify_joint(&short, SWING_RAD).expect("a joint");
    assert!(found.file.identification.heldout_rmse_deg < 5.0, "{:?}", found.file.identification);
}

#[test]
fn a_model_file_reads_back_as_the_same_joint_and_a_changed_one_is_refused() {
    let file = identified(2).expect("identified");
    let directory = tempfile::tempdir().expect("a directory");
    let path = directory.path().join("joint.toml");
    let text = file.to_toml();
    std::fs::write(&path, &text).expect("written");
    assert_eq!(JointFile::read(&path).expect("readable").to_toml(), text);
    for (from, to, message) in [
        ("format = 2", "format = 1", "format 1 is of another version"),
        ("kind = \"joint\"", "kind = \"mgpi\"", "kind: \"mgpi\" is no joint"),
        ("knee_bar2", "knee", "knee_bar2: missing"),
        ("valve_lag_s = 0", "valve_lag_s = -0", "valve_lag"),
    ] {
        std::fs::write(&path, text.replacen(from, to, 1)).expect("written");
        let refused = JointFile::read(&path).expect_err(to).to_string();
        assert!(refused.contains(message) && refused.contains("joint.toml"), "{refused}");
    }
}
