//! `mgpi status --joint`, `mgpi backup --joint` and `mgpi restore --joint` at a serial port behind
//! which the firmware of two channels drives a joint of the rig: the way round, and what goes
//! wrong.

use std::path::Path;
use std::process::{Child, Stdio};
use std::sync::LazyLock;
use std::thread::sleep;
use std::time::{Duration, Instant};

use board_client::backup::joint::{JointBackup, JointBackupFile, JointOrigin};
use fleet::line::Way;
use host_tests::desk_commands::DeskBench;
use host_tests::joint::identified;
use host_tests::joint_desk::{JointDesk, Setting};
use host_tests::store::{joint_calibration, joint_set};
use model_core::joint::PullParameters;
use model_core::pid::PidParameters;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use serde_json::Value;
use wire::joint::{JOINT_VERSION, JointResponse, JointSettings};
use wire::{FRAME_BYTES, Receiver, Scaling};

/// The joint of the desks, and another one.
const SEED: u64 = 1;
const OTHER: u64 = 101;
/// On a busy machine an answer may take its time: what is asked twice is slow.
const PATIENT: &str = "--timeout-s 10";
const SETTINGS: &str = "[limits]\nsupply_min_bar = 3.5\noverpressure_soft_bar = 6.1\n[calibration]\n\
                        pressure_a_zero_code = 411\npressure_a_codes_per_bar = 325.9\n\
                        angle_zero_code = 2050\nangle_codes_per_degree = 20.42\n";
const REFERENCE: &str = "time_s,reference_deg,stiffness_nm_per_rad\n0,-8,55\n2,6,55\n9,6,60\n";

/// A desk with the models of two joints and settings.
fn prepared(desk: JointDesk) -> JointDesk {
    // Identified once for all tests.
    static MODELS: LazyLock<[String; 2]> =
        LazyLock::new(|| [SEED, OTHER].map(|seed| identified(seed).expect("a joint").to_toml()));
    for (name, model) in ["joint.toml", "other.toml"].into_iter().zip(&*MODELS) {
        desk.write(name, model);
    }
    desk.write("settings.toml", SETTINGS);
    desk.write("reference.csv", REFERENCE);
    desk
}

fn desk(setting: Setting) -> JointDesk {
    prepared(JointDesk::new(setting))
}

fn sound() -> JointDesk {
    desk(Setting::sound(SEED))
}

fn deployed(desk: JointDesk) -> JointDesk {
    desk.succeeds(&format!("deploy joint.toml --joint --settings settings.toml {PATIENT}"));
    desk
}

/// The backup of a board, under a name.
fn kept(desk: &JointDesk, name: &str) -> String {
    desk.succeeds(&format!("backup --joint -o {name} {PATIENT}"));
    desk.read(name)
}

fn status(desk: &JointDesk, options: &str) -> Value {
    let said = desk.succeeds(&format!("status --joint --json {options} {PATIENT}"));
    serde_json::from_str(&said).expect("JSON")
}

fn was_never_driven(desk: &JointDesk) -> bool {
    desk.seen().highest_code == 0
}

/// All lines but those of the board that it is of.
fn without_board(backup: &str) -> String {
    let body = &backup[backup.find("\nkind").expect("a kind")..];
    let (board, next) = (body.find("\n[board]"), body.find("\n[protection]"));
    let (board, next) = (board.expect("a board"), next.expect("a protection"));
    format!("{}{}", &body[..board], &body[next..])
}

