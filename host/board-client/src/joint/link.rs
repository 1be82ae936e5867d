//! A board of a joint at a serial port, its service link: requests, each with its answer.
//!
//! # Lost and damaged frames
//! A request whose answer does not come, or comes damaged, and one that the board could not read,
//! is sent again: three times where nothing comes, twelve in all. Whatever was sent
//! leads to the same state however often it is heard, but for what starts: a start that was heard,
//! though its answer was lost, is refused by the state that it has led to, which is taken for the
//! answer. Before each request what has come in is forgotten, and behind one that was sent more
//! than once what is late: so no answer is taken for another's.
//!
//! # Timing
//! A request and its answer are some 70 bytes, 1.5 ms at 460,800 bit/s, and what the adapter adds:
//! 1 to 16 ms. All tries together have to be over before the board misses its host, half a second.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use wire::joint::{
    BoardJointParameters, JOINT_VERSION, JointBoardState, JointHello, JointReport, JointRequest,
    JointResponse, JointSettings, JointStatus,
};
use wire::{FRAME_BYTES, Receiver, Refusal, Response};

use super::error::JointBoardError;
use crate::bus::port::{Line, Parity, Port};

/// Of the service link. Unit: bit/s.
pub const BAUD: u32 = 460_800;
/// How long an answer may take, unless the user has it otherwise.
pub const ANSWER: Duration = Duration::from_millis(120);
/// How often a request is sent that nobody answers.
const SILENT_TRIES: usize = 3;
/// How often a request is sent in all: damage is told at once.
const TRIES: usize = 12;
/// Checking a joint and storing it, for which a sector may have to be erased, takes a board this
/// many times as long as any other answer.
const LONG: u32 = 8;
/// It was done, and the flash has not kept it.
const NOT_STORED: JointResponse = JointResponse::Refused(Refusal::NotStored);
/// What comes after so long a silence is no answer to a request before.
const LATE: Duration = Duration::from_millis(20);
/// So long what comes late is waited for.
const LATEST: Duration = Duration::from_millis(100);
/// An empty frame: whatever stood before it is over.
const END: [u8; 1] = [0];

/// Where a board is.
#[derive(Clone, Debug)]
pub struct Address {
    /// Serial port.
    pub port: PathBuf,
    /// Unit: bit/s.
    pub baud: u32,
    /// How long an answer may take.
    pub limit: Duration,
}

/// A board with the image of a joint.
#[derive(Debug)]
pub struct JointLink {
    port: Port,
    address: Address,
    hello: JointHello,
    has_kept: bool,
}

impl JointLink {
    /// Opens the port and asks who is there. `acknowledges`: a fault that is latched is taken for
    /// seen to.
    ///
    /// # Errors
    /// The port cannot be used, nobody answers, or not a board of a joint and of this version; it
    /// is at fault, or driven.
    pub fn open(address: Address, acknowledges: bool) -> Result<Self, JointBoardError> {
        let mut link = Self::look(address)?;
        match (link.hello.state, link.hello.fault) {
            (_, Some(fault)) if !acknowledges => return Err(JointBoardError::AtFault(fault)),
            (_, Some(_)) => link.acknowledge()?,
            (state, None) if state.is_driven() => return Err(JointBoardError::State(state)),
            _ => {}
        }
        Ok(link)
    }

    /// The same of a board that is only asked, whatever it does.
    ///
    /// # Errors
    /// The port cannot be used, nobody answers, or not a board of a joint and of this version.
    pub fn look(address: Address) -> Result<Self, JointBoardError> {
        let line = Line { baud: address.baud, parity: Parity::None };
        let mut port = Port::open(&address.port, line)?;
        // A host before may have been ended within a request.
        port.send(&END, Instant::now() + address.limit)?;
        settle(&mut port)?;
        let hello = match exchange(&mut port, &address, &JointRequest::Identify, address.limit)?.response {
            JointResponse::Hello(hello) => hello,
            _ => return Err(JointBoardError::OutOfTurn(address.port)),
        };
        if hello.version != JOINT_VERSION {
            return Err(JointBoardError::Version { board: hello.version });
        }
        Ok(Self { port, address, hello, has_kept: true })
    }

