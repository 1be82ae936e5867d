//! A board with two channels on a desk: its service link on a pseudo terminal, the rig's joint at
//! its valves, and `mgpi` in a directory of its own.
//!
//! # Time
//! Where a test is of what a board does by itself, time passes as on a wall ([`Time::Real`]). Else
//! each request takes so many ticks, as if the link were that slow ([`Time::Requests`]): long runs
//! are short then, and go the same way however busy the machine is.

use std::io::{ErrorKind, Read, Write};
use std::ops::Deref;
use std::sync::{Arc, Mutex, MutexGuard};
use std::thread::{self, JoinHandle};
use std::time::Instant;

use board_client::emulator::real_time::PERIOD;
use board_client::emulator::terminal::PseudoTerminal;
use board_client::joint::{JointMeasured, JointPlant};
use board_client::stop::Stop;
use firmware::joint::ANGLE;
use firmware::scaling::{COMMAND, PRESSURE};
use fleet::board::Board;
use fleet::line::Way;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use serde::Serialize;
use wire::joint::{JointRequest, JointResponse, JointTickReply, JointTickRequest};
use wire::registers::UNIT;
use wire::{FRAME_BYTES, Protection, Receiver, Refusal, Request, Response};

use crate::PERIOD_S;
use crate::commands::Commands;
use crate::flash::{MockFlash, Tear};
use crate::joint::{Wired, Wrong};
use crate::kept_joint::KeptJoint;

/// How time passes at a board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Time {
    /// As on a wall.
    Real,
    /// So many ticks a request.
    Requests(u32),
}

/// What is on a desk.
#[derive(Clone, Copy, Debug)]
pub struct Setting {
    /// Of the joint.
    pub seed: u64,
    /// What is wrong with its wiring.
    pub wrong: Wrong,
    /// Torque from outside. Unit: N m.
    pub load_nm: f64,
    /// How time passes.
    pub time: Time,
    /// Which version of the messages the board says it has; none: its own.
    pub version: Option<u16>,
    /// The board's ticks stand still.
    pub is_still: bool,
    /// The board is one with one muscle.
    pub is_single: bool,
    /// With which requests the board has just started again.
    pub restarts_at: &'static [u32],
    /// What stands at the beginning of the board's flash.
    pub stored: &'static [u8],
    /// The flash keeps nothing.
    pub is_worn: bool,
    /// No joint is taken from the second one on.
    pub takes_one: bool,
}

impl Setting {
    /// The joint of a seed, sound; each request takes 4 ticks.
    pub fn sound(seed: u64) -> Self {
        Self {
            seed,
            wrong: Wrong::Nothing,
            load_nm: 0.0,
            time: Time::Requests(4),
            version: None,
            is_still: false,
            is_single: false,
            restarts_at: &[],
            stored: &[],
            is_worn: false,
            takes_one: false,
        }
    }
}

/// What is seen of a board from outside.
#[derive(Clone, Copy, Debug, Default)]
pub struct Seen {
    /// The last tick.
    pub last: Option<JointTickReply>,
    /// Its number.
    pub ticks: u32,
    /// When the last request came. Unit: tick.
    pub heard: u32,
    /// When both valves were vented last. Unit: tick.
    pub vented: u32,
    /// The highest code that either valve has had, since the desk was made.
    pub highest_code: u16,
    /// Requests.
    pub requests: u32,
}

/// What is at a link.
trait AtLink {
    /// A tick.
    fn tick(&mut self);
    /// Takes a byte; the answer, if a request is complete by it.
    fn push(&mut self, byte: u8) -> Option<Vec<u8>>;
}

/// The control code of two channels and a joint.
struct JointAtLink {
    board: KeptJoint,
    plant: Wired,
    measured: JointMeasured,
    receiver: Receiver,
    /// Joints that were sent.
    joints: u32,
    setting: Setting,
    seen: Arc<Mutex<Seen>>,
}

impl JointAtLink {
    fn new(setting: Setting, seen: Arc<Mutex<Seen>>) -> Self {
        let mut plant = Wired::new(setting.seed, setting.wrong);
        plant.put_on(setting.load_nm);
        let measured = plant.advance(0.0, [0.0; 2]).expect("the rig answers");
        let mut board = KeptJoint::start(MockFlash::with(setting.stored));
        if setting.is_worn {
            board.flash().cut_after(0, Tear::Rising, 0);
        }
        Self { board, plant, measured, receiver: Receiver::new(), joints: 0, setting, seen }
    }
}

impl AtLink for JointAtLink {
    fn tick(&mut self) {
        if self.setting.is_still {
            return;
        }
        let JointMeasured { pressures_bar, angle_deg } = self.measured;
        let board = &mut self.board.board;
        board.feed(&JointTickRequest {
            target: None,
            pressure_codes: pressures_bar.map(|bar| PRESSURE.code(bar as f32)),
            angle_code: ANGLE.code(angle_deg.to_radians() as f32),
        });
        let reply = board.tick();
        let ticks = board.task().ticks();
        let commands = reply.dac_codes.map(|code| COMMAND.value(code));
        self.measured = self.plant.advance(f64::from(ticks) * PERIOD_S, commands).expect("the rig answers");
        let mut seen = lock(&self.seen);
        let was_driven = seen.last.is_some_and(|last| last.dac_codes != [0; 2]);
        let Seen { vented, highest_code, .. } = &mut *seen;
        if was_driven && reply.dac_codes == [0; 2] {
            *vented = ticks;
        }
        *highest_code = reply.dac_codes.into_iter().fold(*highest_code, u16::max);
        (seen.last, seen.ticks) = (Some(reply), ticks);
    }