#[test]
fn what_a_board_has_been_told_comes_back_to_it_and_to_another_one_bit_by_bit() {
    let from = deployed(sound());
    let kept_first = kept(&from, "board.toml");
    for words in [
        "format = 1\n",
        "kind = \"joint_board\"\n",
        "messages = 7\n",
        "supply_min_bar = 3.5\n",
        "overpressure_soft_bar = 6.1\n",
        "pressure_a_zero_code = 411.0\npressure_a_codes_per_bar = 325.9\n",
        "[controller]\n",
        "kp = 0.1\n",
        "[model.muscle_b]\n",
        "[model.stops]\n",
    ] {
        assert!(kept_first.contains(words), "{words} is missing in\n{kept_first}");
    }
    // So that any program can check the rest, as that of a board with one muscle.
    assert!(kept_first.lines().nth(3).is_some_and(|line| line.starts_with("sha256 = ")), "{kept_first}");
    assert!(!kept_first.contains("pressure_b_zero_code = 411"), "b has the standard line");

    // The board of another joint, with other limits.
    let to = sound();
    to.succeeds(&format!("deploy other.toml --joint {PATIENT}"));
    to.write("board.toml", &kept_first);
    let before = kept(&to, "before.toml");
    let dry = to.succeeds(&format!("restore --joint board.toml --dry-run {PATIENT}"));
    for words in [
        "board.toml is of a board with other versions or sensors: ",
        "of board.toml differs (board -> file)",
        "protection.supply_min_bar            4.0 -> 3.5",
        "calibration.pressure_a_zero_code     none -> 411.0",
        "model.muscle_a.knee_bar2",
        "nothing has been changed (--dry-run)",
    ] {
        assert!(dry.contains(words), "{words} is missing in\n{dry}");
    }
    assert_eq!(kept(&to, "same.toml"), before, "a dry run changes nothing");
    let said = to.succeeds(&format!("restore --joint board.toml {PATIENT}"));
    assert!(said.contains("board.toml is restored, read back, verified, and kept without power"), "{said}");
    assert_eq!(kept(&to, "after.toml"), kept_first, "bit for bit, and the same scalings");
    let said = to.succeeds(&format!("restore --joint board.toml {PATIENT}"));
    assert!(said.contains("the board has all of board.toml already"), "{said}");
    assert!(
        to.succeeds(&format!("deploy joint.toml --joint --dry-run {PATIENT}"))
            .contains("has this joint already")
    );
    assert!(was_never_driven(&to) && was_never_driven(&from));

    // Its own sensors stay those of a board that has others.
    let to = sound();
    to.write("board.toml", &kept_first);
    to.succeeds(&format!("restore --joint board.toml --keep-calibration {PATIENT}"));
    let told = status(&to, "");
    assert_eq!(
        (&told["calibration"]["pressure_a"], &told["calibration"]["angle"]),
        (&Value::Null, &Value::Null)
    );
    assert!((told["limits"]["supply_min_bar"].as_f64().expect("a limit") - 3.5).abs() < 1e-9);
}

/// Joints whose numbers end in any bits, as a file and back.
#[test]
fn a_file_has_every_bit_of_every_number() {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    for round in 0..500_u16 {
        let mut any = |number: &mut f32| {
            *number = f32::from_bits(number.to_bits() ^ (random.next_u32() & 0xFFF));
        };
        let mut control = joint_set().control.expect("a joint");
        let joint = &mut control.joint;
        // Whether a degree has coarser steps than its radian depends on the angle.
        let share = 0.4 + 0.001 * f32::from(round);
        joint.angles = (share * joint.angles.0, share * joint.angles.1);
        for muscle in &mut joint.muscles {
            let PullParameters { arm, knee, friction, slip, lowest, highest, valve_lag_s } = muscle;
            arm.iter_mut().chain([knee, valve_lag_s]).for_each(&mut any);
            friction.iter_mut().chain(slip).chain(lowest).chain(highest).for_each(&mut any);
        }
        joint.passive.iter_mut().chain([&mut joint.viscosity, &mut joint.swing]).for_each(&mut any);
        joint.reaches.iter_mut().chain([&mut joint.angles.0, &mut joint.angles.1]).for_each(&mut any);
        let PidParameters { kp, ki, kd, derivative_filter_s, tracking_time_s } = &mut control.pid;
        [kp, ki, kd, derivative_filter_s, tracking_time_s].into_iter().for_each(&mut any);
        [&mut control.turn_rad_per_s, &mut control.stiffen_per_s, &mut control.slew_bar_per_s]
            .into_iter()
            .for_each(&mut any);
        let mut calibration = joint_calibration();
        for line in calibration.pressures.iter_mut().chain([&mut calibration.angle]).flatten() {
            [&mut line.zero_code, &mut line.codes_per_unit].into_iter().for_each(&mut any);
        }
        let mut protection = joint_set().protection;
        [&mut protection.supply_min_bar, &mut protection.authority_bar].into_iter().for_each(&mut any);
        let scaling = Scaling { zero_code: 409.5, codes_per_unit: 327.6, code_min: 0, code_max: u16::MAX };
        let file = JointBackupFile {
            origin: JointOrigin { firmware: [0, 1, 0], messages: JOINT_VERSION, scalings: [scaling; 4] },
            backup: JointBackup {
                control: Some(control),
                settings: JointSettings { protection, calibration },
            },
        };
        let again =
            JointBackupFile::parse(Path::new("board.toml"), &file.to_toml(), false).expect("it is read");
        assert!(again.backup.is(&file.backup), "{:?}", again.backup.differences(&file.backup));
        assert_eq!(again, file);
    }
}

