//! `mgpi capture --joint` and `mgpi track --joint` at a serial port behind which the firmware of
//! two channels drives a joint of the rig: the whole way from a recording to a run, and what goes
//! wrong.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use fleet::line::Way;
use host_tests::commands::mgpi;
use host_tests::joint::{Wrong, identified};
use host_tests::joint_desk::{JointDesk, Setting, Time};
use recording::Choice;
use recording::joint::columns::JointRecording;
use rig::joint::protocol::{JointProtocol, JointRange};
use serde_json::Value;
use wire::Protection;
use wire::joint::JointBoardState;

/// The joint of most tests.
const SEED: u64 = 1;
/// Six seconds within the angles of every joint.
const REFERENCE: &str =
    "time_s,reference_deg,stiffness_nm_per_rad\n0,-8,55\n2,6,55\n3,6,60\n5,-8,60\n6,-4,55\n";
/// On a busy machine an answer may take its time: what is asked twice is slow.
const PATIENT: &str = "--timeout-s 10";
const TRACK: &str = "track --joint --model joint.toml --reference reference.csv";

/// A desk with the model of the joint of a seed, and a reference.
fn with_model(setting: Setting, model_of: u64) -> JointDesk {
    prepared(JointDesk::new(setting), model_of)
}

fn prepared(desk: JointDesk, model_of: u64) -> JointDesk {
    let model = identified(model_of).expect("a joint").to_toml();
    std::fs::write(desk.path("joint.toml"), model).expect("written");
    std::fs::write(desk.path("reference.csv"), REFERENCE).expect("written");
    desk
}

fn figures(file: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(file).expect("readable")).expect("JSON")
}

fn is_vented(desk: &JointDesk) -> bool {
    desk.seen().last.is_some_and(|last| last.dac_codes == [0; 2] && !last.state.is_driven())
}

/// Whether no valve has been opened.
fn was_never_driven(desk: &JointDesk) -> bool {
    desk.seen().highest_code == 0
}

/// Records a joint under a torque, on a desk of its own, since somebody hangs the weight there.
/// What a board that has started again interrupts is resumed.
fn recorded(load_nm: f64, name: &str, duration_s: Option<f64>, restarts_at: &'static [u32]) -> JointDesk {
    let desk = JointDesk::new(Setting { load_nm, restarts_at, ..Setting::sound(SEED) });
    let options = duration_s.map_or(String::new(), |duration_s| format!("--duration-s {duration_s}"));
    let command =
        format!("capture --joint --max-bar 6 --torque-newton-metre {load_nm} -o {name} {options} {PATIENT}");
    let resumes = |count: usize| if count > 0 { " --resume" } else { "" };
    for count in 0..restarts_at.len() {
        let said = desk.refuses(&format!("{command}{}", resumes(count)));
        assert!(said.contains("was it restarted") && said.contains("--resume continues it"), "{said}");
    }
    let said = desk.succeeds(&format!("{command}{}", resumes(restarts_at.len())));
    assert!(said.contains("one each 10 ms") && !said.contains("missed"), "{said}");
    assert!(is_vented(&desk));
    let range = JointRange { min_bar: 1.8, max_bar: 6.0, swing: 0.22 };
    let excitation = JointProtocol::without_weights(&range, duration_s).expect("room for a swing");
    let rows = rows(&desk.path(name));
    // What a row says was put out is what was asked for at the row before, until then.
    let text = desk.read(name);
    let mut seams = (text.lines())
        .filter_map(|line| line.strip_prefix("# interrupted, resumed at ")?.strip_suffix(" s"))
        .map(|seam_s| seam_s.parse::<f64>().expect("a time"));
    let mut ahead_s = 0.0;
    for pair in rows.windows(2) {
        if pair[1][0] - pair[0][0] > 0.5 {
            // Filled, swung and brought there again, and then as if there had been nothing.
            let seam_s = seams.next().expect("a comment at each gap");
            let lead_s = (1e3 * excitation.counts_from_s()).ceil() / 1e3 + 4.0;
            ahead_s += seam_s + lead_s - pair[0][0] - 0.001;
            continue;
        }
        if pair[0][7] == 0.0 {
            continue;
        }
        let asked = excitation.commands_bar(pair[0][0] - ahead_s + 1e-3);
        let is_held = asked.iter().zip(&pair[1][1..=2]).all(|(asked, held)| (asked - held).abs() < 0.002);
        assert!(is_held, "{asked:?} bar were asked for before {:?}", pair[1]);
    }
    assert_eq!(seams.next(), None);
    let end_s = rows[rows.len() - 1][0] - ahead_s;
    assert!((end_s - excitation.duration_s()).abs() < 0.02, "{end_s} s");
    desk
}

