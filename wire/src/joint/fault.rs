//! What vents a joint, by stable numbers, with cause and cure.
//!
//! A fault that a board with one muscle has, too, has cause and cure of the board's table
//! ([`crate::fault::table`]), but for those that are others at a joint: these stand here, and in
//! `docs/joint.md`.

use core::fmt;

use serde::{Deserialize, Serialize};

use super::Channel;
use crate::Fault;
use crate::fault::table::TABLE;

/// What vents a joint, both muscles at once. Its number is stable ([`Self::code`]).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum JointFault {
    /// Of one channel: a fault of its pressure sensor, its valve or its muscle.
    OfChannel(Channel, Fault),
    /// The angle sensor is open or short.
    AngleSensor,
    /// The angle jumps.
    AngleSpiking,
    /// Of the board as a whole.
    OfBoard(Fault),
    /// The test motion turned the joint the other way.
    WrongWay(Motion),
    /// It hardly turned it.
    Still(Motion),
    /// Each pressure follows the other one's command.
    Crossed,
    /// The swing turned it otherwise than the model's.
    Another(Motion),
    /// The angle stands still while both pressures would turn the joint.
    AngleStuck,
}

/// What a motion of a joint has shown. Unit: rad.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Motion {
    /// From one end to the other, as asked for.
    pub asked: f32,
    /// The same, as it was.
    pub turned: f32,
    /// Where the joint stood from what was asked for, in the mean.
    pub offset: f32,
}

impl JointFault {
    /// The stable number: that of the board's table for a fault of the board, 100 more for one of
    /// channel a, 200 more for one of channel b; from 301 on those of the pair.
    pub const fn code(self) -> u16 {
        match self {
            Self::OfBoard(fault) => fault.code() as u16,
            Self::OfChannel(Channel::A, fault) => 100 + fault.code() as u16,
            Self::OfChannel(Channel::B, fault) => 200 + fault.code() as u16,
            Self::AngleSensor => 301,
            Self::AngleSpiking => 302,
            Self::WrongWay(_) => 303,
            Self::Still(_) => 304,
            Self::Crossed => 305,
            Self::Another(_) => 306,
            Self::AngleStuck => 307,
        }
    }

    /// What is behind it, and what helps.
    pub fn advice(&self) -> Advice {
        match self {
            Self::OfBoard(fault) | Self::OfChannel(_, fault) => {
                let own = OF_JOINTS.iter().find(|(of, _)| of == fault).map(|(_, advice)| *advice);
                let row = || TABLE.iter().find(|row| row.fault == *fault);
                let of_board = || row().map(|row| Advice { cause: row.cause, cure: row.cure });
                own.or_else(of_board).unwrap_or(Advice { cause: "unknown", cure: "unknown" })
            }
            Self::AngleSensor => Advice {
                cause: "a broken wire, a short, the sensor's supply",
                cure: "measure the signal at the plug: 0.05 to 3.25 V are good",
            },
            Self::AngleSpiking => {
                Advice { cause: "interference, a loose magnet", cure: "shield and ground; fasten the magnet" }
            }
            Self::WrongWay(_) => Advice {
                cause: "the angle sensor counts backwards, or both channels are swapped",
                cure: "turn the sensor's sign, or swap the channels",
            },
            Self::Still(_) => Advice {
                cause: "a blocked joint, a sensor that stands still, a muscle without air",
                cure: "look at joint, sensor and supply",
            },
            Self::Crossed => {
                Advice { cause: "pressure sensors or regulators swapped", cure: "swap the plugs" }
            }
            Self::Another(_) => Advice {
                cause: "the model is of another joint, or muscles were changed",
                cure: "`mgpi identify --joint` on a new recording",
            },
            Self::AngleStuck => Advice {
                cause: "the sensor's magnet or shaft is loose, its electronics are defective; a joint that is blocked",
                cure: "turn the vented joint by hand and look at the angle; remove what blocks it",
            },
        }
    }
}

/// What is known of a fault beside its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Advice {
    /// What is behind it.
    pub cause: &'static str,
    /// What helps.
    pub cure: &'static str,
}

/// Faults of a board whose cause or cure is another one at a joint.
const OF_JOINTS: [(Fault, Advice); 11] = [
    (Fault::SupplySensor, SUPPLY),
    (Fault::SupplyLow, SUPPLY),
    (
        Fault::BusSilent,
        Advice {
            cause: "the host's program has ended or hangs, or the cable is out",
            cure: "start it again",
        },
    ),
    (
        Fault::ConfigurationCorrupt,
        Advice { cause: "flash worn out, or written by something else", cure: GIVE_AGAIN },
    ),
    (
        Fault::ConfigurationVersion,
        Advice {
            cause: "the firmware was exchanged for a much older or newer one, or was one for a single muscle",
            cure: GIVE_AGAIN,
        },
    ),
    (
        Fault::CalibrationCorrupt,
        Advice {
            cause: "flash or RAM that loses bits, or something else has written there",
            cure: "acknowledge, and give the settings again (`--settings`): what is measured may be a quarter off until \
                   then",
        },
    ),
    (
        Fault::Authority,
        Advice {
            cause: "a torque from outside that the reference does not tell, or that is too large; an angle sensor \
                    that has slipped or stands still; a muscle that has lost force",
            cure: "tell the torque, or take it away; look at the sensor; identify again",
        },
    ),
    (Fault::Temperature, Advice { cause: "no cooling", cure: "cool it, look for a short" }),
    (Fault::ReferenceVoltage, Advice { cause: "the 3.3 V", cure: "measure the 3.3 V" }),
    (
        Fault::VentIneffective,
        Advice {
            cause: "regulator or amplifier of that channel stuck, exhaust closed",
            cure: "measure the set point: 0 V means the regulator",
        },
    ),
    (
        Fault::OutputStray,
        Advice {
            cause: "PA4 (a) or PA5 (b) short or driven from outside, its 6.8 kΩ missing, the converter",
            cure: "measure the pin, unplug what hangs on it",
        },
    ),
];