#[test]
fn what_was_restored_is_there_when_the_board_has_started_again() {
    let kept_first = kept(&deployed(sound()), "board.toml");
    let to = desk(Setting { restarts_at: &[18], ..Setting::sound(SEED) });
    to.write("board.toml", &kept_first);
    to.succeeds(&format!("restore --joint board.toml {PATIENT}"));
    assert!(to.seen().requests < 18, "{} requests", to.seen().requests);
    while to.seen().requests < 18 {
        to.succeeds(&format!("status --joint {PATIENT}"));
    }
    assert_eq!(kept(&to, "after.toml"), kept_first);
}

#[test]
fn a_board_without_a_joint_is_kept_and_restored_but_takes_no_joint_away() {
    let from = sound();
    let none = kept(&from, "none.toml");
    assert!(!none.contains("[controller]") && !none.contains("[model"), "{none}");
    let told = status(&from, "");
    assert_eq!((&told["state"], &told["joint"]), (&Value::from("Off"), &Value::Null));
    let to = deployed(sound());
    to.write("none.toml", &none);
    let before = kept(&to, "before.toml");
    let said = to.refuses(&format!("restore --joint none.toml {PATIENT}"));
    assert!(said.contains("the backup is of a board without a joint"), "{said}");
    assert_eq!(kept(&to, "after.toml"), before);
    // Limits and lines alone.
    let settled = none.replacen("supply_min_bar = 4.0", "supply_min_bar = 3.25", 1);
    from.write("settled.toml", &settled);
    from.succeeds(&format!("restore --joint settled.toml --force {PATIENT}"));
    assert!(kept(&from, "settled-now.toml").contains("supply_min_bar = 3.25\n"));
}

#[test]
fn a_board_that_refuses_a_backup_has_what_it_had() {
    let kept_first = kept(&deployed(sound()), "board.toml");
    let to = desk(Setting { takes_one: true, ..Setting::sound(SEED) });
    to.succeeds(&format!("deploy other.toml --joint {PATIENT}"));
    to.write("board.toml", &kept_first);
    let before = kept(&to, "before.toml");
    // Limits and lines were given first, and are given back.
    let said = to.refuses(&format!("restore --joint board.toml {PATIENT}"));
    assert!(said.contains("the board refuses: no room for another joint"), "{said}");
    assert_eq!(kept(&to, "after.toml"), before);
    // A line that no working sensor has is refused before anything is taken.
    let wild =
        kept_first.replacen("pressure_a_codes_per_bar = 325.9\n", "pressure_a_codes_per_bar = 500.0\n", 2);
    to.write("wild.toml", &wild);
    let said = to.refuses(&format!("restore --joint wild.toml --force {PATIENT}"));
    assert!(said.contains("pressure a: 1.526251"), "{said}");
    assert_eq!(kept(&to, "again.toml"), before);
}

