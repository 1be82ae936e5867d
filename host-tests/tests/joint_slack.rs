//! A recording of a joint in which a muscle was slack: it is recognised, said, and left out, and
//! sound recordings are not accused.

use std::process::Command;

use host_tests::commands::mgpi;
use host_tests::joint::{csv, recording};
use identification::joint::{IdentifiedJoint, JointError, SWING_RAD, identify_joint, without_slack};
use recording::joint::columns::COLUMNS;
use rig::joint::JointPlant;
use rig::joint::protocol::JointProtocol;
use rig::joint::recording::RATE_HZ;

/// When pressures are let down and come back; they go and come within 3 s. Unit: s.
const LET_DOWN_S: (f64, f64) = (150.0, 160.0);

/// A recording with both pressures as they are let down to this one at most (bar), and where a
/// muscle was slack or the joint at its end.
struct LetDown {
    csv: String,
    slack: Vec<bool>,
}

impl LetDown {
    /// Of the joint of a seed.
    fn new(seed: u64, lowest_bar: [f64; 2]) -> Self {
        let (protocol, mut plant) = (JointProtocol::new(seed), JointPlant::new(seed, true));
        let (mut csv, mut slack) = (format!("{COLUMNS}\n"), Vec::new());
        let (begin_s, end_s) = LET_DOWN_S;
        for row in 0..=(protocol.duration_s() * RATE_HZ) as u32 {
            let time_s = f64::from(row) / RATE_HZ;
            // 1 before and behind, 0 in the middle.
            let left = ((begin_s - time_s).max(time_s - end_s) / 3.0 + 1.0).clamp(0.0, 1.0);
            let commands = protocol.commands_bar(time_s);
            let [a, b] =
                [0, 1].map(|muscle| (left * commands[muscle]).max(lowest_bar[muscle]).min(commands[muscle]));
            let torque_nm = protocol.load_nm(time_s);
            plant.put_on(torque_nm);
            let measured = plant.step([a, b], if row == 0 { 0.0 } else { 1.0 / RATE_HZ });
            let ([pressure_a, pressure_b], angle) = (measured.pressures_bar, measured.angle_deg);
            let valid = u8::from(protocol.counts(time_s));
            csv += &format!(
                "{time_s:.6},{a:.4},{b:.4},{pressure_a:.4},{pressure_b:.4},{angle:.4},{torque_nm:.4},{valid}\n"
            );
            let is_at_end = plant.exact_deg().abs() > 68.5;
            slack.push(valid == 1 && (is_at_end || plant.tensions_n().contains(&0.0)));
        }
        Self { csv, slack }
    }
}

fn identified(csv: &[u8]) -> Result<IdentifiedJoint, JointError> {
    identify_joint(&recording(csv).expect("a recording"), SWING_RAD)
}

/// The least and the largest stiffness. Unit: N m/rad.
fn stiffness(joint: &IdentifiedJoint) -> [f64; 2] {
    joint.known.stiffness.map(|(value, _)| value)
}