    fn push(&mut self, byte: u8) -> Option<Vec<u8>> {
        let received = self.receiver.push::<JointRequest>(byte)?;
        // The last one behind the answer: what was asked for acts.
        let ticks = if let Time::Requests(ticks) = self.setting.time { ticks } else { 0 };
        (1..ticks).for_each(|_| self.tick());
        let mut seen = lock(&self.seen);
        (seen.heard, seen.requests) = (seen.ticks, seen.requests + 1);
        let restarts = self.setting.restarts_at.contains(&seen.requests);
        drop(seen);
        if restarts {
            self.board = KeptJoint::start(self.board.flash().clone());
        }
        let response = match received {
            Ok(JointRequest::Tick(_)) => JointResponse::Refused(Refusal::NotHere),
            Ok(JointRequest::Configure(_)) if self.setting.takes_one && self.joints > 0 => {
                JointResponse::Refused(Refusal::parameter(format_args!("no room for another joint")))
            }
            Ok(request @ JointRequest::Configure(_)) => {
                self.joints += 1;
                self.board.answer(&request)
            }
            Ok(request) => self.board.answer(&request),
            Err(_) => JointResponse::Refused(Refusal::Unreadable),
        };
        let response = match (response, self.setting.version) {
            (JointResponse::Hello(hello), Some(version)) => {
                JointResponse::Hello(wire::joint::JointHello { version, ..hello })
            }
            (response, _) => response,
        };
        if ticks > 0 {
            self.tick();
        }
        Some(framed(&response))
    }
}

/// A board with one muscle, by the same frames.
struct SingleAtLink {
    board: Board,
    receiver: Receiver,
}

impl AtLink for SingleAtLink {
    fn tick(&mut self) {}

    fn push(&mut self, byte: u8) -> Option<Vec<u8>> {
        let received = self.receiver.push::<Request>(byte)?;
        let unreadable = Response::Refused(Refusal::Unreadable);
        Some(framed(&received.map_or(unreadable, |request| self.board.request(&request))))
    }
}

fn framed(response: &impl Serialize) -> Vec<u8> {
    let mut buffer = [0; FRAME_BYTES];
    wire::encode(response, &mut buffer).expect("a frame").to_vec()
}

fn lock(seen: &Mutex<Seen>) -> MutexGuard<'_, Seen> {
    seen.lock().expect("the board has not panicked")
}

/// A board at a terminal, and a directory for `mgpi`, until it is dropped.
#[derive(Debug)]
pub struct JointDesk {
    stop: Stop,
    board: Option<JoinHandle<()>>,
    seen: Arc<Mutex<Seen>>,
    commands: Commands,
}

impl JointDesk {
    /// A board whose link is sound.
    ///
    /// # Panics
    /// There is no pseudo terminal.
    pub fn new(setting: Setting) -> Self {
        Self::disturbed(setting, |_, bytes| bytes)
    }

    /// The same on a link whose bytes `disturb` may change.
    ///
    /// # Panics
    /// There is no pseudo terminal.
    pub fn disturbed(
        setting: Setting,
        disturb: impl FnMut(Way, Vec<u8>) -> Vec<u8> + Send + 'static,
    ) -> Self {
        let terminal = PseudoTerminal::open().expect("a pseudo terminal");
        let commands = Commands::at(terminal.path());
        let (stop, seen) = (Stop::default(), Arc::default());
        let (stopped, told) = (stop.clone(), Arc::clone(&seen));
        let board = thread::spawn(move || {
            if setting.is_single {
                let board = Board::of_number(UNIT, Protection::SIMULATED);
                let mut board = SingleAtLink { board, receiver: Receiver::new() };
                run(terminal, &mut board, setting.time, &stopped, disturb);
            } else {
                run(terminal, &mut JointAtLink::new(setting, told), setting.time, &stopped, disturb);
            }
        });
        Self { stop, board: Some(board), seen, commands }
    }

    /// What is seen of the board now.
    pub fn seen(&self) -> Seen {
        *lock(&self.seen)
    }

    /// Takes the port away, as a cable that is unplugged.
    pub fn unplug(&mut self) {
        self.stop.request();
        if let Some(board) = self.board.take() {
            let ended = board.join();
            // A test that fails already says more than this.
            assert!(ended.is_ok() || thread::panicking(), "the board has panicked");
        }
    }
}

impl Deref for JointDesk {
    type Target = Commands;

    fn deref(&self) -> &Commands {
        &self.commands
    }
}

impl Drop for JointDesk {
    fn drop(&mut self) {
        self.unplug();
    }
}

/// Runs a board until a stop is requested.
fn run(
    mut terminal: PseudoTerminal,
    board: &mut impl AtLink,
    time: Time,
    stop: &Stop,
    mut disturb: impl FnMut(Way, Vec<u8>) -> Vec<u8>,
) {
    let slice = Timespec { tv_sec: 0, tv_nsec: 200_000 };
    let (end, mut next) = (terminal.end(), Instant::now());
    while !stop.is_requested() {
        if time == Time::Real {
            while next <= Instant::now() {
                board.tick();
                next += PERIOD;
            }
        }
        match poll(&mut [PollFd::new(&*end, PollFlags::IN)], Some(&slice)) {
            Ok(0) => continue,
            other => drop(other.expect("a terminal that can be waited for")),
        }
        let mut buffer = [0; 512];
        let heard = match end.read(&mut buffer) {
            Err(error) if error.kind() == ErrorKind::Interrupted => 0,
            other => other.expect("readable"),
        };
        for byte in disturb(Way::ToBoard, buffer[..heard].to_vec()) {
            if let Some(answer) = board.push(byte) {
                end.write_all(&disturb(Way::FromBoard, answer)).expect("writable");
            }
        }
    }
}