#[test]
fn a_board_that_has_another_joint_behind_it_or_keeps_none_is_said() {
    let kept_first = kept(&deployed(sound()), "board.toml");
    let worn = Setting { is_worn: true, ..Setting::sound(SEED) };
    let to = desk(worn);
    to.write("board.toml", &kept_first);
    let said = to.refuses(&format!("restore --joint board.toml {PATIENT}"));
    assert!(said.contains("its flash has not kept it: it is lost when power is"), "{said}");
    assert!(!said.contains("may already be"), "{said}");
    assert_eq!(kept(&to, "after.toml"), kept_first, "it is in use");
    // Started again between the joint and the question which one it has: hello, fingerprint,
    // settings, hello; settings, hello, joint, fingerprint.
    let restarted = desk(Setting { restarts_at: &[6], ..worn });
    let said = restarted.refuses(&format!("deploy joint.toml --joint {PATIENT}"));
    assert!(
        said.contains(
            "the board has another joint than the one that was sent: is another program at its link?"
        ),
        "{said}"
    );
    assert!(was_never_driven(&restarted));
}

/// From the second time on the board tells a joint, or settings, with one bit that is another one.
#[test]
fn what_is_read_back_behind_a_restoration_is_compared_bit_by_bit() {
    let kept_first = kept(&deployed(sound()), "board.toml");
    for is_joint in [true, false] {
        let (mut receiver, mut told) = (Receiver::new(), 0);
        let liar = prepared(JointDesk::disturbed(Setting::sound(SEED), move |way, bytes| {
            let mut response = match bytes.iter().find_map(|byte| match way {
                Way::FromBoard => receiver.push::<JointResponse>(*byte),
                Way::ToBoard => None,
            }) {
                Some(Ok(response)) => response,
                _ => return bytes,
            };
            match &mut response {
                JointResponse::Control(Some(control)) if is_joint => {
                    let friction = &mut control.joint.muscles[1].friction[2];
                    *friction = f32::from_bits(friction.to_bits() ^ 1);
                }
                // Before, of the deployment, and behind it.
                JointResponse::Settings(settings) if !is_joint => {
                    told += 1;
                    if told > 2 {
                        settings.protection.slew_bar_per_s += 0.5;
                    }
                }
                _ => return bytes,
            }
            let mut buffer = [0; FRAME_BYTES];
            wire::encode(&response, &mut buffer).expect("a frame").to_vec()
        }));
        liar.write("board.toml", &kept_first);
        let said = liar.refuses(&format!("restore --joint board.toml {PATIENT}"));
        let wrong =
            if is_joint { "joint than the one that was sent" } else { "limits and lines of its sensors" };
        assert!(said.contains(wrong), "{said}");
    }
}

#[test]
fn a_joint_that_is_driven_is_read_back_shown_and_stopped_but_not_restored() {
    let desk = deployed(sound());
    let before = kept(&desk, "board.toml");
    let mut child = driving(&desk, "track --joint --model other.toml --reference reference.csv");
    signal_kill(&mut child);
    let told = status(&desk, "");
    assert!(["Starting", "Tracking"].contains(&told["state"].as_str().expect("a state")), "{told}");
    assert!(told["command_a_bar"].as_f64().expect("a command") > 0.5, "{told}");
    assert_eq!(told["fault"], Value::Null);
    let driven = kept(&desk, "driven.toml");
    assert_ne!(without_board(&driven), without_board(&before), "track has given it another joint");
    let asked = desk.seen().requests;
    let said = desk.refuses(&format!("restore --joint board.toml {PATIENT}"));
    assert!(said.contains("the board is in the state") && said.contains("it is driven"), "{said}");
    assert_eq!(desk.seen().requests, asked + 1, "it is refused before anything is sent");
    assert_eq!(kept(&desk, "still.toml"), driven);
    assert!(desk.seen().last.is_some_and(|last| last.state.is_driven()), "it was not disturbed");
    let told = status(&desk, "--stop");
    assert_eq!((&told["state"], &told["command_a_bar"]), (&Value::from("Ready"), &Value::from(0.0)));
    desk.succeeds(&format!("restore --joint board.toml {PATIENT}"));
    assert_eq!(without_board(&kept(&desk, "restored.toml")), without_board(&before));
}

