//! Identification of a joint of two muscles, from a recording of both pressures, the angle and a
//! known torque, by the balance of torques.
//!
//! # Design
//! | file | what it does |
//! |---|---|
//! | `check` | whether the recording is a joint's, and enough of one |
//! | `slack` | rows in which a muscle was slack, which are left out |
//! | `bounds` | the lowest pressures, and the regulators' time constants |
//! | `unknowns` | a joint's parameters as a list, and what each does to the torque |
//! | `balance` | least squares of the torque, with knees and slips searched |
//! | `simulate` | the angle that a joint answers with |
//! | `refine` | Gauss-Newton on the simulated angle |
//! | `known` | standard errors of the parameters and of the stiffness |
//!
//! The torque of a joint ([`model_core::joint`]) is linear in all unknowns but two knees and two
//! slips, so that the balance is one linear problem, with friction kept from being negative. What
//! comes of it answers for the torque at the *measured* angle; the refinement is for the angle that
//! is simulated from the pressures alone, which is what a controller relies on.
//!
//! # Limits
//! Inertia is taken to be nothing: a recording has to be slow.

mod balance;
mod bounds;
mod check;
mod known;
mod refine;
mod simulate;
mod slack;
mod unknowns;

use std::f64::consts::PI;
use std::fmt;

use model_core::ParameterError;
use recording::joint::columns::JointRecording;
use recording::joint::file::JointFile;

use check::Sign;
pub use known::{JointEstimate, JointKnown};
pub use slack::{Slack, without_slack};

/// Number of stops.
const STOPS: usize = 8;
/// The shortest stop as a share of the range of angles; the longest is half of it.
const SHORTEST: f64 = 0.01;
/// Half the swing that a stiffness is for, unless the user has it otherwise. Unit: rad.
pub const SWING_RAD: f64 = 3.0 * PI / 180.0;
/// The refinement, and what is known after it, look at every Nth row.
const THINNED: usize = 4;
/// Rows are held out in blocks so long, shorter in a short recording, one of [`BLOCKS`]. Unit: s.
const BLOCK_S: f64 = 8.0;
/// See [`BLOCK_S`].
const BLOCKS: usize = 5;
/// A recording has at least so many blocks, so that none that is held out is all of a weight.
const LEAST_BLOCKS: usize = 4 * BLOCKS;

/// Why no joint can be identified.
#[derive(Debug)]
#[allow(missing_docs, reason = "the messages say what the variants and their fields are")]
pub enum JointError {
    TooFewRows { rows: usize, needed: usize },
    Still { what: &'static str, span: f64, least: f64, unit: &'static str },
    Signs([Sign; 3]),
    Singular,
    NotFollowing(&'static str),
    Invalid(ParameterError),
}

impl fmt::Display for JointError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooFewRows { rows, needed } => {
                write!(f, "{rows} rows count, at least {needed} are needed: record longer")
            }
            Self::Still { what, span, least, unit } => write!(
                f,
                "{what} moves by {span:.3} {unit} only, at least {least} {unit} are needed{}",
                match *what {
                    "torque_newton_metre" =>
                        ": without a known torque a recording does not tell how strong a joint is; hang a weight \
                         at it for a part of the recording, and write its torque",
                    "the sum of both pressures" =>
                        ": without it a recording does not tell how the stiffness changes",
                    _ => "",
                }
            ),
            Self::Signs(signs) => check::explain(signs, f),
            Self::Singular => write!(f, "the recording does not tell the parameters apart: record more"),
            Self::NotFollowing(column) => {
                write!(f, "{column} does not go towards its command: are two columns swapped?")
            }
            Self::Invalid(error) => write!(f, "what was found is no joint: {error}"),
        }
    }
}

impl std::error::Error for JointError {}

impl From<ParameterError> for JointError {
    fn from(error: ParameterError) -> Self {
        Self::Invalid(error)
    }
}

/// An identified joint.
#[derive(Clone, Debug)]
pub struct IdentifiedJoint {
    /// The model with its figures.
    pub file: JointFile,
    /// What is known about it.
    pub known: JointKnown,
    /// The angle that it answers the recording with, a value a row. Unit: rad.
    pub simulated_rad: Vec<f64>,
    /// The same of a model that has not seen the rows held out.
    pub heldout_rad: Vec<f64>,
    /// Which rows that count were held out from that one.
    pub unseen: Vec<bool>,
}

/// Identifies a joint from the rows in which no muscle was slack. `swing_rad`: half the swing that
/// its stiffness is for.
///
/// # Errors
/// See [`JointError`].
pub fn identify_joint(recording: &JointRecording, swing_rad: f64) -> Result<IdentifiedJoint, JointError> {
    check::check(recording)?;
    let slack = slack::find(recording)?;
    let recording = &without_slack(recording, &slack);
    let rows = balance::Rows::of(recording, swing_rad)?;
    let (time_s, scored) = (&recording.time_s, &recording.scored);
    let counted = || time_s.iter().zip(scored).filter(|(_, scored)| **scored).map(|(time_s, _)| *time_s);
    let first_s = counted().fold(f64::INFINITY, f64::min);
    let last_s = counted().fold(f64::NEG_INFINITY, f64::max);
    let block_s = BLOCK_S.min((last_s - first_s) / LEAST_BLOCKS as f64);
    let is_held_out = |time_s: &f64| ((time_s - first_s).max(0.0) / block_s) as usize % BLOCKS == BLOCKS - 1;
    let held_out: Vec<bool> = time_s.iter().map(is_held_out).collect();
    let seen: Vec<bool> = scored.iter().zip(&held_out).map(|(scored, held)| *scored && !held).collect();
    let unseen: Vec<bool> = scored.iter().zip(&held_out).map(|(scored, held)| *scored && *held).collect();

    let trial = rows.joint(&refine::refined(&rows, &seen, balance::solve(&rows, &seen)?)?)?;
    let found = refine::refined(&rows, scored, balance::solve(&rows, scored)?)?;
    let simulated = |joint| simulate::simulate(&rows, scored, joint);
    let (simulated_rad, heldout_rad) = (simulated(&rows.joint(&found)?), simulated(&trial));
    let rmse = simulate::rmse(&rows, scored, &simulated_rad);
    let heldout_rmse = simulate::rmse(&rows, &unseen, &heldout_rad);
    let count = scored.iter().filter(|scored| **scored).count();
    let degrees = |rad: f64| rad * 180.0 / PI;
    let figures = (degrees(rmse), degrees(heldout_rmse));
    let file = JointFile::new(rows.parameters(&found), recording.source.clone(), count, figures)?;
    let known = JointKnown::new(&rows, scored, &found, slack)?;
    Ok(IdentifiedJoint { file, known, simulated_rad, heldout_rad, unseen })
}
