//! Joints of the rig, identified and controlled as `mgpi` does: what their control comes to.

use std::f64::consts::{PI, TAU};
use std::path::Path;

use anyhow::{Context, Result};
use board_client::joint::{
    JointBoard, JointMeasured, JointPlant, JointSample, JointWanted, Loop, parameters,
};
use board_client::pil::PilError;
use board_client::stop::Stop;
use firmware::joint::lock_step::LockStepJoint;
use identification::joint::{SWING_RAD, identify_joint};
use recording::Choice;
use recording::joint::columns::JointRecording;
use recording::joint::file::JointFile;
use recording::table::Table;
use rig::joint::JointPlant as RigJoint;
use rig::joint::protocol::JointProtocol;
use rig::joint::recording::{RATE_HZ, record};
use wire::Protection;
use wire::joint::{JointRequest, JointResponse};

/// The controller's tick, as on a board: 1 kHz. Unit: s.
const PERIOD_S: f64 = 1e-3;
/// The reference's amplitude, as a share of the range of angles: 70 % of it are crossed, with room
/// for overshoot at both ends.
const AMPLITUDE: f64 = 0.35;
/// Levels of the stiffness, as shares of what the joint can do in the middle, and how long each
/// lasts (Unit: s): the fastest change of the stiffness through its range, 1.5 s, and as long at rest.
const LEVELS: [f64; 8] = [0.2, 0.8, 0.4, 0.65, 0.2, 0.5, 0.8, 0.3];
const LEVEL_S: f64 = 3.0;

/// The control code of two channels on the host, as the image has it.
pub struct HostJoint(LockStepJoint);

impl HostJoint {
    /// A board without a joint.
    pub fn new(protection: Protection) -> Self {
        Self(LockStepJoint::new(protection))
    }
}

impl JointBoard for HostJoint {
    fn request(&mut self, request: &JointRequest) -> Result<JointResponse, PilError> {
        Ok(self.0.answer(request))
    }
}

/// A joint of the rig as the control code sees it.
pub struct Wired {
    joint: RigJoint,
    last_s: f64,
    /// What the angle sensor has said last.
    last_deg: f64,
    /// What is wrong with the wiring.
    pub wrong: Wrong,
}

/// What can be wrong with the wiring of a joint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrong {
    /// Nothing.
    #[default]
    Nothing,
    /// The angle sensor counts backwards.
    Angle,
    /// Regulators and pressure sensors of both muscles are swapped.
    Channels,
    /// The pressure sensors are.
    Sensors,
    /// The angle sensor goes on with what it said last; at first that is 0 degrees.
    Frozen,
}

impl Wired {
    /// The joint of a seed.
    pub fn new(seed: u64, wrong: Wrong) -> Self {
        Self { joint: RigJoint::new(seed, true), last_s: 0.0, last_deg: 0.0, wrong }
    }

    /// Puts a torque (N m) on the joint from now on, towards larger angles.
    pub fn put_on(&mut self, load_nm: f64) {
        self.joint.put_on(load_nm);
    }
}

impl JointPlant for Wired {
    fn advance(&mut self, time_s: f64, commands_bar: [f32; 2]) -> Result<JointMeasured, PilError> {
        let swap = |[a, b]: [f64; 2], wrong: Wrong| if self.wrong == wrong { [b, a] } else { [a, b] };
        let commands = swap(commands_bar.map(f64::from), Wrong::Channels);
        let step_s = time_s - self.last_s;
        let measured = self.joint.step(commands, step_s);
        let pressures = swap(swap(measured.pressures_bar, Wrong::Channels), Wrong::Sensors);
        self.last_s = time_s;
        let angle_deg = match self.wrong {
            Wrong::Angle => -measured.angle_deg,
            Wrong::Frozen => self.last_deg,
            _ => measured.angle_deg,
        };
        self.last_deg = angle_deg;
        Ok(JointMeasured { pressures_bar: pressures, angle_deg })
    }
}

/// The recording of a joint as CSV.
///
/// # Errors
/// It cannot be written to memory.
pub fn csv(seed: u64) -> Result<Vec<u8>> {
    let mut csv = Vec::new();
    record(&mut csv, &[], &JointProtocol::new(seed), &mut RigJoint::new(seed, true), RATE_HZ)?;
    Ok(csv)
}

/// A recording from CSV.
///
/// # Errors
/// It is not a recording of a joint.
pub fn recording(csv: &[u8]) -> Result<JointRecording> {
    Ok(JointRecording::of(&Table::parse(Path::new("joint.csv"), csv)?, &Choice::default())?)
}

/// The joint of a seed, identified.
///
/// # Errors
/// It cannot be.
pub fn identified(seed: u64) -> Result<JointFile> {
    let found = identify_joint(&recording(&csv(seed)?)?, SWING_RAD);
    Ok(found.with_context(|| format!("seed {seed}"))?.file)
}