#[test]
fn a_fault_is_shown_with_cause_and_cure_noted_in_a_backup_and_released_when_it_is_acknowledged() {
    let setting = Setting { stored: include_bytes!("golden/store_layout_6.bin"), ..Setting::sound(SEED) };
    let desk = desk(setting);
    let said = desk.succeeds(&format!("status --joint {PATIENT}"));
    for words in [
        "state       Fault",
        "fault       fault 23",
        "  cause     ",
        "  cure      acknowledge, then `mgpi deploy --joint`",
    ] {
        assert!(said.contains(words), "{words} is missing in\n{said}");
    }
    assert_eq!(status(&desk, "")["fault"]["number"], 23);
    let done = desk.run(&format!("backup --joint -o board.toml {PATIENT}"));
    let noted = String::from_utf8_lossy(&done.stderr).into_owned();
    assert!(done.status.success() && noted.contains("note: the board is at fault 23"), "{noted}");
    let said = desk.refuses(&format!("restore --joint board.toml {PATIENT}"));
    assert!(
        said.contains("at fault since before: fault 23") && said.contains("then: --acknowledge"),
        "{said}"
    );
    desk.succeeds(&format!("restore --joint board.toml --acknowledge {PATIENT}"));
    let told = status(&desk, "--acknowledge");
    assert_eq!((&told["state"], &told["fault"]), (&Value::from("Off"), &Value::Null));
    assert!(was_never_driven(&desk));
}

#[test]
fn a_status_has_what_the_board_measures_and_what_it_has_been_told() {
    let desk = deployed(sound());
    let said = desk.succeeds(&format!("status --joint {PATIENT}"));
    for words in [
        "state       Ready",
        "board       of a joint, firmware 0.1.0, messages 7",
        " degrees, ",
        " N m/rad in the middle, 8 stops, checksum ",
        "gains       kp 0.1, ki ",
        "limits      overpressure_soft_bar 6.1 (standard 6.6), supply_min_bar 3.5 (standard 4)",
        "sensors     pressure a 411 + 325.9 a bar, pressure b standard, angle 2050 + ",
        "fault       none",
        "measured    pressure a ",
        "commands    a 0.00 bar, b 0.00 bar",
        "counted     ticks ",
    ] {
        assert!(said.contains(words), "{words} is missing in\n{said}");
    }
    let told = status(&desk, "");
    let number = |name: &str| told[name].as_f64().expect(name);
    assert_eq!((&told["kind"], &told["versions"]["messages"]), (&Value::from("joint"), &Value::from(7)));
    assert!(number("pressure_a_bar").abs() < 0.1 && number("angle_deg").abs() < 90.0, "{told}");
    assert!(number("supply_bar") > 4.0 && (0.0..85.0).contains(&number("temperature_c")), "{told}");
    assert!(number("ticks") > 0.0 && number("late_ticks") == 0.0, "{told}");
    let joint = |name: &str| told["joint"][name].as_f64().expect(name);
    assert!(joint("angle_min_deg") < 0.0 && joint("angle_max_deg") > 0.0);
    assert!(
        0.0 < joint("stiffness_min_nm_per_rad")
            && joint("stiffness_min_nm_per_rad") < joint("stiffness_max_nm_per_rad")
    );
    assert!(
        (told["calibration"]["pressure_a"]["codes_per_bar"].as_f64().expect("a gain") - 325.9).abs() < 1e-9
    );
}

