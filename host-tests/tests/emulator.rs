//! The emulated firmware against the same control code on the host: bit for bit.
//!
//! Skipped, in so many words, where emulator or firmware are missing; `cargo xtask test` provides
//! both.

use std::process::Command;

use board_client::emulator::image::Which;
use board_client::emulator::{Emulator, image};
use board_client::pil::PilError;
use board_client::pil::lock_step::{Measurement, Plant, protect};
use board_client::pil::results::log;
use board_client::stop::Stop;
use board_models::extended_parameters;
use firmware::joint::JointScalings;
use host_tests::store::{joint_calibration, joint_set};
use host_tests::{HostBoard, configuration, identified, raised_cosines, rig, run};
use identification::{CONVERGED, Loss, Options, Weights};
use libtest_mimic::{Arguments, Failed, Trial};
use model_core::{Kind, Mode, ModelParameters, Surroundings, paper};
use wire::joint::{
    JOINT_VERSION, JointBoardState, JointConfiguration, JointRequest, JointResponse, JointSettings,
    JointTickRequest,
};
use wire::{Configuration, Protection, VERSION, fingerprint};

fn main() {
    let missing = missing();
    if let Some(reason) = &missing {
        println!("the tests of the emulated firmware are skipped: {reason}");
    }
    let trial = |name: &str, test: fn() -> Result<(), Failed>| {
        Trial::test(name, test).with_ignored_flag(missing.is_some())
    };
    let trials = vec![
        trial("the_emulated_firmware_logs_the_hosts_run_bit_for_bit_in_every_mode", every_mode),
        trial("the_emulated_firmware_logs_the_hosts_run_bit_for_bit_with_every_model", every_model),
        trial("the_emulated_firmware_logs_the_hosts_run_bit_for_bit_with_every_extension", every_extension),
        trial("the_emulated_firmware_repeats_itself_bit_for_bit", repeatable),
        trial("the_emulated_firmware_of_a_joint_reads_back_what_it_was_given_bit_for_bit", joint),
    ];
    libtest_mimic::run(&Arguments::from_args(), trials).exit()
}

/// What is missing for these tests.
fn missing() -> Option<String> {
    if Command::new("qemu-system-arm").arg("--version").output().is_err() {
        return Some("no qemu-system-arm; `cargo xtask setup` installs it".to_owned());
    }
    image::find(None).err().map(|error| error.to_string())
}

/// The log of the emulated firmware's run on the rig.
fn emulated_log(configuration: &Configuration, mode: Mode, reference_mm: &[f64]) -> Result<String, Failed> {
    let mut board = Emulator::start(&image::find(None)?, &Stop::default())?;
    // As the board on the host.
    protect(&mut board, Protection::SIMULATED)?;
    Ok(log(&run(&mut board, &mut Measured(rig(3)), configuration, mode, reference_mm)?))
}

/// A plant on which load and temperature are measured too.
struct Measured<P>(P);

impl<P: Plant> Plant for Measured<P> {
    fn advance(&mut self, time_s: f64, command_bar: f32) -> Result<Measurement, PilError> {
        let surroundings =
            Surroundings { load: Some(20.0 + 5.0 * time_s.sin()), temperature: Some(25.0 + 0.1 * time_s) };
        Ok(Measurement { surroundings, ..self.0.advance(time_s, command_bar)? })
    }
}

/// 8 s that reach both ends of the range and turn in between.
fn reference_mm() -> Vec<f64> {
    raised_cosines(0.0, &[140.0])
        .into_iter()
        .step_by(6)
        .chain((0..4000).map(|k| f64::from(k % 700) / 5.0))
        .collect()
}

/// The controller with the paper's model.
fn paper() -> Result<Configuration, Failed> {
    Ok(configuration(&ModelParameters::Cascade(paper::mgpi()?)))
}