/// The rows of a recording.
fn rows(file: &Path) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(file).expect("a recording");
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    assert_eq!(lines.next(), Some(recording::joint::columns::COLUMNS));
    let numbers = |line: &str| line.split(',').map(|field| field.parse().expect("a number")).collect();
    lines.map(numbers).collect()
}

#[test]
fn a_joint_is_recorded_over_its_link_identified_and_tracked_with() {
    let desk = JointDesk::new(Setting::sound(SEED));
    // One of them is interrupted: after some 60 s, 10 s later while it is filled again, and 17 s
    // later.
    for (load_nm, name, duration_s, restarts_at) in [
        (0.0, "joint.csv", None, &[][..]),
        (4.0, "to-larger.csv", Some(120.0), &[15_000, 16_000, 20_000][..]),
        (-4.0, "to-smaller.csv", Some(120.0), &[]),
    ] {
        let from = recorded(load_nm, name, duration_s, restarts_at);
        assert_eq!(from.files(), [name], "the part goes");
        std::fs::copy(from.path(name), desk.path(name)).expect("copied");
    }
    // The torque of a recording is one of it, so one alone is not enough.
    let mgpi = |arguments: &str| {
        let mut command = Command::new(mgpi());
        command.args(arguments.split_whitespace()).current_dir(desk.path(""));
        command.output().expect("mgpi runs")
    };
    let alone = mgpi("identify --joint joint.csv -o joint.toml");
    let said = String::from_utf8_lossy(&alone.stderr).into_owned();
    assert!(alone.status.code() == Some(2) && said.contains("hang a weight"), "{said}");
    let all = mgpi("identify --joint joint.csv to-larger.csv to-smaller.csv -o joint.toml --json joint.json");
    assert!(all.status.success(), "{}", String::from_utf8_lossy(&all.stderr));
    let found = figures(&desk.path("joint.json"));
    println!("identified: {found:#}");
    let number = |value: &Value, name: &str| value[name].as_f64().expect(name);
    assert!(number(&found, "heldout_rmse_deg") < 0.01 * number(&found, "range_deg"));

    std::fs::write(desk.path("reference.csv"), REFERENCE).expect("written");
    let said = desk.succeeds(&format!("{TRACK} -o log.csv --json run.json --report run.html"));
    println!("{said}");
    assert!(said.contains("% of range") && said.contains("as many as the link carries"), "{said}");
    let run = figures(&desk.path("run.json"));
    println!("tracked: {run:#}");
    let share = number(&run, "rmse_deg") / number(&run, "range_deg");
    assert!((1e-4..0.002).contains(&share), "RMSE of {} % of range", 100.0 * share);
    // No target is a step, but that the reference has corners.
    assert!(number(&run, "ticks_angle_limited") < 20.0, "{run}");
    let log = std::fs::read_to_string(desk.path("log.csv")).expect("a log");
    let first = log.lines().next().expect("a header");
    assert_eq!(first, board_client::joint::log::COLUMNS.trim_end(), "as pil --joint has it");
    // A request takes four ticks, and six seconds are 1500 of them.
    assert!((1400..1600).contains(&log.lines().count()), "{}", log.lines().count());
    assert!(
        std::fs::read_to_string(desk.path("run.html")).expect("a page").contains("Torque of the feedback")
    );
    assert!(is_vented(&desk) && desk.seen().last.is_some_and(|last| last.fault.is_none()));
    // Another run is refused before anything moves.
    let before = desk.seen().requests;
    let said = desk.refuses(&format!("{TRACK} -o log.csv"));
    assert!(said.contains("log.csv: exists already"), "{said}");
    assert_eq!(desk.seen().requests, before, "the board was not even asked");
}