#[test]
fn the_backup_of_another_kind_and_the_board_of_another_kind_are_refused_by_name() {
    let joint = deployed(sound());
    let of_joint = kept(&joint, "board.toml");
    let single = DeskBench::new();
    single.succeeds("deploy paper.toml");
    single.succeeds("backup -o muscle.toml");
    single.write("board.toml", &of_joint);
    single.write("joint.toml", &joint.read("joint.toml"));
    joint.write("muscle.toml", &single.read("muscle.toml"));
    joint.write("paper.toml", &single.read("paper.toml"));
    let (wants_one, wants_joint) = (
        "`mgpi restore` takes the backup of a board with one muscle",
        "`mgpi restore --joint` takes the backup of a joint's board",
    );
    let asked = joint.seen().requests;
    for (said, file, found, wanted, other) in [
        (
            single.refuses("restore board.toml"),
            "board.toml",
            "the backup of a joint's board",
            wants_one,
            "mgpi restore --joint",
        ),
        (
            single.refuses("restore board.toml --force"),
            "board.toml",
            "the backup of a joint's board",
            wants_one,
            "mgpi restore --joint",
        ),
        (
            single.refuses("restore paper.toml"),
            "paper.toml",
            "a model of one muscle",
            wants_one,
            "mgpi deploy",
        ),
        (
            single.refuses("restore joint.toml"),
            "joint.toml",
            "the model of a joint",
            wants_one,
            "mgpi deploy --joint",
        ),
        (
            joint.refuses("restore --joint muscle.toml"),
            "muscle.toml",
            "the backup of a board with one muscle",
            wants_joint,
            "mgpi restore",
        ),
        (
            joint.refuses("restore --joint muscle.toml --force"),
            "muscle.toml",
            "the backup of a board with one muscle",
            wants_joint,
            "mgpi restore",
        ),
        (
            joint.refuses("restore --joint joint.toml"),
            "joint.toml",
            "the model of a joint",
            wants_joint,
            "mgpi deploy --joint",
        ),
        (
            joint.refuses("restore --joint paper.toml"),
            "paper.toml",
            "a model of one muscle",
            wants_joint,
            "mgpi deploy",
        ),
    ] {
        let message = format!("error: {file}: it is {found}; {wanted}. `{other}` takes this one");
        assert!(said.contains(&message), "{message}\nis not in\n{said}");
    }
    assert_eq!(joint.seen().requests, asked, "no board was asked");
    let said = joint.refuses(&format!("deploy board.toml --joint {PATIENT}"));
    assert!(said.contains("board.toml: kind: \"joint_board\" is no joint"), "{said}");

    // A board with one muscle at the link.
    let other = desk(Setting { is_single: true, ..Setting::sound(SEED) });
    other.write("board.toml", &of_joint);
    let before = other.files();
    for command in ["status --joint", "backup --joint -o new.toml", "restore --joint board.toml"] {
        let said = other.refuses(command);
        assert!(said.contains("a board with one muscle answers"), "{command}: {said}");
    }
    assert_eq!(other.files(), before);
}

