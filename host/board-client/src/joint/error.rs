//! Why a board of a joint at a serial port does not do what it is asked for.

use std::path::PathBuf;

use thiserror::Error;
use wire::Refusal;
use wire::joint::fault::Advice;
use wire::joint::{JOINT_VERSION, JointBoardState, JointFault};

use crate::bus::error::other;
use crate::bus::port::PortError;
use crate::part::PartError;
use crate::pil;

/// Why a board of a joint does not do what it is asked for.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the messages say what the variants and their fields are")]
pub enum JointBoardError {
    #[error(transparent)]
    Port(#[from] PortError),
    #[error(
        "{}: no answer within {limit_s} s, asked {tries} times: is the board powered, is this its service link (USART2, \
         {baud} bit/s), are TX and RX crossed?", port.display()
    )]
    Silent { port: PathBuf, limit_s: f64, tries: usize, baud: u32 },
    #[error("{}: damaged answers only: is the rate {baud} bit/s, is there noise on the link?", port.display())]
    Damaged { port: PathBuf, baud: u32 },
    #[error(
        "{}: a board with one muscle answers; a joint needs the image stm32f405_joint, for two channels: without --joint \
         mgpi speaks to this board over its bus", .0.display()
    )]
    OneMuscle(PathBuf),
    #[error("{}: a board of a joint answers what was not asked", .0.display())]
    OutOfTurn(PathBuf),
    #[error(
        "the board speaks version {board} of a joint's messages, this program version {JOINT_VERSION}: {}",
        other(*.board, JOINT_VERSION)
    )]
    Version { board: u16 },
    #[error("the board refuses: {}", pil::in_words(.0))]
    Refused(Refusal),
    #[error(
        "the board is in the state {0:?}: it is driven, or was until just now. One whose host is gone vents within half \
         a second"
    )]
    State(JointBoardState),
    #[error("the board is at fault since before: {}\n  then: --acknowledge", in_full(.0))]
    AtFault(JointFault),
    #[error("only power-off ends it: {}", in_full(.0))]
    ForGood(JointFault),
    #[error("{time_s:.3} s after the start the board has vented the joint: {}\n  then: --acknowledge", in_full(.fault))]
    Fault { time_s: f64, fault: JointFault },
    #[error("the board has vented by itself, in the state {0:?}: was it restarted?")]
    Vented(JointBoardState),
    #[error("the board's ticks stand still: is it an emulator, whose ticks come over its link?")]
    StandsStill,
    #[error(
        "the board has other limits and lines of its sensors than it was given: is another program at its link?"
    )]
    OtherSettings,
    #[error(
        "the board has another joint than the one that was sent: is another program at its link? Deploy it again"
    )]
    NotInstalled,
    #[error(
        "what the board was given is in use, but its flash has not kept it: it is lost when power is. The board may start \
         with what it had before; after a second failure replace the board"
    )]
    NotStored,
    #[error(
        "the board cannot read its joint back: what it has kept is not what it runs. Deploy the joint again"
    )]
    NotReadBack,
    #[error(
        "the backup is of a board without a joint; one that has a joint keeps it: nothing has been changed"
    )]
    NoJointToRestore,
    #[error(
        "{0}; limits and calibration, or the joint, may already be those of the backup: restore it again"
    )]
    HalfRestored(Box<Self>),
    #[error("the board has not tried the joint within {0} s")]
    NotStarted(f64),
    #[error(transparent)]
    Growing(#[from] PartError),
    #[error("interrupted; both muscles are vented")]
    Stopped,
}

/// A fault with its number, cause and cure.
fn in_full(fault: &JointFault) -> String {
    let Advice { cause, cure } = fault.advice();
    format!("{fault}\n  cause: {cause}\n  cure: {cure}")
}
