//! The unmodified production image in a model of its chip: `host-tests/chip`, a test of Python's
//! `unittest` each. Programs of Python run them (`serve.py`), as many at once as there are threads
//! here; each has a chip that has started already.
//!
//! Skipped, in so many words, where the model's Python or the firmware are missing; `cargo xtask
//! test` provides both.

mod terminal;

use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::{Arc, Mutex};

use board_client::emulator::image;
use board_models::extended_parameters;
use board_models::joint::joint_parameters;
use firmware::store::ParameterStore;
use host_tests::flash::MockFlash;
use host_tests::store::{Limited, joint_set, numbered, paper_set};
use libtest_mimic::{Arguments, Conclusion, Failed, Trial};
use model_core::Mode;
use model_core::joint::JointTarget;
use wire::image::{BoardKind, Linked, Place};
use wire::joint::{
    JOINT_VERSION, JointAim, JointBoardState, JointCalibration, JointConfiguration, JointRequest,
    JointResponse, JointSettings,
};
use wire::{
    Configuration, FRAME_BYTES, Line, Protection, Refusal, Request, Response, State, VERSION, fingerprint,
};

/// The environment variable that names a Python which has Unicorn.
const PYTHON: &str = "MGPI_CHIP_PYTHON";
/// The one by which the model finds the image.
const IMAGE: &str = "MGPI_CHIP_IMAGE";
/// The one by which it finds the contents of a flash whose next save erases.
const STORE: &str = "MGPI_CHIP_STORE";
/// The same of a board with a joint.
const JOINT_STORE: &str = "MGPI_CHIP_JOINT_STORE";
/// The one by which it finds requests and responses of the link, as frames.
const FRAMES: &str = "MGPI_CHIP_FRAMES";
/// The one by which it finds images as they come by an update, a file each.
const IMAGES: &str = "MGPI_CHIP_IMAGES";
/// The one that names a program of the model to be run in place of the tests: `mutants.py`,
/// `long_runs.py`.
const PROGRAM: &str = "MGPI_CHIP_PROGRAM";
/// At which a joint is started. Unit: N m/rad.
const STIFFNESS: f32 = 40.0;
/// Unit: byte.
const SECTOR: usize = 16 * 1024;
/// More than both sectors have room for.
const SETS: u32 = 200;

fn main() -> Result<(), Failed> {
    // Behind the end of `run`, which removes its temporary files.
    if let Some(conclusion) = run()? {
        conclusion.exit_if_failed();
    }
    Ok(())
}

/// The tests, or the program in their place.
fn run() -> Result<Option<Conclusion>, Failed> {
    let inputs = tempfile::tempdir()?;
    let [store, joint_store, frames_file, images] =
        ["store", "joint_store", "frames", "images"].map(|name| inputs.path().join(name));
    let files = Files { store, joint_store, frames: frames_file, images };
    std::fs::write(&files.store, full_store(paper_set())?)?;
    std::fs::write(&files.joint_store, full_store(joint_set())?)?;
    std::fs::write(&files.frames, frames()?)?;
    std::fs::create_dir(&files.images)?;
    if image_file().is_file() {
        write_images(&files.images)?;
    }
    if let Some(program) = std::env::var_os(PROGRAM) {
        let status = python(&files).arg(program).status()?;
        return if status.success() { Ok(None) } else { Err("it has failed".into()) };
    }
    let trials = match names(&files) {
        Ok(names) => {
            let servers = Arc::new(Servers { files: files.clone(), idle: Mutex::default() });
            let of_terminals = if terminal::has_images() { terminal::trials(&files) } else { Vec::new() };
            names.into_iter().map(|name| trial(name, servers.clone())).chain(of_terminals).collect()
        }
        Err(reason) => {
            println!("the tests of the chip are skipped: {reason}");
            vec![
                Trial::test("the_production_image_in_the_model_of_its_chip", || Ok(()))
                    .with_ignored_flag(true),
            ]
        }
    };
    Ok(Some(libtest_mimic::run(&Arguments::from_args(), trials)))
}

/// What the model is given.
#[derive(Clone)]
struct Files {
    store: PathBuf,
    joint_store: PathBuf,
    frames: PathBuf,
    images: PathBuf,
}

