//! `mgpi` as a user has it, at a terminal behind which the unmodified image runs in the model of
//! its chip (`host-tests/chip/terminal.py`).

use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, Stdio};

use board_client::update::Package;
use board_models::joint::joint_parameters;
use host_tests::commands::mgpi;
use libtest_mimic::{Failed, Trial};
use recording::Source;
use recording::joint::file::JointFile;

use crate::{Files, image_file, python};

/// Seconds that the host waits for an answer: the model may be slower than time, most of all while
/// it looks at an image.
const PATIENCE_S: &str = "60";

/// The tests. The update takes minutes, and is run by who asks for it: `--ignored`.
pub fn trials(files: &Files) -> Vec<Trial> {
    let (first, second, third) = (files.clone(), files.clone(), files.clone());
    vec![
        Trial::test("terminal::mgpi_records_a_joint_and_tracks_with_it_over_the_link", move || joint(&third)),
        Trial::test("terminal::mgpi_bring_up_writes_the_record_of_a_board", move || bring_up(&first)),
        Trial::test("terminal::mgpi_update_brings_a_whole_image_to_the_board_which_keeps_it", move || {
            update(&second)
        })
        .with_ignored_flag(true),
    ]
}

/// A chip at a terminal.
struct AtTerminal {
    process: Child,
    output: BufReader<ChildStdout>,
    port: PathBuf,
}

impl AtTerminal {
    fn start(files: &Files, kind: &str) -> Result<Self, Failed> {
        let mut command = python(files);
        command.args(["terminal.py", kind]).stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut process = command.spawn()?;
        let mut output = BufReader::new(process.stdout.take().ok_or("it has no output")?);
        let mut port = String::new();
        output.read_line(&mut port)?;
        Ok(Self { process, output, port: PathBuf::from(port.trim_end()) })
    }

    /// Ends it; what the manual forbids and has happened, a line each.
    fn end(mut self) -> Result<String, Failed> {
        drop(self.process.stdin.take());
        let mut violations = String::new();
        self.output.read_to_string(&mut violations)?;
        Ok(violations.trim().to_owned())
    }
}

impl Drop for AtTerminal {
    fn drop(&mut self) {
        // It has ended by itself, or its test has failed.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Runs `mgpi`; what it says, and its exit status.
fn said(command: &mut Command) -> Result<(String, Option<i32>), Failed> {
    let output = command.output()?;
    let text = [output.stdout, output.stderr].concat();
    Ok((String::from_utf8_lossy(&text).into_owned(), output.status.code()))
}

fn bring_up(files: &Files) -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    let board = AtTerminal::start(files, "bring-up")?;
    let ask = |record: &str, options: &[&str]| {
        let mut command = Command::new(mgpi());
        command.current_dir(folder.path()).arg("bring-up").arg(&board.port);
        said(command.args(["-o", record]).args(options))
    };
    let (text, status) = ask("record.toml", &["--drive-output", "--echo"])?;
    assert!(status == Some(0) && text.contains("record.toml: all 33 parts are good"), "{text}");
    let record: toml::Table = std::fs::read_to_string(folder.path().join("record.toml"))?.parse()?;
    assert_eq!(record["passed"].as_bool(), Some(true));
    assert_eq!(record["unique_id"]["value"].as_str(), Some("323837323134510e00390045"));
    assert!(record["crystal_hz"]["value"].as_integer().is_some_and(|hz| (hz - 8_000_000).abs() < 1_000));
    let (text, status) = ask("record.toml", &[])?;
    assert!(status == Some(2) && text.contains("exists already"), "{text}");
    assert_eq!(board.end()?, "");
    Ok(())
}

/// The plant has no friction, and the model that the board is given has some: angles are that near
/// where they are asked for, as a share of the range.
const JOINT_RMSE: f64 = 0.01;

fn joint(files: &Files) -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    let at = |name: &str| folder.path().join(name);
    let parameters = joint_parameters().joint.convert()?;
    let source = Source { file: "board-models".to_owned(), sha256: String::new() };
    std::fs::write(at("joint.toml"), JointFile::new(parameters, source, 0, (0.0, 0.0))?.to_toml())?;
    let reference = "time_s,reference_deg,stiffness_nm_per_rad\n0,-8,40\n1.5,8,40\n2,8,45\n";
    std::fs::write(at("reference.csv"), reference)?;
    let board = AtTerminal::start(files, "joint")?;
    let run = |arguments: &str| {
        let mut command = Command::new(mgpi());
        command.current_dir(folder.path()).args(arguments.split_whitespace()).arg("--port").arg(&board.port);
        said(command.args(["--timeout-s", PATIENCE_S]))
    };
    let (text, status) = run("capture --joint --max-bar 5 --duration-s 6 --every 20 -o rec.csv")?;
    assert!(status == Some(0) && text.contains("one each 20 ms; ticks late: 0"), "{text}");
    let recording = std::fs::read_to_string(at("rec.csv"))?;
    let last = recording.lines().last().ok_or("it is empty")?;
    let fields: Vec<f64> = last.split(',').filter_map(|field| field.parse().ok()).collect();
    assert!(fields.len() == 8 && fields[0] > 5.9 && fields[1] > 1.7 && fields[3] > 1.5, "{last}");
    let (text, status) =
        run("track --joint --model joint.toml --reference reference.csv -o log.csv --json run.json")?;
    assert!(status == Some(0) && text.contains("ticks late: 0"), "{text}");
    println!("{text}");
    let figures: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(at("run.json"))?)?;
    let share = figures["rmse_deg"].as_f64().zip(figures["range_deg"].as_f64());
    assert!(share.is_some_and(|(rmse, range)| rmse < JOINT_RMSE * range), "{figures}");
    assert_eq!(board.end()?, "");
    Ok(())
}

fn update(files: &Files) -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    let [a, b] = ["a", "b"].map(|name| std::fs::read(files.images.join(name)));
    let package = Package { images: [a?, b?] };
    std::fs::write(folder.path().join("new.image"), package.to_bytes())?;
    let board = AtTerminal::start(files, "bus")?;
    let mut command = Command::new(mgpi());
    command.current_dir(folder.path()).args(["update", "new.image", "--port"]).arg(&board.port);
    let (text, status) = said(command.args(["--timeout-s", PATIENCE_S]))?;
    let is_kept = text.contains("the board runs with it, in the place B, and keeps it");
    assert!(status == Some(0) && is_kept, "{text}");
    assert_eq!(board.end()?, "");
    Ok(())
}

/// Whether the other images are there, too.
pub fn has_images() -> bool {
    ["bring_up", "stm32f405_joint"].iter().all(|name| image_file().with_file_name(name).is_file())
        && Path::new(&mgpi()).is_file()
}