    /// Takes a fault that is latched for seen to; nothing, without one.
    ///
    /// # Errors
    /// The board does not answer, or only power-off ends the fault.
    pub fn acknowledge(&mut self) -> Result<(), JointBoardError> {
        let answer = self.ask(&JointRequest::Acknowledge)?.response;
        match (answer, self.hello.fault) {
            (JointResponse::Accepted, _) => Ok(()),
            (JointResponse::WrongState(_), Some(fault)) => Err(JointBoardError::ForGood(fault)),
            (other, _) => Err(self.refused(other)),
        }
    }

    /// What the board has said of itself.
    pub fn hello(&self) -> &JointHello {
        &self.hello
    }

    /// Whether the board has kept what it was given last, and will have it when it starts again.
    pub fn has_kept(&self) -> bool {
        self.has_kept
    }

    /// Gives an order, which leads to one of the states `done`, if to another one at all.
    ///
    /// # Errors
    /// The board does not answer, or refuses. Flash that has not kept something is not an error
    /// here, see [`Self::has_kept`].
    pub fn order(&mut self, request: &JointRequest, done: &[JointBoardState]) -> Result<(), JointBoardError> {
        let Answered { response, tries } = self.ask(request)?;
        match response {
            JointResponse::Accepted | NOT_STORED => Ok(()),
            // It was heard before, and its answer was lost.
            JointResponse::WrongState(state) if tries > 1 && done.contains(&state) => Ok(()),
            other => Err(self.refused(other)),
        }
    }

    /// Asks for what is answered by the last tick.
    ///
    /// # Errors
    /// The board does not answer, or refuses; what it reports of a fault is no error.
    pub fn report(&mut self, request: &JointRequest) -> Result<JointReport, JointBoardError> {
        match self.ask(request)?.response {
            JointResponse::Report(report) => Ok(report),
            other => Err(self.refused(other)),
        }
    }

    /// Gives the board settings, or asks for them; behind that it is known how its codes are to be
    /// read.
    ///
    /// # Errors
    /// The board does not answer, or refuses. Flash that has not kept them is not an error here.
    pub fn settings(&mut self, request: &JointRequest) -> Result<JointSettings, JointBoardError> {
        let mut response = self.ask(request)?.response;
        if response == NOT_STORED {
            response = self.ask(&JointRequest::Settings(None))?.response;
        }
        let settings = match response {
            JointResponse::Settings(settings) => settings,
            other => return Err(self.refused(other)),
        };
        match self.ask(&JointRequest::Identify)?.response {
            JointResponse::Hello(hello) => self.hello = hello,
            other => return Err(self.refused(other)),
        }
        Ok(settings)
    }

    /// Which joint the board has, by its [`wire::fingerprint`]; none without one.
    ///
    /// # Errors
    /// The board does not answer, or not this.
    pub fn installed(&mut self) -> Result<Option<u32>, JointBoardError> {
        match self.ask(&JointRequest::Installed)?.response {
            JointResponse::Installed(joint) => Ok(joint),
            other => Err(self.refused(other)),
        }
    }

    /// The joint that the board has, its raw parameters; none without one.
    ///
    /// # Errors
    /// The board does not answer, or cannot read it back.
    pub fn control(&mut self) -> Result<Option<BoardJointParameters>, JointBoardError> {
        match self.ask(&JointRequest::Control)?.response {
            JointResponse::Control(control) => Ok(control),
            JointResponse::Refused(Refusal::NotHere) => Err(JointBoardError::NotReadBack),
            other => Err(self.refused(other)),
        }
    }

    /// What the board reads of itself.
    ///
    /// # Errors
    /// The board does not answer, or not this.
    pub fn status(&mut self) -> Result<JointStatus, JointBoardError> {
        match self.ask(&JointRequest::Status)?.response {
            JointResponse::Status(status) => Ok(status),
            other => Err(self.refused(other)),
        }
    }