/// What the control of a joint came to.
#[derive(Clone, Debug)]
pub struct Tried {
    /// Error of the angle that an exact sensor would see, at each frequency asked for. Unit: % of
    /// range.
    pub rmse_percent: Vec<f64>,
    /// Largest error of the stiffness, while the angle follows and while it stands still, where the
    /// bounds allow the stiffness. Unit: %.
    pub stiffness_percent: f64,
    /// Largest error of the angle while the stiffness steps. Unit: % of range.
    pub cross_talk_percent: f64,
    /// Least tension of a tendon, behind the start. Unit: N.
    pub slackest_n: f64,
    /// Lowest and highest command.
    pub commands_bar: (f64, f64),
    /// In how many of all ticks a bound kept the angle, or the stiffness, from what was asked for.
    pub limited: (usize, usize),
}

/// Identifies the joint of a seed, and controls it: cosines of the frequencies (Hz) at half of the
/// stiffness, then steps of the stiffness at rest in the middle.
///
/// # Errors
/// The joint is not identified, or not started.
pub fn tried(seed: u64, frequencies_hz: &[f64]) -> Result<Tried> {
    let file = identified(seed)?;
    let parameters = parameters(&file.parameters, PERIOD_S)?;
    let (lowest, highest) = file.parameters.angles;
    let (middle, range) = (0.5 * (lowest + highest), highest - lowest);
    let (soft, stiff) = file.joint.stiffness_range(middle);
    let at = |share: f64| soft + share * (stiff - soft);
    let degrees = |rad: f64| rad * 180.0 / PI;
    let mut tried = Tried {
        rmse_percent: Vec::new(),
        stiffness_percent: 0.0,
        cross_talk_percent: 0.0,
        slackest_n: f64::INFINITY,
        commands_bar: (f64::INFINITY, f64::NEG_INFINITY),
        limited: (0, 0),
    };
    let mut run =
        |wanted: &dyn Fn(f64) -> JointWanted, duration_s: f64, every: usize| -> Result<(f64, f64)> {
            let mut plant = Wired::new(seed, Wrong::Nothing);
            // As on a board with muscles: what protects them must not disturb sound control.
            let mut board = HostJoint::new(Protection::STANDARD);
            let mut joint = Loop::new((&parameters, None), &mut board, &mut plant, Stop::default())?;
            joint.start(&wanted(0.0))?;
            joint.approach(&wanted(0.0))?;
            let ticks = (duration_s / PERIOD_S).round() as usize;
            let (mut squares, mut largest, mut tick) = (0.0, 0.0_f64, 0);
            let look = |sample: &JointSample, plant: &Wired| {
                // The plant is a tick further than the sample.
                let now = wanted((tick + 1) as f64 * PERIOD_S);
                let error = plant.joint.exact_deg() - now.angle_deg;
                squares += error * error;
                largest = largest.max(error.abs());
                let [a, b] = plant.joint.tensions_n();
                tried.slackest_n = tried.slackest_n.min(a).min(b);
                let (low, high) = &mut tried.commands_bar;
                for command in sample.commands_bar.map(f64::from) {
                    (*low, *high) = (low.min(command), high.max(command));
                }
                tried.limited.0 += usize::from(sample.reply.is_limited);
                tried.limited.1 += usize::from(!sample.reply.is_as_stiff);
                if (tick + 1) % every == 0 && sample.reply.is_as_stiff {
                    let ratio =
                        plant.joint.stiffness_nm_per_rad(SWING_RAD) / f64::from(sample.reply.stiffness);
                    tried.stiffness_percent = tried.stiffness_percent.max(100.0 * (ratio - 1.0).abs());
                }
                tick += 1;
            };
            joint.follow((0..ticks).map(|tick| wanted(tick as f64 * PERIOD_S)), look)?;
            Ok(((squares / ticks as f64).sqrt(), largest))
        };
    let percent = |deg: f64| 100.0 * deg / degrees(range);
    let mut rmse_percent = Vec::new();
    for frequency_hz in frequencies_hz {
        let angle = |time_s: f64| middle + AMPLITUDE * range * (TAU * frequency_hz * time_s).cos();
        let wanted =
            |time_s| JointWanted { angle_deg: degrees(angle(time_s)), stiffness: at(0.5), torque_nm: 0.0 };
        let (rmse, _) = run(&wanted, 2.0 / frequency_hz, 250)?;
        rmse_percent.push(percent(rmse));
    }
    let level = |time_s: f64| LEVELS[((time_s / LEVEL_S) as usize).min(LEVELS.len() - 1)];
    let wanted = |time_s| {
        let (angle_deg, stiffness) = (degrees(middle), at(level(time_s)));
        JointWanted { angle_deg, stiffness, torque_nm: 0.0 }
    };
    // A stiffness is looked at when it has been reached.
    let (_, largest) = run(&wanted, LEVEL_S * LEVELS.len() as f64, (LEVEL_S / PERIOD_S) as usize)?;
    let cross_talk_percent = percent(largest);
    Ok(Tried { rmse_percent, cross_talk_percent, ..tried })
}