/// What helps where nothing, or not all, of what was stored is left.
const GIVE_AGAIN: &str =
    "acknowledge, then `mgpi deploy --joint` with the settings, or `mgpi restore --joint` with a backup";

const SUPPLY: Advice = Advice {
    cause: "the transducer's wire; a supply that is off or too small for two muscles at once",
    cure: "measure PC0; open the supply, or a larger reservoir",
};

impl fmt::Display for JointFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let title = |fault: Fault| {
            let row = TABLE.iter().find(|row| row.fault == fault);
            row.map_or("unknown", |row| row.title)
        };
        let code = self.code();
        match self {
            Self::OfChannel(channel, fault) => {
                write!(f, "fault {code}, channel {channel}: {}", title(*fault))
            }
            Self::OfBoard(fault) => write!(f, "fault {code}: {}", title(*fault)),
            Self::AngleSensor => write!(f, "fault {code}: angle sensor open or short"),
            Self::AngleSpiking => write!(f, "fault {code}: the angle jumps from sample to sample"),
            Self::WrongWay(motion) => write!(
                f,
                "fault {code}: the test motion of {:.1} degrees turned the joint by {:.1} degrees: it turns the \
                 wrong way; the angle sensor counts backwards, or both channels are swapped",
                motion.asked.to_degrees(),
                motion.turned.to_degrees()
            ),
            Self::Still(motion) => write!(
                f,
                "fault {code}: the test motion of {:.1} degrees turned the joint by {:.1} degrees only: is it \
                 blocked, the angle sensor unplugged, or a muscle without air?",
                motion.asked.to_degrees(),
                motion.turned.to_degrees()
            ),
            Self::Crossed => write!(
                f,
                "fault {code}: pressure_a_bar follows command_b_bar, and pressure_b_bar command_a_bar: the two \
                 pressure sensors, or the two regulators, are swapped"
            ),
            Self::AngleStuck => {
                write!(f, "fault {code}: the angle stands still while both pressures would turn the joint")
            }
            Self::Another(motion) => write!(
                f,
                "fault {code}: the joint turns by {:.1} degrees where its model turns by {:.1} degrees, and stands \
                 {:.1} degrees from it in the mean: the model is that of another joint, or of other muscles",
                motion.turned.to_degrees(),
                motion.asked.to_degrees(),
                motion.offset.to_degrees()
            ),
        }
    }
}

impl core::error::Error for JointFault {}

#[cfg(test)]
mod tests {
    extern crate std;

    use std::format;
    use std::string::ToString;
    use std::vec::Vec;

    use super::*;

    const STILL: Motion = Motion { asked: 1.0, turned: 0.0, offset: 0.0 };
    /// Those that only a pair of muscles has.
    const PAIR: [JointFault; 7] = [
        JointFault::AngleSensor,
        JointFault::AngleSpiking,
        JointFault::WrongWay(STILL),
        JointFault::Still(STILL),
        JointFault::Crossed,
        JointFault::Another(STILL),
        JointFault::AngleStuck,
    ];

    /// The page has a table of its own, by hand: what a program says has to stand there.
    #[test]
    fn the_page_has_cause_and_cure_of_every_fault_that_is_a_joints_own() {
        let page = include_str!("../../../docs/joint.md");
        let of_joints = OF_JOINTS
            .iter()
            .flat_map(|(fault, _)| [JointFault::OfBoard(*fault), JointFault::OfChannel(Channel::A, *fault)]);
        for fault in of_joints.chain(PAIR) {
            let Advice { cause, cure } = fault.advice();
            let row = format!("| {cause} | {cure} |");
            assert!(page.contains(&row), "{fault}: docs/joint.md lacks {row}");
        }
        let leak = JointFault::OfChannel(Channel::B, Fault::Leak).advice();
        assert!(TABLE.iter().any(|row| (row.fault, row.cause) == (Fault::Leak, leak.cause)));
    }

    #[test]
    fn every_fault_of_a_joint_has_a_number_of_its_own() {
        let mut codes: Vec<u16> =
            Fault::ALL.into_iter().map(|fault| JointFault::OfBoard(fault).code()).collect();
        for channel in Channel::BOTH {
            codes.extend(Fault::ALL.map(|fault| JointFault::OfChannel(channel, fault).code()));
        }
        codes.extend(PAIR.map(JointFault::code));
        let all = codes.len();
        codes.sort_unstable();
        codes.dedup();
        assert_eq!(codes.len(), all);
        assert!(PAIR.iter().all(|fault| fault.to_string().starts_with(&format!("fault {}", fault.code()))));
    }
}