#[test]
fn a_recording_has_the_boards_time_the_pressures_that_were_held_and_what_was_missed() {
    // As slow as a link whose adapter keeps what it has for 16 ms.
    let desk = JointDesk::new(Setting { time: Time::Requests(17), ..Setting::sound(SEED) });
    let capture = format!("capture --joint --duration-s 40 -o joint.csv {PATIENT}");
    let said = desk.succeeds(&format!("{capture} --torque-newton-metre -2"));
    assert!(said.contains("link or machine was too slow: --every 20 is easier"), "{said}");
    let torque = std::fs::read_to_string(desk.path("joint.csv")).expect("a recording");
    assert!(torque.lines().last().is_some_and(|row| row.ends_with(",-2,1")), "its torque is in each row");
    let said = desk.succeeds(&format!("{capture} --every 20 --force"));
    assert!(!said.contains("missed"), "{said}");
    let rows = rows(&desk.path("joint.csv"));
    assert!(rows.windows(2).all(|pair| (0.010..0.040).contains(&(pair[1][0] - pair[0][0]))));
    assert!(rows.len() > 1900 && rows[rows.len() - 1][0] > 39.9, "{} rows", rows.len());
    let counted = rows.iter().position(|row| row[7] == 1.0).expect("rows that count");
    assert!(
        rows[..counted].iter().all(|row| row[7] == 0.0) && rows[counted..].iter().all(|row| row[7] == 1.0)
    );
    // Filled in 2 and swung in 9 of some 311 seconds, here of 40.
    assert!((1.3..1.6).contains(&rows[counted][0]), "counts from {} s", rows[counted][0]);
    for row in &rows[counted..] {
        assert!(row[1..=2].iter().all(|bar| (1.79..=6.01).contains(bar)), "{row:?}");
        assert!((row[3] - row[1]).abs() < 1.0 && (row[4] - row[2]).abs() < 1.0, "{row:?}");
    }
}

/// Filled in a second and swung in two, then a triangle.
const EXCITATION: &str = "time_s,command_a_bar,command_b_bar,valid\n10,0,0,0\n11,3,3,0\n12,3.5,2.5,0\n13,3,3,1\n\
                          15,2.5,3.5,1\n17,3.5,2.5,1\n19,3,3,1\n";

#[test]
fn the_pressures_of_a_file_are_played() {
    let desk = JointDesk::new(Setting::sound(SEED));
    desk.write("exc.csv", EXCITATION);
    let said = desk.succeeds(&format!("capture --joint --excitation exc.csv -o rec.csv {PATIENT}"));
    assert!(said.contains("one each 10 ms"), "{said}");
    assert!(desk.read("rec.csv").contains("# excitation: exc.csv, SHA-256 "));
    let rows = rows(&desk.path("rec.csv"));
    assert!((rows[rows.len() - 1][0] - 9.0).abs() < 0.011, "{:?}", rows[rows.len() - 1]);
    for (time_s, a, b) in [(2.0, 3.5, 2.5), (5.0, 2.5, 3.5), (6.0, 3.0, 3.0), (7.0, 3.5, 2.5)] {
        let row = rows.iter().find(|row| row[0] >= time_s + 0.005).expect("a row");
        assert!((row[1] - a).abs() < 0.02 && (row[2] - b).abs() < 0.02, "{row:?}");
    }
    assert!(rows.iter().all(|row| (row[7] == 1.0) == (row[0] >= 3.0)), "its column says which rows count");
    // A recording may be played again.
    desk.succeeds(&format!("capture --joint --excitation rec.csv -o again.csv {PATIENT}"));
}

#[test]
fn a_board_is_given_limits_and_what_its_sensors_have_shown() {
    let desk = with_model(Setting::sound(SEED), SEED);
    desk.write("exc.csv", EXCITATION);
    let write = |limits: &str, calibration: &str| {
        desk.write("board.toml", &format!("[limits]\n{limits}\n[calibration]\n{calibration}\n"));
    };
    let capture =
        format!("capture --joint --excitation exc.csv -o rec.csv --force --settings board.toml {PATIENT}");
    for (limits, calibration, words) in [
        (
            "overpressure_hard_bar = 9",
            "",
            "board.toml, line 2: [limits] overpressure_hard_bar: 9 is out of range, must be 0 to 8.5 bar",
        ),
        ("contraction_jump_mm = 10", "", "contraction_jump_mm"),
        ("", "pressure_a_zero_code = 410", "pressure_a_codes_per_bar: missing"),
        (
            "",
            "pressure_b_zero_code = 410\npressure_b_codes_per_bar = 500",
            "the board refuses: pressure b: 1.526251",
        ),
        ("overpressure_soft_bar = 3", "", "the board refuses: pressures of"),
    ] {
        write(limits, calibration);
        let said = desk.refuses(&capture);
        assert!(said.contains(words), "{said}");
        assert!(is_vented(&desk) || was_never_driven(&desk));
    }
    write("supply_min_bar = 3", "pressure_a_zero_code = 409.5\npressure_a_codes_per_bar = 340");
    desk.succeeds(&capture);
    let rows = rows(&desk.path("rec.csv"));
    let at_rest: Vec<&Vec<f64>> = rows.iter().filter(|row| row[0] > 8.9).collect();
    assert!(!at_rest.is_empty());
    for row in at_rest {
        let (a, b) = (row[3] * 340.0 / 327.6, row[4]);
        assert!((a - row[1]).abs() < 0.15 && (b - row[2]).abs() < 0.15 && row[3] < 0.98 * row[1], "{row:?}");
    }
    // They stay until others are given.
    write("", "angle_zero_code = 2047.5\nangle_codes_per_degree = 20.4728");
    desk.succeeds(&format!("{TRACK} --settings board.toml -o log.csv"));
    let said = desk.refuses("track --reference reference.csv --settings board.toml");
    assert!(said.contains("--joint"), "{said}");
}