/// Requests, and the responses they are met with: a name and a frame a line.
fn frames() -> Result<String, Failed> {
    let extended = Configuration { version: VERSION, tracking: extended_parameters()? };
    let framed = |name: &str, frame: &[u8]| {
        let digits: String = frame.iter().map(|byte| format!("{byte:02x}")).collect();
        format!("{name} {digits}\n")
    };
    let aim = |by_tick| {
        let target = JointTarget { angle: 0.25, stiffness: STIFFNESS, load: 0.0 };
        JointRequest::Aim(Some(JointAim { target, by_tick }))
    };
    let mut buffer = [0; FRAME_BYTES];
    let mut text = String::new();
    for (name, request) in [
        ("identify", Request::Identify),
        ("protect", Request::Protect(Protection::WIDEST)),
        ("beyond", Request::Protect(Protection::SIMULATED)),
        ("arm", Request::Arm),
        ("extended", Request::Configure(extended)),
        ("start", Request::Start(Mode::Both)),
    ] {
        text += &framed(name, wire::encode(&request, &mut buffer)?);
    }
    for (name, response) in [
        ("accepted", Response::Accepted),
        ("unreadable", Response::Refused(Refusal::Unreadable)),
        ("not_stored", Response::Refused(Refusal::NotStored)),
    ] {
        text += &framed(name, wire::encode(&response, &mut buffer)?);
    }
    for (name, request) in [
        (
            "joint_configure",
            JointRequest::Configure(JointConfiguration {
                version: JOINT_VERSION,
                control: joint_parameters(),
            }),
        ),
        ("joint_arm", JointRequest::Arm),
        ("joint_start", JointRequest::Start(STIFFNESS)),
        ("joint_stop", JointRequest::Stop),
        ("joint_acknowledge", JointRequest::Acknowledge),
        ("joint_identify", JointRequest::Identify),
        ("joint_service", JointRequest::Service),
        ("joint_aim", aim(0)),
        ("joint_aim_by", aim(70_000)),
        ("joint_press", JointRequest::Press([2.5, 1.5])),
        ("joint_press_too_much", JointRequest::Press([7.0, 1.5])),
        ("joint_installed", JointRequest::Installed),
        ("joint_settings", JointRequest::Settings(Some(joint_settings()))),
        ("joint_settings_asked", JointRequest::Settings(None)),
        ("joint_control", JointRequest::Control),
        ("joint_status", JointRequest::Status),
    ] {
        text += &framed(name, wire::encode(&request, &mut buffer)?);
    }
    for (name, response) in [
        ("joint_accepted", JointResponse::Accepted),
        ("joint_not_armed", JointResponse::Refused(Refusal::NotArmed)),
        ("joint_at_fault", JointResponse::WrongState(JointBoardState::Fault)),
        ("joint_is_off", JointResponse::WrongState(JointBoardState::Off)),
        ("joint_in_service", JointResponse::WrongState(JointBoardState::Service)),
        ("joint_not_stored", JointResponse::Refused(Refusal::NotStored)),
        ("joint_has_none", JointResponse::Installed(None)),
        ("joint_has_it", JointResponse::Installed(Some(fingerprint(&joint_parameters())))),
        ("joint_has_the_stored", JointResponse::Installed(joint_set().control.as_ref().map(fingerprint))),
        ("joint_is_set", JointResponse::Settings(joint_settings())),
        ("joint_control_none", JointResponse::Control(None)),
        ("joint_control_is", JointResponse::Control(Some(joint_parameters()))),
        ("joint_control_stored", JointResponse::Control(joint_set().control)),
    ] {
        text += &framed(name, wire::encode(&response, &mut buffer)?);
    }
    Ok(text + &framed("joint_numbers", &joint_numbers()))
}

/// Settings of which none is the standard one, of sensors that are nearly so: the model's plant is
/// seen by the standard ones.
fn joint_settings() -> JointSettings {
    let line = |zero_code, codes_per_unit| Some(Line { zero_code, codes_per_unit });
    JointSettings {
        protection: Protection { supply_min_bar: 3.5, ..Protection::STANDARD },
        calibration: JointCalibration {
            pressures: [line(411.0, 325.9), line(407.5, 329.0)],
            angle: line(2050.0, 1170.0),
        },
    }
}

/// What the model's plant has to know of the joint: torques of a bar and passive torque over the
/// angle, lag, both ends, and the knee of the drive.
fn joint_numbers() -> Vec<u8> {
    let joint = joint_parameters().joint;
    let [a, b] = &joint.muscles;
    let others = [a.valve_lag_s, joint.angles.0, joint.angles.1, a.knee];
    let all = a.arm.iter().chain(&b.arm).chain(&joint.passive).chain(&others);
    all.flat_map(|number| number.to_le_bytes()).collect()
}

/// Sectors that are both full of a set, and so erased by the next save.
fn full_store<P: Limited>(set: P) -> Result<Vec<u8>, Failed> {
    let mut store = ParameterStore::new(MockFlash::<SECTOR>::blank());
    let mut full = None;
    for number in 1001..1001 + SETS {
        let before = store.flash().bytes().to_vec();
        store.save(State::Ready, &numbered(number, set.clone())).map_err(|error| format!("{error:?}"))?;
        let cleared =
            before.iter().zip(store.flash().bytes()).any(|(before, after)| *before == 0 && *after != 0);
        full = if cleared { Some(before) } else { full };
    }
    full.ok_or_else(|| "the sectors are never full".into())
}