#[test]
fn a_file_that_is_damaged_or_changed_is_refused_with_its_line_before_the_board_is_asked() {
    let desk = deployed(sound());
    let kept = kept(&desk, "board.toml");
    let asked = desk.seen().requests;
    let line = |of: &str| 1 + kept.lines().position(|line| line.starts_with(of)).expect(of);
    let changed = |from: &str, to: &str, force: &str| {
        assert!(kept.contains(from), "{from}");
        desk.write("bad.toml", &kept.replacen(from, to, 1));
        desk.refuses(&format!("restore --joint bad.toml {force}"))
    };
    for (from, to, force, of, what) in [
        ("kp = 0.1\n", "kp = 0.2\n", "", "sha256", "sha256: the lines below have another one"),
        ("kind = \"joint_board\"", "kind = \"joint_bored\"", "", "sha256", "sha256: the lines"),
        (
            "kind = \"joint_board\"",
            "kind = \"joint_bored\"",
            "--force",
            "kind",
            "kind: \"joint_bored\" is not known",
        ),
        (
            "format = 1\n",
            "format = 2\n",
            "",
            "format",
            "format: 2 is of another version; this program reads format 1",
        ),
        ("kp = 0.1\n", "", "--force", "[controller]", "[controller] kp: missing"),
        ("kp = 0.1\n", "kp = 0.1\nkq = 1\n", "--force", "kp", "[controller] kq: unknown key"),
        ("kp = 0.1\n", "kp = nan\n", "--force", "kp", "[controller] kp: NaN is not finite"),
        (
            "messages = 7\n",
            "messages = 6\n",
            "--force",
            "messages",
            "[board] messages: 6 is of another version; this program reads version 7",
        ),
        (
            "messages = 7\n",
            "messages = 8\n",
            "--force",
            "messages",
            "[board] messages: 8 is of another version",
        ),
        (
            "firmware = \"0.1.0\"",
            "firmware = \"new\"",
            "--force",
            "firmware",
            "[board] firmware: \"new\" is no version",
        ),
        (
            "[calibration]\npressure_a_zero_code = 411.0\npressure_a_codes_per_bar = 325.9\n",
            "[calibration]\npressure_a_zero_code = 411.0\n",
            "--force",
            "[calibration]",
            "[calibration] pressure_a_codes_per_bar: missing",
        ),
    ] {
        let said = changed(from, to, force);
        let line = line(of) + usize::from(to.contains("kq"));
        let start = format!("error: bad.toml, line {line}: {what}");
        assert!(said.starts_with(&start), "{said} does not start with {start}");
    }
    let said = changed("period_s = 0.001", "period_s = 0.0", "--force");
    assert!(said.contains("bad.toml: no configuration that a board takes: period"), "{said}");
    let said = changed("slew_bar_per_s = ", "slew_bar_per_s = -", "--force");
    assert!(said.contains("bad.toml: no configuration that a board takes: "), "{said}");
    for share in 1..20 {
        desk.write("bad.toml", &kept[..kept.len() * share / 20]);
        let said = desk.refuses("restore --joint bad.toml");
        assert!(said.contains("bad.toml"), "{said}");
    }
    assert!(desk.refuses("restore --joint none.toml").contains("none.toml: cannot be read"));
    assert_eq!(desk.seen().requests, asked, "the board was not asked");
    // What was changed by hand is taken by force.
    desk.write("bad.toml", &kept.replacen("kp = 0.1\n", "kp = 0.15\n", 1));
    desk.succeeds(&format!("restore --joint bad.toml --force {PATIENT}"));
    let gains = status(&desk, "")["joint"]["kp"].as_f64().expect("a gain");
    assert!((gains - 0.15).abs() < 1e-9);
}

#[test]
fn what_exists_is_not_overwritten_and_what_does_not_belong_together_is_refused() {
    let desk = deployed(sound());
    desk.write("board.toml", "mine");
    let (asked, files) = (desk.seen().requests, desk.files());
    let said = desk.refuses("backup --joint -o board.toml");
    assert!(said.contains("board.toml: exists already; --force overwrites it"), "{said}");
    for arguments in [
        "backup --joint -o new.toml --unit 3",
        "restore --joint board.toml --keep-bus",
        "restore --joint board.toml --parity even",
        "status --joint --unit 3",
    ] {
        let said = desk.refuses(arguments);
        assert!(said.contains("cannot be used with"), "{arguments}: {said}");
    }
    assert!(desk.refuses("restore board.toml --acknowledge").contains("--joint"));
    assert_eq!((desk.seen().requests, desk.files()), (asked, files), "no board was asked");
    assert_eq!(desk.read("board.toml"), "mine");
    desk.succeeds(&format!("backup --joint -o board.toml --force {PATIENT}"));
    assert!(desk.read("board.toml").contains("joint_board"));
}