const DEPLOY: &str = "deploy joint.toml --joint --settings board.toml --timeout-s 10";
const SETTINGS: &str = "[limits]\nsupply_min_bar = 3.5\n[calibration]\npressure_a_zero_code = 411\n\
                        pressure_a_codes_per_bar = 325.9\n";

#[test]
fn a_joint_and_its_settings_are_deployed_listed_and_there_when_the_board_has_started_again() {
    // The first request of the third command.
    let desk = with_model(Setting { restarts_at: &[13], ..Setting::sound(SEED) }, SEED);
    desk.write("board.toml", SETTINGS);
    let said = desk.succeeds(&format!("{DEPLOY} --dry-run"));
    let listed = [
        "joint.toml: two muscles at a joint, off by 0.",
        "the board has no joint yet",
        "supply_min_bar          4 -> 3.5",
        "pressure a              standard -> 411 + 325.9 a bar",
    ];
    assert!(listed.iter().all(|words| said.contains(words)), "{said}");
    assert!(said.contains("nothing has been changed (--dry-run)"), "{said}");
    let before = desk.seen().requests;
    let said = desk.succeeds(DEPLOY);
    assert!(said.contains("the board has no joint yet"), "the dry run has changed something: {said}");
    assert!(said.contains("joint.toml is installed, and kept without power"), "{said}");
    assert_eq!((before, desk.seen().requests), (4, 12), "no request was asked twice");
    let said = desk.succeeds("deploy joint.toml --joint --timeout-s 10");
    assert!(said.contains("the board has this joint already"), "{said}");
    let again = desk.succeeds(&format!("{DEPLOY} --dry-run"));
    assert!(again.contains("limits and calibration  stay"), "{again}");
    std::fs::write(desk.path("other.toml"), identified(101).expect("a joint").to_toml()).expect("written");
    let said = desk.succeeds("deploy other.toml --joint --dry-run --timeout-s 10");
    assert!(said.contains("the board has another joint"), "{said}");
    assert!(was_never_driven(&desk));
    // Settings alone, for a recording, are kept with the joint.
    desk.write("exc.csv", EXCITATION);
    desk.write("board.toml", "");
    desk.succeeds(&format!(
        "capture --joint --excitation exc.csv -o rec.csv --settings board.toml {PATIENT}"
    ));
    let said = desk.succeeds("deploy joint.toml --joint --dry-run --timeout-s 10");
    assert!(said.contains("the board has this joint already"), "{said}");
}

#[test]
fn what_a_flash_does_not_keep_ends_a_deployment_and_is_noted_beside_a_run() {
    let desk = with_model(Setting { is_worn: true, ..Setting::sound(SEED) }, SEED);
    desk.write("board.toml", SETTINGS);
    desk.write("exc.csv", EXCITATION);
    let said = desk.refuses(DEPLOY);
    assert!(said.contains("its flash has not kept it: it is lost when power is"), "{said}");
    let capture = format!("capture --joint --excitation exc.csv -o rec.csv --settings board.toml {PATIENT}");
    let says_so = |command: &str| {
        let done = desk.run(command);
        let said = String::from_utf8_lossy(&done.stderr).into_owned();
        assert!(done.status.success() && said.contains("note: what the board was given is in use"), "{said}");
    };
    says_so(&capture);
    says_so(&format!("{TRACK} -o log.csv"));
}