#[test]
fn rows_of_a_slack_muscle_are_left_out_and_the_joint_is_that_of_a_sound_recording() {
    let sound = identified(&csv(1).expect("a recording")).expect("a joint");
    assert_eq!(sound.known.slack, []);
    for (lowest_bar, muscles) in
        [([0.0, 9.0], &[0][..]), ([9.0, 0.4], &[1]), ([0.4, 0.4], &[0, 1]), ([0.8, 0.8], &[0, 1])]
    {
        let recorded = LetDown::new(1, lowest_bar);
        let found = identified(recorded.csv.as_bytes()).expect("a joint");
        let taut =
            without_slack(&recording(recorded.csv.as_bytes()).expect("a recording"), &found.known.slack);
        let named: Vec<usize> = found.known.slack.iter().map(|slack| slack.muscle).collect();
        assert_eq!(named, muscles, "{lowest_bar:?} bar");
        for slack in &found.known.slack {
            assert!((0.5..2.0).contains(&slack.below_bar), "{slack:?}");
            assert!((slack.lowest_bar - lowest_bar[slack.muscle]).abs() < 0.05, "{slack:?}");
            assert!(slack.rows.start >= 14_800 && slack.rows.end <= 16_300, "{slack:?}");
        }
        let kept =
            recorded.slack.iter().zip(&taut.scored).filter(|(slack, counted)| **slack && **counted).count();
        let (soft, stiff) = (stiffness(&found), stiffness(&sound));
        println!(
            "{lowest_bar:?} bar: {} rows slack, {kept} of them kept; stiffness {soft:.1?} N m/rad, sound {stiff:.1?}",
            recorded.slack.iter().filter(|slack| **slack).count()
        );
        assert_eq!(kept, 0, "{lowest_bar:?} bar");
        for (value, sound) in soft.into_iter().zip(stiff) {
            assert!((value / sound - 1.0).abs() < 0.03, "{lowest_bar:?} bar: {value} and {sound} N m/rad");
        }
        let rmse_deg = found.file.identification.rmse_deg;
        assert!(rmse_deg < 0.3, "{lowest_bar:?} bar: {rmse_deg} degrees");
    }
}

#[test]
fn sound_recordings_are_not_accused() {
    for seed in 101..107 {
        let found = identified(&csv(seed).expect("a recording")).expect("a joint");
        assert_eq!(found.known.slack, [], "seed {seed}");
    }
}

#[test]
fn the_command_says_which_muscle_was_slack_where_and_when_in_which_file() {
    let directory = tempfile::tempdir().expect("a temporary directory");
    let write =
        |name: &str, content: &[u8]| std::fs::write(directory.path().join(name), content).expect("written");
    write("sound.csv", &csv(1).expect("a recording"));
    write("low.csv", LetDown::new(1, [0.4, 0.4]).csv.as_bytes());
    let mut command = Command::new(mgpi());
    command.args(
        "identify --joint sound.csv low.csv -o joint.toml --json joint.json --report joint.html".split(' '),
    );
    let output = command.current_dir(directory.path()).output().expect("mgpi runs");
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    for muscle in ["a", "b"] {
        let line =
            said.lines().find(|line| line.starts_with(&format!("slack         muscle {muscle} below ")));
        let line = line.expect("a line for each muscle");
        assert!(
            line.contains(" of low.csv are left out: it was slack, or the joint at its end")
                && (line.contains("down to 0.39 bar") || line.contains("down to 0.40 bar")),
            "{line}"
        );
        assert!(line.contains("from 150.") || line.contains("from 151."), "{line}");
    }
    let page = std::fs::read_to_string(directory.path().join("joint.html")).expect("a page");
    assert!(page.contains("Left out") && page.contains("data-name=\"left out\"") && !page.contains("NaN"));
    for lowest in page.split("data-label=\"down to (bar)\">").skip(1) {
        assert!(lowest.starts_with("0.39<") || lowest.starts_with("0.40<"), "{}", &lowest[..8]);
    }
    assert_eq!(page.matches("data-label=\"down to (bar)\">").count(), 2, "a row for each muscle");
    let figures = std::fs::read_to_string(directory.path().join("joint.json")).expect("figures");
    let figures: serde_json::Value = serde_json::from_str(&figures).expect("JSON");
    let slack = figures["slack"].as_array().expect("a list");
    assert_eq!(slack.len(), 2, "{figures}");
    let (first, rows) = (&slack[0], figures["scored_rows"].as_u64().expect("a number"));
    assert!(first["muscle"] == "a" && first["file"] == "low.csv", "{first}");
    let number = |name: &str| first[name].as_f64().expect("a number");
    assert!(
        (150.0..152.0).contains(&number("from_s")) && (159.0..161.0).contains(&number("to_s")),
        "{first}"
    );
    assert!(number("rows") > 700.0 && rows > 70_000 && rows < 72_518 - 700, "{rows} rows");
}
