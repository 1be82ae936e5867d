//! What the numbers in registers of orders and answers stand for.

use model_core::Mode;

use crate::State;

/// Gives each variant of an enumeration its number, and finds it by that.
macro_rules! numbered {
    ($(#[$doc:meta])* $name:ident { $($(#[$of:meta])* $variant:ident = $number:literal,)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[repr(u16)]
        pub enum $name { $($(#[$of])* $variant = $number,)* }

        impl $name {
            /// All of them.
            pub const ALL: &[Self] = &[$(Self::$variant),*];

            /// The one with a number.
            pub const fn of_number(number: u16) -> Option<Self> {
                match number {
                    $($number => Some(Self::$variant),)*
                    _ => None,
                }
            }

            /// Its number.
            pub const fn number(self) -> u16 {
                self as u16
            }
        }
    };
}

numbered! {
    /// Why a request is refused: the exception codes of Modbus that the board uses.
    Exception {
        /// There is no such function here.
        IllegalFunction = 1,
        /// A register does not exist, or is only read.
        IllegalAddress = 2,
        /// A value is out of its limits, not finite, or half of a pair; a length does not fit.
        IllegalValue = 3,
        /// The board cannot carry it out.
        DeviceFailure = 4,
        /// The board's state does not allow it now.
        DeviceBusy = 6,
    }
}

numbered! {
    /// What is done with what is learnt of the muscle.
    Learning {
        /// Nothing is learnt; what was is forgotten.
        Off = 0,
        /// The feed-forward follows the muscle.
        On = 1,
        /// What was learnt stays, and nothing is learnt.
        Kept = 2,
    }
}

numbered! {
    /// The orders of the command word.
    Command {
        /// Nothing; for a PLC that writes its outputs all the time.
        None = 0,
        /// Start tracking from rest, or go on from holding, in the mode of the register `mode`.
        Start = 1,
        /// Stop and vent.
        Stop = 2,
        /// Hold the last command of the controller; a start goes on.
        Hold = 3,
        /// Release the latched fault, test the board again.
        Acknowledge = 4,
        /// Enter the service state, valve vented: `setpoint_bar` and the stream then drive it
        /// without a controller.
        Service = 5,
        /// The first of the two steps by which a valve is opened: start or service have to follow.
        Arm = 6,
    }
}

numbered! {
    /// What to do with the stream of set points.
    StreamOrder {
        /// Forget all points, and play nothing.
        Clear = 0,
        /// Play from the next tick on.
        Play = 1,
        /// No more points will come: the end is no underrun.
        End = 2,
    }
}

numbered! {
    /// What the stream of set points does.
    StreamState {
        /// Waits for points and the order to play.
        Idle = 0,
        /// Plays.
        Playing = 1,
        /// Has run out of points, and holds the last one.
        Underrun = 2,
        /// Has played the last point, and holds it.
        Done = 3,
    }
}

numbered! {
    /// What to do with the upload's buffer.
    UploadOrder {
        /// Nothing.
        None = 0,
        /// Check the first `upload_length` bytes, install the configuration that they are, and
        /// store it.
        Commit = 1,
        /// Fill the buffer with the installed configuration; sets length and checksum.
        Fetch = 2,
    }
}

numbered! {
    /// What has become of the last commit.
    UploadResult {
        /// There was none since the start.
        None = 0,
        /// Installed, and stored where the board has a store.
        Installed = 1,
        /// Length or checksum do not fit what has arrived.
        Checksum = 2,
        /// The bytes are no configuration.
        Unreadable = 3,
        /// It is one of another version of the messages.
        Version = 4,
        /// A parameter is not valid, or exceeds what is compiled into the board; `message` says
        /// which.
        Parameter = 5,
        /// Refused in this state.
        WrongState = 6,
        /// Installed until power is lost: the flash has not kept it.
        NotStored = 7,
    }
}

numbered! {
    /// What to do with the image in the place that does not run.
    UpdateOrder {
        /// Nothing.
        None = 0,
        /// Begin: what stands there counts no more, and is written afresh.
        Begin = 1,
        /// Look at what was written, and try it at the next start.
        Take = 2,
        /// Start again, behind the answer.
        Restart = 3,
    }
}

numbered! {
    /// What has become of the last order to take an image.
    UpdateResult {
        /// There was none since the last begin.
        None = 0,
        /// It is tried at the next start.
        Taken = 1,
        /// It is not whole: no head, a length or a checksum that does not fit.
        NotWhole = 2,
        /// It is for a board of another kind or revision.
        OtherBoard = 3,
        /// It is linked for the other place.
        OtherPlace = 4,
        /// It is older than the one that runs, and `update_older` was not written with the order.
        Older = 5,
        /// Its signature is not by the key that this board has.
        Signature = 6,
        /// The flash has not kept that it is to be tried.
        NotStored = 7,
    }
}

numbered! {
    /// Whether the image that runs is there to stay.
    UpdateTrial {
        /// It is.
        ForGood = 0,
        /// It has to show first that it runs.
        OnTrial = 1,
        /// The other one was tried, and has not shown it.
        RolledBack = 2,
        /// The other one is tried at the next start.
        Waits = 3,
    }
}

numbered! {
    /// By what the board listens on the bus.
    BusListens {
        /// What it keeps.
        Stored = 0,
        /// What it kept at its start; it takes the new at the next.
        Former = 1,
        /// The line of a new board, since nobody was heard by its own.
        Standard = 2,
    }
}

/// The mode with a number: 0 both, 1 feed-forward, 2 feedback.
pub const fn mode(number: u16) -> Option<Mode> {
    match number {
        0 => Some(Mode::Both),
        1 => Some(Mode::FeedforwardOnly),
        2 => Some(Mode::FeedbackOnly),
        _ => None,
    }
}

/// The number of a mode; 3 for the held command.
pub const fn mode_number(mode: Mode) -> u16 {
    match mode {
        Mode::Both => 0,
        Mode::FeedforwardOnly => 1,
        Mode::FeedbackOnly => 2,
        Mode::Hold => 3,
    }
}

/// The state with a number, its place in [`State::ALL`].
pub fn state(number: u16) -> Option<State> {
    State::ALL.get(usize::from(number)).copied()
}

/// The number of a state.
pub fn state_number(state: State) -> u16 {
    State::ALL.iter().position(|other| *other == state).unwrap_or(0) as u16
}