#[test]
fn what_another_image_has_stored_is_a_fault_with_its_cure_and_a_deployment_replaces_it() {
    let setting = Setting { stored: include_bytes!("golden/store_layout_6.bin"), ..Setting::sound(SEED) };
    let desk = with_model(setting, SEED);
    desk.write("board.toml", SETTINGS);
    let said = desk.refuses(DEPLOY);
    for words in ["fault 23", "was one for a single muscle", "mgpi deploy --joint", "--acknowledge"] {
        assert!(said.contains(words), "{said}");
    }
    assert!(was_never_driven(&desk));
    desk.succeeds(&format!("{DEPLOY} --acknowledge"));
    desk.succeeds(&format!("{TRACK} -o log.csv"));
}

#[test]
fn a_recording_that_was_interrupted_goes_on_filled_and_swung_again() {
    // After some 6 s, of which 3 count.
    let desk = JointDesk::new(Setting { restarts_at: &[1500], ..Setting::sound(SEED) });
    desk.write("exc.csv", EXCITATION);
    desk.write("other.csv", &EXCITATION.replace("17,3.5", "17,3.6"));
    let capture = format!("capture --joint --excitation exc.csv -o rec.csv {PATIENT}");
    let said = desk.refuses(&format!("{capture} --resume"));
    assert!(said.contains("rec.csv.part: no part of a recording to go on with"), "{said}");
    let said = desk.refuses(&capture);
    assert!(said.contains("kept in rec.csv.part; --resume continues it"), "{said}");
    let part = desk.read("rec.csv.part");
    let said = desk.refuses(&capture);
    assert!(said.contains("a part of a recording already; --resume continues it"), "{said}");
    for other in [
        capture.replace("exc.csv", "other.csv"),
        format!("{capture} --every 20"),
        format!("{capture} --torque-newton-metre 1"),
    ] {
        let said = desk.refuses(&format!("{other} --resume"));
        assert!(said.contains("is a part of the recording of another excitation"), "{other}: {said}");
    }
    assert_eq!(desk.read("rec.csv.part"), part, "what is refused changes nothing");
    assert_eq!(desk.files(), ["exc.csv", "other.csv", "rec.csv.part"]);
    desk.succeeds(&format!("{capture} --resume"));
    assert_eq!(desk.files(), ["exc.csv", "other.csv", "rec.csv"]);

    let whole = desk.read("rec.csv");
    assert!(whole.starts_with(part.as_str()), "every row of the part is kept");
    assert_eq!(whole.matches("# interrupted, resumed at ").count(), 1);
    let rows = rows(&desk.path("rec.csv"));
    let seam = rows.windows(2).position(|pair| pair[1][0] - pair[0][0] > 0.5).expect("a gap");
    let (last, first) = (rows[seam][0], rows[seam + 1][0]);
    assert!((first - last - 1.0).abs() < 0.02, "{last} s and {first} s");
    // 3 s of filling and swinging, 4 s of going there, of which no row counts.
    for row in &rows[seam + 1..] {
        assert_eq!(row[7] == 1.0, row[0] >= first + 7.0 - 0.005, "{row:?}");
    }
    // From there on as if there had been nothing, to the end.
    let length_s = 9.0 - last;
    assert!((rows[rows.len() - 1][0] - (first + 7.0 + length_s)).abs() < 0.02, "{:?}", rows[rows.len() - 1]);
    let peak = rows.iter().find(|row| row[0] >= first + 7.0 + (7.0 - last) + 0.005).expect("a row");
    assert!((peak[1] - 3.5).abs() < 0.02 && (peak[2] - 2.5).abs() < 0.02, "{peak:?}");
    assert_eq!(recording(&desk.path("rec.csv")).parts().count(), 2);
}

fn recording(file: &Path) -> JointRecording {
    let choice = Choice::default();
    JointRecording::of(&choice.table(file).expect("a table"), &choice).expect("a recording")
}

/// The mean torque of the feedback of a run, in a log. Unit: N m.
fn fed_back(log: &str) -> f64 {
    let torques: Vec<f64> = (log.lines().skip(1))
        .map(|line| line.split(',').nth(8).expect("a field").parse().expect("a number"))
        .collect();
    torques.iter().sum::<f64>() / torques.len() as f64
}