/// Vented, and behind each of the ticks with which it fills both muscles.
fn joint() -> Result<(), Failed> {
    let mut board = Emulator::start_joint(&image::find_which(Which::Joint, None)?, &Stop::default())?;
    let mut ask = |request: &JointRequest| board.request_joint(request);
    let control = joint_set().control.ok_or("a joint")?;
    let settings = JointSettings { protection: joint_set().protection, calibration: joint_calibration() };
    assert_eq!(ask(&JointRequest::Control)?, JointResponse::Control(None));
    assert_eq!(ask(&JointRequest::Settings(Some(settings)))?, JointResponse::Settings(settings));
    let configuration = JointConfiguration { version: JOINT_VERSION, control: control.clone() };
    for request in [JointRequest::Configure(configuration), JointRequest::Arm, JointRequest::Start(40.0)] {
        assert_eq!(ask(&request)?, JointResponse::Accepted, "{request:?}");
    }
    let by = JointScalings::calibrated(&settings.calibration).map_err(|refusal| format!("{refusal:?}"))?;
    for ticks in 1..=20 {
        let [of_a, of_b] = by.pressures;
        let tick = JointTickRequest {
            target: None,
            pressure_codes: [of_a.code(0.0), of_b.code(0.0)],
            angle_code: by.angle.code(0.0),
        };
        assert!(matches!(ask(&JointRequest::Tick(tick))?, JointResponse::Tick(_)));
        let JointResponse::Control(Some(told)) = ask(&JointRequest::Control)? else {
            return Err("no joint".into());
        };
        assert_eq!((&told, fingerprint(&told)), (&control, fingerprint(&control)));
        assert_eq!(ask(&JointRequest::Settings(None))?, JointResponse::Settings(settings));
        let JointResponse::Status(status) = ask(&JointRequest::Status)? else {
            return Err("no status".into());
        };
        assert_eq!((status.report.ticks, status.report.tick.state), (ticks, JointBoardState::Starting));
    }
    Ok(())
}

fn every_mode() -> Result<(), Failed> {
    let (configuration, reference_mm) = (paper()?, reference_mm());
    for mode in [Mode::Both, Mode::FeedforwardOnly, Mode::FeedbackOnly] {
        assert_alike(&format!("{mode:?}"), &configuration, mode, &reference_mm)?;
    }
    Ok(())
}

fn every_model() -> Result<(), Failed> {
    // Every third sample: the tick's arithmetic is what counts here, and an extended model takes
    // many steps.
    let reference_mm: Vec<f64> = reference_mm().into_iter().step_by(3).collect();
    let models = Kind::ALL.map(|model| (model, None)).into_iter().chain([(Kind::Mgpi, Some(12))]);
    for (model, knots) in models {
        let options = Options {
            model,
            knots,
            weights: Weights::Exponential,
            loss: Loss::Squares,
            plays: 10,
            dead_zones: 10,
            starts: 4,
            seed: 1,
            threads: 0,
            tolerance: CONVERGED,
        };
        let configuration = configuration(&identified(&options));
        let name = format!("{model}, knots {knots:?}");
        assert_alike(&name, &configuration, Mode::FeedforwardOnly, &reference_mm)?;
    }
    Ok(())
}

fn every_extension() -> Result<(), Failed> {
    let configuration = Configuration { version: VERSION, tracking: extended_parameters()? };
    for mode in [Mode::Both, Mode::FeedforwardOnly] {
        assert_alike(&format!("every extension, {mode:?}"), &configuration, mode, &reference_mm())?;
    }
    Ok(())
}

/// Holds the emulated firmware against the same library on the host.
fn assert_alike(
    name: &str,
    configuration: &Configuration,
    mode: Mode,
    reference_mm: &[f64],
) -> Result<(), Failed> {
    let host = run(&mut HostBoard::default(), &mut Measured(rig(3)), configuration, mode, reference_mm)?;
    let (host, emulated) = (log(&host), emulated_log(configuration, mode, reference_mm)?);
    if let Some((row, (host, emulated))) =
        host.lines().zip(emulated.lines()).enumerate().find(|(_, (host, emulated))| host != emulated)
    {
        return Err(format!("{name}, row {row}: host {host}, emulated {emulated}").into());
    }
    if host.len() == emulated.len() {
        Ok(())
    } else {
        Err(format!("{name}: the logs differ in length").into())
    }
}

fn repeatable() -> Result<(), Failed> {
    let (configuration, reference_mm) = (paper()?, reference_mm());
    let run = || emulated_log(&configuration, Mode::Both, &reference_mm);
    let (one, other) = (run()?, run()?);
    if one == other { Ok(()) } else { Err("two runs of the emulator differ".into()) }
}