/// Images with their signatures, each with what a board has to refuse, or to roll back.
fn write_images(folder: &Path) -> Result<(), Failed> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let (key, _) = packing::read_key(&root.join("firmware/keys/tests-only.key"))?;
    let forger = folder.join("forger.key");
    packing::new_key(&forger)?;
    let (forger, _) = packing::read_key(&forger)?;
    let [a, b] = [image_file(), image_file().with_file_name("stm32f405_b")];
    // `b .`, which hangs, and `udf`, a fault of the processor without end.
    let (hangs, faults): ([u8; 4], _) = ([0xFE, 0xE7, 0xFE, 0xE7], [0x00, 0xDE, 0x00, 0xDE]);
    let full = packing::package([&a, &b], &key)?;
    let linked = packing::linked(&b)?;
    let small = |linked| packing::small(Place::B, &linked, &key, &hangs);
    for (name, image) in [
        ("a", full.image(Place::A).to_vec()),
        ("b", full.image(Place::B).to_vec()),
        ("hangs", small(linked)?),
        ("faults", packing::small(Place::B, &linked, &key, &faults)?),
        ("place_a", packing::small(Place::A, &linked, &key, &hangs)?),
        ("forged", packing::small(Place::B, &linked, &forger, &hangs)?),
        ("coil", small(Linked { kind: BoardKind::Coil.number(), ..linked })?),
        ("revision", small(Linked { revisions: [7, 9], ..linked })?),
        ("older", small(Linked { release: [0, 0, 9], ..linked })?),
    ] {
        std::fs::write(folder.join(name), image)?;
    }
    Ok(())
}

/// The tests, as the model's own list tells; or what is missing for them.
fn names(files: &Files) -> Result<Vec<String>, String> {
    if std::env::var_os(PYTHON).is_none() {
        return Err(format!("{PYTHON} names no Python with unicorn; `cargo xtask test` makes one"));
    }
    if !image_file().is_file() {
        return Err(format!("no {}; `cargo xtask firmware` builds it", image_file().display()));
    }
    let listed = python(files).arg("names.py").output().map_err(|error| error.to_string())?;
    if !listed.status.success() {
        return Err(String::from_utf8_lossy(&listed.stderr).into_owned());
    }
    Ok(String::from_utf8_lossy(&listed.stdout).lines().map(str::to_owned).collect())
}

fn trial(name: String, servers: Arc<Servers>) -> Trial {
    let shown = name.replace("test_", "").replace('.', "::");
    Trial::test(shown, move || {
        let mut server = servers.take()?;
        let answer = server.run(&name)?;
        servers.give_back(server);
        if answer["ok"] == true { Ok(()) } else { Err(answer["said"].as_str().unwrap_or_default().into()) }
    })
}

/// The programs that run tests, and have nothing to do.
struct Servers {
    files: Files,
    idle: Mutex<Vec<Server>>,
}

impl Servers {
    fn take(&self) -> Result<Server, Failed> {
        let idle = self.idle.lock().map_err(|_| "another test has panicked")?.pop();
        idle.map_or_else(|| Server::start(&self.files), Ok)
    }

    fn give_back(&self, server: Server) {
        if let Ok(mut idle) = self.idle.lock() {
            idle.push(server);
        }
    }
}

/// A program that runs tests, one after the other.
struct Server {
    process: Child,
    names: ChildStdin,
    answers: BufReader<ChildStdout>,
}

impl Server {
    fn start(files: &Files) -> Result<Self, Failed> {
        let mut command = python(files);
        let mut process = command.arg("serve.py").stdin(Stdio::piped()).stdout(Stdio::piped()).spawn()?;
        match (process.stdin.take(), process.stdout.take()) {
            (Some(names), Some(answers)) => Ok(Self { process, names, answers: BufReader::new(answers) }),
            _ => Err("it has no pipes".into()),
        }
    }

    /// Whether a test is `ok`, and what it has `said`.
    fn run(&mut self, name: &str) -> Result<serde_json::Value, Failed> {
        writeln!(self.names, "{name}")?;
        let mut line = String::new();
        self.answers.read_line(&mut line)?;
        Ok(serde_json::from_str(&line)
            .map_err(|_| format!("the program that runs the tests has ended: {line}"))?)
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        // Each of its tests is over: there is nothing to lose.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

fn python(files: &Files) -> Command {
    let mut command = Command::new(std::env::var_os(PYTHON).unwrap_or_default());
    command.current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("chip"));
    command
        .env(STORE, &files.store)
        .env(JOINT_STORE, &files.joint_store)
        .env(FRAMES, &files.frames)
        .env(IMAGES, &files.images);
    command.env(IMAGE, image_file()).env("PYTHONDONTWRITEBYTECODE", "1");
    command
}

/// The production image, beside that for the emulator.
fn image_file() -> PathBuf {
    image::find(None).map(|image| image.with_file_name("stm32f405")).unwrap_or_default()
}