#[test]
fn a_torque_that_the_reference_tells_is_fed_forward() {
    let desk = with_model(Setting { load_nm: 4.0, ..Setting::sound(SEED) }, SEED);
    let known: String = REFERENCE
        .lines()
        .map(|line| {
            let field = if line.starts_with("time_s") { "torque_newton_metre" } else { "4" };
            format!("{line},{field}\n")
        })
        .collect();
    std::fs::write(desk.path("known.csv"), known).expect("written");
    desk.succeeds("track --joint --model joint.toml --reference known.csv -o known.log");
    let known = fed_back(&std::fs::read_to_string(desk.path("known.log")).expect("a log"));
    assert!(known.abs() < 1.0, "{known} N m");
    // Who does not tell it has a joint that is not the model's.
    let said = desk.refuses(TRACK);
    assert!(said.contains("fault 306"), "{said}");
}

#[test]
fn what_cannot_be_is_said_before_the_board_is_asked() {
    let desk = with_model(Setting::sound(SEED), SEED);
    let write = |name: &str, text: &str| std::fs::write(desk.path(name), text).expect("written");
    write("outside.csv", &REFERENCE.replace("2,6,55", "2,80,55"));
    write("limp.csv", &REFERENCE.replace("2,6,55", "2,6,0"));
    write("there.csv", "");
    let mut bad = identified(SEED).expect("a joint");
    let (lowest, highest) = bad.parameters.angles;
    bad.identification.heldout_rmse_deg = 0.2 * (highest - lowest).to_degrees();
    write("bad.toml", &bad.to_toml());
    const HIGH: &str = "high.csv, line 3, column command_b_bar: 7 bar is outside 0 to 6.6 bar, what a board of a joint takes";
    write("high.csv", "time_s,command_a_bar,command_b_bar,valid\n0,0,0,0\n1,2,7,1\n");
    write("filled.csv", "time_s,command_a_bar,command_b_bar,valid\n0,0,0,1\n1,2,2,1\n");
    write("unsaid.csv", "time_s,command_a_bar,command_b_bar\n0,0,0\n1,2,2\n");
    let before = desk.files();
    for (arguments, message) in [
        (
            "track --joint --model joint.toml --reference outside.csv -o log.csv",
            "outside.csv, column reference_deg: 80 degrees is outside the angles of joint.toml",
        ),
        (
            "track --joint --model joint.toml --reference limp.csv -o log.csv",
            "limp.csv, column stiffness_nm_per_rad: 0 N m/rad is no stiffness",
        ),
        ("track --joint --model joint.toml --reference reference.csv -o there.csv", "exists already"),
        ("track --joint --model reference.csv --reference reference.csv", "not a TOML file"),
        ("track --joint --reference reference.csv", "--model"),
        ("track --joint --model joint.toml --reference reference.csv --mode feedback", "cannot be used with"),
        ("track --model joint.toml --reference reference.csv --acknowledge", "--joint"),
        ("capture --joint -o there.csv", "exists already"),
        ("capture --joint --min-bar 4 --max-bar 5 -o rec.csv", "has to be more than 6.26 bar"),
        ("capture --joint --swing 1.5 -o rec.csv", "above 0 and below 1"),
        ("capture --joint --torque-newton-metre nan -o rec.csv", "must be a number"),
        ("capture --joint --excitation high.csv -o rec.csv", HIGH),
        (
            "capture --joint --excitation filled.csv -o rec.csv",
            "line 2, column valid: counts from the first row on",
        ),
        ("capture --joint --excitation unsaid.csv -o rec.csv", "unsaid.csv: no column valid"),
        ("capture --joint --excitation reference.csv -o rec.csv", "reference.csv: no column command_a_bar"),
        ("capture --joint --excitation high.csv --min-bar 2 -o rec.csv", "cannot be used with"),
        ("capture --joint --excitation high.csv --max-bar 5 -o rec.csv", "cannot be used with"),
        ("capture --joint --excitation high.csv -o high.csv --force", "is an input of this command"),
        ("capture --min-bar 2 -o rec.csv", "--joint"),
        ("deploy reference.csv --joint", "not a TOML file"),
        ("deploy joint.toml --joint --kp 3", "cannot be used with"),
        ("deploy joint.toml --joint --keep-gains", "cannot be used with"),
        ("deploy joint.toml --settings there.csv", "--joint"),
        ("deploy bad.toml --joint", "off by 20.00 % of its range of angles on held-out samples"),
    ] {
        let said = desk.refuses(arguments);
        assert!(said.contains(message), "{arguments}: {said}");
    }
    assert_eq!(desk.files(), before);
    assert_eq!(desk.seen().requests, 0);
}