    /// Why a request was not done; where the board is at fault, by which.
    fn refused(&mut self, response: JointResponse) -> JointBoardError {
        match response {
            JointResponse::Refused(refusal) => JointBoardError::Refused(refusal),
            JointResponse::WrongState(state) => match self.ask(&JointRequest::Aim(None)) {
                Ok(Answered { response: JointResponse::Report(report), .. }) => {
                    report.tick.fault.map_or(JointBoardError::State(state), JointBoardError::AtFault)
                }
                _ => JointBoardError::State(state),
            },
            _ => JointBoardError::OutOfTurn(self.address.port.clone()),
        }
    }

    fn ask(&mut self, request: &JointRequest) -> Result<Answered, JointBoardError> {
        let is_kept = matches!(request, JointRequest::Configure(_) | JointRequest::Settings(Some(_)));
        let limit = if is_kept { LONG * self.address.limit } else { self.address.limit };
        let answered = exchange(&mut self.port, &self.address, request, limit)?;
        if is_kept {
            self.has_kept = answered.response != NOT_STORED;
        }
        Ok(answered)
    }
}

/// A response, and how often it was asked for.
#[derive(Debug)]
struct Answered {
    response: JointResponse,
    tries: usize,
}

/// What came until a deadline.
enum Heard {
    Response(Box<JointResponse>),
    Nothing,
    Damaged,
    /// The greeting of a board with one muscle.
    OneMuscle,
}

/// Sends a request until it is answered. An answer may take as long as `limit`.
fn exchange(
    port: &mut Port,
    address: &Address,
    request: &JointRequest,
    limit: Duration,
) -> Result<Answered, JointBoardError> {
    let damaged = || JointBoardError::Damaged { port: address.port.clone(), baud: address.baud };
    let mut buffer = [0; FRAME_BYTES];
    let frame = wire::encode(request, &mut buffer).map_err(|_| damaged())?;
    let mut silent = 0;
    for tries in 1..=TRIES {
        port.discard()?;
        let deadline = Instant::now() + limit;
        if silent > 0 {
            // What was lost may have been the end of a frame.
            port.send(&END, deadline)?;
        }
        port.send(frame, deadline)?;
        match heard(port, deadline)? {
            Heard::Damaged => {}
            Heard::Response(response) if *response == JointResponse::Refused(Refusal::Unreadable) => {}
            Heard::Response(response) => {
                if tries > 1 {
                    settle(port)?;
                }
                return Ok(Answered { response: *response, tries });
            }
            Heard::OneMuscle => return Err(JointBoardError::OneMuscle(address.port.clone())),
            Heard::Nothing => {
                silent += 1;
                if silent == SILENT_TRIES {
                    let Address { port, baud, .. } = address.clone();
                    let limit_s = limit.as_secs_f64();
                    return Err(JointBoardError::Silent { port, limit_s, tries, baud });
                }
            }
        }
    }
    Err(damaged())
}

/// Waits for a whole frame.
fn heard(port: &mut Port, deadline: Instant) -> Result<Heard, JointBoardError> {
    let (mut joint, mut single) = (Receiver::new(), Receiver::new());
    let mut bytes = [0; 256];
    loop {
        let count = port.receive(&mut bytes, deadline)?;
        for byte in &bytes[..count] {
            let of_single = single.push::<Response>(*byte);
            match (joint.push::<JointResponse>(*byte), of_single) {
                (Some(Ok(response)), _) => return Ok(Heard::Response(Box::new(response))),
                (Some(Err(_)), Some(Ok(Response::Hello(_)))) => return Ok(Heard::OneMuscle),
                (Some(Err(_)), _) => return Ok(Heard::Damaged),
                (None, _) => {}
            }
        }
        if count == 0 {
            return Ok(Heard::Nothing);
        }
    }
}

/// Forgets what comes until there is a silence.
fn settle(port: &mut Port) -> Result<(), JointBoardError> {
    let (begin, mut buffer) = (Instant::now(), [0; 256]);
    while begin.elapsed() < LATEST && port.receive(&mut buffer, Instant::now() + LATE)? > 0 {}
    Ok(())
}