/// One exchange in some four is damaged, in either direction, or its answer lost; the answer that
/// is longest is damaged in its middle, too.
#[test]
fn a_link_that_loses_and_damages_costs_time_and_no_bit() {
    let (mut answers, mut requests) = (0, 0);
    let desk = prepared(JointDesk::disturbed(Setting::sound(SEED), move |way, mut bytes| {
        match way {
            Way::FromBoard => {
                answers += 1;
                if answers % 13 == 0 {
                    bytes.clear();
                } else if answers % 5 == 0 {
                    let middle = bytes.len() / 2;
                    bytes[middle] ^= 0x10;
                }
            }
            Way::ToBoard if bytes.len() > 4 => {
                requests += 1;
                if requests % 7 == 0 {
                    bytes[2] ^= 0x04;
                }
            }
            Way::ToBoard => {}
        }
        bytes
    }));
    let limit = "--timeout-s 0.5";
    desk.succeeds(&format!("deploy joint.toml --joint --settings settings.toml {limit}"));
    let sound = deployed(sound());
    let wanted = kept(&sound, "board.toml");
    for round in 0..4 {
        desk.succeeds(&format!("backup --joint -o {round}.toml {limit}"));
        assert_eq!(desk.read(&format!("{round}.toml")), wanted, "round {round}");
        desk.succeeds(&format!("status --joint {limit}"));
    }
    desk.succeeds(&format!("deploy other.toml --joint {limit}"));
    desk.write("board.toml", &wanted);
    desk.succeeds(&format!("restore --joint board.toml {limit}"));
    desk.succeeds(&format!("backup --joint -o after.toml {limit}"));
    assert_eq!(desk.read("after.toml"), wanted);
}

#[test]
fn a_board_that_is_gone_while_it_is_asked_leaves_no_file_and_is_said() {
    // From the answer with the joint on: that of the second request.
    let mut answers = 0;
    let silent = prepared(JointDesk::disturbed(Setting::sound(SEED), move |way, bytes| {
        answers += usize::from(way == Way::FromBoard);
        if way == Way::FromBoard && answers > 1 { Vec::new() } else { bytes }
    }));
    let files = silent.files();
    let said = silent.refuses("backup --joint -o board.toml");
    assert!(said.contains("no answer within 0.12 s, asked 3 times"), "{said}");
    assert_eq!(silent.files(), files);
    // Behind the settings, before the joint: the user is told that it may have half of it.
    let kept_first = kept(&deployed(sound()), "board.toml");
    let mut frames = 0;
    let silent = prepared(JointDesk::disturbed(Setting::sound(SEED), move |way, bytes| {
        frames += usize::from(way == Way::FromBoard);
        // Hello; joint, settings, hello; settings, hello.
        if way == Way::FromBoard && frames > 6 { Vec::new() } else { bytes }
    }));
    silent.write("board.toml", &kept_first);
    let said = silent.refuses("restore --joint board.toml");
    assert!(
        said.contains("no answer within")
            && said.contains("may already be those of the backup: restore it again"),
        "{said}"
    );
    for (version, message) in
        [(6, "speaks version 6 of a joint's messages, this program version 7"), (8, "use a newer mgpi")]
    {
        let desk = desk(Setting { version: Some(version), ..Setting::sound(SEED) });
        desk.write("board.toml", &kept_first);
        for command in ["status --joint", "backup --joint -o new.toml", "restore --joint board.toml"] {
            let said = desk.refuses(&format!("{command} {PATIENT}"));
            assert!(said.contains(message), "{command}: {said}");
        }
    }
}

/// A program that drives a joint, as soon as a valve is open.
fn driving(desk: &JointDesk, arguments: &str) -> Child {
    let mut command = desk.command(&format!("{arguments} {PATIENT}"));
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("mgpi runs");
    let deadline = Instant::now() + Duration::from_secs(60);
    while !desk.seen().last.is_some_and(|last| last.dac_codes.iter().all(|code| *code > 300)) {
        assert!(Instant::now() < deadline, "it never comes");
        sleep(Duration::from_millis(5));
    }
    child
}

/// Ends a program as a machine that loses its power does.
fn signal_kill(child: &mut Child) {
    child.kill().expect("it runs");
    child.wait().expect("it ends");
}