#[test]
fn a_board_that_is_none_of_a_joint_of_this_version_is_said_and_not_driven() {
    let of = |setting: Setting| with_model(setting, SEED);
    let sound = Setting::sound(SEED);
    for (desk, message) in [
        (of(Setting { is_single: true, ..sound }), "a board with one muscle answers"),
        (
            of(Setting { version: Some(3), ..sound }),
            "speaks version 3 of a joint's messages, this program version 7",
        ),
        (of(Setting { is_still: true, ..sound }), "ticks stand still"),
        (
            prepared(JointDesk::disturbed(sound, |_, _| Vec::new()), SEED),
            "no answer within 0.12 s, asked 3 times",
        ),
        (
            prepared(
                JointDesk::disturbed(sound, |way, mut bytes| {
                    if way == Way::FromBoard {
                        bytes[1] ^= 0x55;
                    }
                    bytes
                }),
                SEED,
            ),
            "damaged answers only",
        ),
    ] {
        for command in [format!("{TRACK} -o log.csv"), "capture --joint -o rec.csv".to_owned()] {
            let before = desk.files();
            let said = desk.refuses(&command);
            assert!(said.contains(message), "{command}: {said}");
            assert_eq!(desk.files(), before, "{message}");
            assert!(was_never_driven(&desk), "{message}");
        }
    }
}

#[test]
fn what_the_start_finds_is_said_with_number_cause_and_cure_and_stays_until_it_is_acknowledged() {
    for (wrong, model_of, fault, cure) in [
        (Wrong::Angle, SEED, "fault 303", "turn the sensor's sign, or swap the channels"),
        (Wrong::Channels, SEED, "fault 303", "turn the sensor's sign, or swap the channels"),
        (Wrong::Sensors, SEED, "fault 305", "swap the plugs"),
        (Wrong::Frozen, SEED, "fault 304", "look at joint, sensor and supply"),
    ] {
        let desk = with_model(Setting { wrong, ..Setting::sound(SEED) }, model_of);
        let before = desk.files();
        let said = desk.refuses(&format!("{TRACK} -o log.csv"));
        assert!(said.contains(fault) && said.contains("cause: ") && said.contains(cure), "{wrong:?}: {said}");
        assert!(is_vented(&desk));
        assert_eq!(desk.files(), before, "no row, no log");
        let said = desk.refuses(&format!("{TRACK} -o log.csv"));
        assert!(said.contains("at fault since before") && said.contains("--acknowledge"), "{said}");
        let said = desk.refuses(&format!("{TRACK} -o log.csv --acknowledge"));
        assert!(said.contains("after the start the board has vented") && said.contains(fault), "{said}");
    }
}

/// The model of a joint that is stiffer and turns less.
#[test]
fn the_model_of_another_joint_is_recognised_by_the_swing() {
    let desk = with_model(Setting::sound(SEED), SEED);
    let model = std::fs::read_to_string(desk.path("joint.toml")).expect("a model");
    let other: String = model
        .lines()
        .map(|line| match line.split_once(" = ") {
            Some((name, value)) if name.starts_with("linear_nm") => {
                format!("{name} = {}\n", 0.3 * value.parse::<f64>().expect("a number") - 25.0)
            }
            _ => format!("{line}\n"),
        })
        .collect();
    std::fs::write(desk.path("joint.toml"), other).expect("written");
    let said = desk.refuses(TRACK);
    assert!(said.contains("fault 306") && said.contains("identify --joint"), "{said}");
    assert!(is_vented(&desk));
}

/// The plant of the board goes on; its program has begun again.
#[test]
fn a_board_that_starts_again_ends_a_run() {
    let setting = Setting { restarts_at: &[800], ..Setting::sound(SEED) };
    for command in [format!("{TRACK} -o log.csv"), CAPTURE.to_owned()] {
        let desk = with_model(setting, SEED);
        let said = desk.refuses(&command);
        assert!(said.contains("vented by itself, in the state Off: was it restarted?"), "{command}: {said}");
        assert!(is_vented(&desk));
    }
}

/// One exchange in some eight is damaged, in either direction, or its answer lost.
#[test]
fn frames_that_are_damaged_or_lost_are_sent_again() {
    let mut count = 0;
    let disturbed = JointDesk::disturbed(Setting::sound(SEED), move |way, mut bytes| {
        count += 1;
        match way {
            Way::FromBoard if count % 211 == 0 => Vec::new(),
            Way::FromBoard if count % 29 == 0 => {
                bytes[3] ^= 0x10;
                bytes
            }
            Way::ToBoard if count % 17 == 0 && bytes.len() > 4 => {
                bytes[2] ^= 0x04;
                bytes
            }
            _ => bytes,
        }
    });
    let desk = prepared(disturbed, SEED);
    let reference = "time_s,reference_deg,stiffness_nm_per_rad\n0,-8,55\n1,6,55\n";
    std::fs::write(desk.path("reference.csv"), reference).expect("written");
    desk.succeeds(&format!("{TRACK} -o log.csv --json run.json"));
    let run = figures(&desk.path("run.json"));
    let share = run["rmse_deg"].as_f64().expect("a number") / run["range_deg"].as_f64().expect("a number");
    assert!(share < 0.01, "{run}");
    desk.succeeds("capture --joint --duration-s 10 -o rec.csv");
    assert!(is_vented(&desk));
}

/// A program that drives a joint in real time, as soon as a valve is open.
fn driving(desk: &JointDesk, arguments: &str) -> Child {
    let mut command = desk.command(arguments);
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("mgpi runs");
    wait_until(|| desk.seen().last.is_some_and(|last| last.dac_codes.iter().all(|code| *code > 300)));
    child
}

fn wait_until(is: impl Fn() -> bool) {
    let deadline = Instant::now() + Duration::from_secs(60);
    while !is() {
        assert!(Instant::now() < deadline, "it never comes");
        sleep(Duration::from_millis(5));
    }
}

fn signal(child: &Child, name: &str) {
    let sent = Command::new("kill").args([format!("-{name}"), child.id().to_string()]).status();
    assert!(sent.is_ok_and(|status| status.success()));
}

const CAPTURE: &str = "capture --joint --duration-s 60 -o rec.csv";

#[test]
fn a_host_that_is_killed_leaves_a_joint_that_vents_within_half_a_second() {
    for command in [format!("{TRACK} -o log.csv"), CAPTURE.to_owned()] {
        let desk = with_model(Setting { time: Time::Real, ..Setting::sound(SEED) }, SEED);
        let mut child = driving(&desk, &command);
        signal(&child, "KILL");
        child.wait().expect("it ends");
        wait_until(|| is_vented(&desk));
        let seen = desk.seen();
        let silent = seen.vented.wrapping_sub(seen.heard);
        let patience = Protection::STANDARD.bus_silent_ticks;
        assert!(silent <= patience + 1, "{command}: {silent} ticks");
        assert_eq!(seen.last.map(|last| last.state), Some(JointBoardState::Fault));
        let said = desk.refuses("capture --joint -o other.csv");
        assert!(said.contains("fault 21") && said.contains("start it again"), "{said}");
    }
}

#[test]
fn a_user_who_interrupts_vents_at_once_and_keeps_what_was_recorded() {
    let desk = with_model(Setting { time: Time::Real, ..Setting::sound(SEED) }, SEED);
    let child = driving(&desk, CAPTURE);
    wait_until(|| desk.path("rec.csv.part").metadata().is_ok_and(|file| file.len() > 3000));
    signal(&child, "INT");
    let output = child.wait_with_output().expect("it ends");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(130), "{said}");
    assert!(said.contains("kept in rec.csv.part") && said.contains("interrupted"), "{said}");
    // At the next tick, and not by the host's silence.
    wait_until(|| is_vented(&desk));
    assert_eq!(desk.seen().last.map(|last| last.state), Some(JointBoardState::Off));
    let part = std::fs::read_to_string(desk.path("rec.csv.part")).expect("a part");
    assert!(part.lines().count() > 20 && part.ends_with('\n') && !desk.path("rec.csv").exists());
    // What is kept is not overwritten.
    let said = desk.refuses(CAPTURE);
    assert!(said.contains("rec.csv.part: there is a part of a recording already"), "{said}");
}

#[test]
fn a_port_that_is_unplugged_ends_a_run_and_its_log_is_kept() {
    let mut desk = with_model(Setting { time: Time::Real, ..Setting::sound(SEED) }, SEED);
    let child = driving(&desk, CAPTURE);
    wait_until(|| desk.path("rec.csv.part").metadata().is_ok_and(|file| file.len() > 3000));
    desk.unplug();
    let output = child.wait_with_output().expect("it ends");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("kept in rec.csv.part") && said.contains("gone"), "{said}");
}
