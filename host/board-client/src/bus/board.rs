//! A board that is the right one: its identity, its registers by their names, its orders.

use std::thread;
use std::time::{Duration, Instant};

use rmodbus::ErrorKind;
use wire::registers::{Command, Id, VERSION, Value, state};
use wire::{Fault, Scaling, State};

use super::client::{Address, BusError, Client};
use super::error::BoardError;

/// A self-test takes no longer.
const SELF_TEST: Duration = Duration::from_secs(12);
/// How often both steps of a start are tried, should the first have been too long ago.
const STARTS: usize = 3;
/// The longest from heartbeat to heartbeat.
const BEAT: Duration = Duration::from_millis(50);
/// At least so many heartbeats within the board's patience: four in a row may be lost.
const BEATS: f64 = 5.0;
/// How often a state is looked at that is waited for.
const LOOK: Duration = Duration::from_millis(20);

/// Registers next to each other, as they were read at once.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    address: u16,
    words: Vec<u16>,
}

impl Block {
    /// The words from a register on that is in the block; none if it is not.
    pub fn words(&self, id: Id) -> &[u16] {
        let place = id.register().address.checked_sub(self.address);
        place.and_then(|place| self.words.get(usize::from(place)..)).unwrap_or_default()
    }

    /// The value of a register; none if it is not in the block.
    pub fn value(&self, id: Id) -> Option<Value> {
        Value::of_words(id.register().kind, self.words(id))
    }

    /// The number of a register; 0 if it is not in the block.
    pub fn number(&self, id: Id) -> f64 {
        self.value(id).map_or(0.0, Value::number)
    }

    /// The value of a register of whole numbers.
    pub fn whole(&self, id: Id) -> u32 {
        self.number(id) as u32
    }

    /// The board's state; one that is not known is no state to drive in.
    pub fn state(&self) -> State {
        state(self.whole(Id::State) as u16).unwrap_or(State::Off)
    }
}

/// Who the board is.
#[derive(Clone, Debug, PartialEq)]
pub struct Identity {
    /// Version of the messages, that of a configuration.
    pub wire_version: u16,
    /// Layout of what is kept without power.
    pub storage_version: u16,
    /// Version of the firmware.
    pub release: [u16; 3],
    /// Time from tick to tick. Unit: s, above 0.
    pub period_s: f64,
    /// ADC code of the pressure in bar.
    pub pressure: Scaling,
    /// ADC code of the contraction in mm.
    pub contraction: Scaling,
    /// DAC code of the command in bar.
    pub command: Scaling,
}

/// A board on the bus.
#[derive(Debug)]
pub struct Board {
    client: Client,
    identity: Identity,
}

impl Board {
    /// Opens the port and asks who is there.
    ///
    /// # Errors
    /// The port cannot be used, nobody answers, or not a board with registers of this version.
    pub fn open(address: Address) -> Result<Self, BoardError> {
        let port = address.port.clone();
        let mut client = Client::open(address)?;
        let is_other = |error: &BusError| error.exception().is_some();
        let version = match client.read(Id::RegistersVersion.register().address, 1) {
            Ok(words) => words.first().copied().unwrap_or_default(),
            Err(error) if is_other(&error) => return Err(BoardError::NotTheBoard(port)),
            Err(error) => return Err(error.into()),
        };
        if version != VERSION {
            return Err(BoardError::MapVersion { board: version });
        }
        let block = span(&mut client, Id::RegistersVersion, Id::CommandGain)?;
        Ok(Self { client, identity: identity(&block).ok_or(BoardError::NotTheBoard(port))? })
    }

    /// Who the board is.
    pub fn identity(&self) -> &Identity {
        &self.identity
    }

    /// Reads all registers from the first to the last, between which there must be no free address.
    ///
    /// # Errors
    /// No answer, or a refusal.
    pub fn read(&mut self, first: Id, last: Id) -> Result<Block, BusError> {
        span(&mut self.client, first, last)
    }

    /// The words of a run, as many as the board has of it: one whose firmware is older may have
    /// fewer.
    ///
    /// # Errors
    /// No answer, or another refusal than that there is no such register.
    pub fn read_run(&mut self, run: Id) -> Result<Vec<u16>, BusError> {
        let register = run.register();
        // It has `known` words, and not `refused` of them.
        let (mut known, mut refused) = (Vec::new(), register.words() + 1);
        let mut count = register.words();
        while known.len() + 1 < refused.into() {
            match self.client.read(register.address, count) {
                Ok(words) => known = words,
                Err(error) if error.exception() == Some(ErrorKind::IllegalDataAddress) => refused = count,
                Err(error) => return Err(error),
            }
            count = (known.len() as u16).midpoint(refused);
        }
        Ok(known)
    }

    /// Writes words from a register on, which may be written twice.
    ///
    /// # Errors
    /// No answer, or a refusal: then nothing was written.
    pub fn write(&mut self, first: Id, words: &[u16]) -> Result<(), BusError> {
        self.client.write(first.register().address, words)
    }

    /// Writes a value.
    ///
    /// # Errors
    /// No answer, or a refusal: then nothing was written.
    pub fn set(&mut self, id: Id, number: f64) -> Result<(), BusError> {
        let words: Vec<u16> = Value::of_number(id.register().kind, number).words().collect();
        self.write(id, &words)
    }

    /// The longest that an answer usually takes.
    pub fn limit(&self) -> Duration {
        self.client.limit()
    }

    /// Writes words that must not be written twice; waits `patience` times as long as usual.
    ///
    /// # Errors
    /// A refusal: then nothing was written; or no answer: then perhaps.
    pub fn write_once(&mut self, first: Id, words: &[u16], patience: u32) -> Result<(), BusError> {
        self.client.write_once(first.register().address, words, patience)
    }

    /// The board's state, and the fault that is latched.
    ///
    /// # Errors
    /// No answer.
    pub fn state(&mut self) -> Result<(State, Option<Fault>), BusError> {
        let block = self.read(Id::State, Id::Fault)?;
        Ok((block.state(), Fault::of_code(block.whole(Id::Fault) as u8)))
    }

    /// Gives an order whose effect is the state `then`. An order whose answer was lost is looked
    /// up.
    ///
    /// # Errors
    /// A refusal, or no answer.
    pub fn order(&mut self, command: Command, then: &[State]) -> Result<(), BoardError> {
        match self.write_once(Id::Command, &[command.number()], 1) {
            Err(error) if error.is_lost() && then.contains(&self.state()?.0) => Ok(()),
            Err(error) if error.is_lost() => Ok(self.write_once(Id::Command, &[command.number()], 1)?),
            done => Ok(done?),
        }
    }

    /// Opens the valve by a command, in two steps, and from then on tells the board that this
    /// program lives, with each question that it asks.
    ///
    /// # Errors
    /// A refusal, or no answer.
    pub fn drive(&mut self, command: Command, then: State) -> Result<(), BoardError> {
        let patience_s =
            self.read(Id::BusSilent, Id::BusSilent)?.number(Id::BusSilent) * self.identity.period_s;
        let last = self.read(Id::Heartbeat, Id::Heartbeat)?.whole(Id::Heartbeat) as u16;
        // The register has a limit, but not that of a board in the emulator.
        let each = Duration::try_from_secs_f64(patience_s / BEATS).map_or(BEAT, |each| each.min(BEAT));
        self.client.beat_each(Some(each), last);
        let mut started = self.open_valve(command, then);
        for _ in 1..STARTS {
            let is_refused = matches!(&started, Err(BoardError::Bus(error)) if error.exception().is_some());
            let is_late = is_refused && !self.is_armed()?;
            if !is_late {
                break;
            }
            started = self.open_valve(command, then);
        }
        if started.is_err() {
            self.client.beat_each(None, last);
        }
        started
    }

    fn open_valve(&mut self, command: Command, then: State) -> Result<(), BoardError> {
        // May be repeated.
        self.write(Id::Command, &[Command::Arm.number()])?;
        self.order(command, &[then])
    }

    fn is_armed(&mut self) -> Result<bool, BusError> {
        Ok(self.read(Id::Armed, Id::Armed)?.whole(Id::Armed) > 0)
    }

    /// Stops and vents. What may be done in every state is simply done again.
    ///
    /// # Errors
    /// No answer.
    pub fn stop(&mut self) -> Result<(), BusError> {
        self.write(Id::Command, &[Command::Stop.number()])?;
        self.client.beat_each(None, 0);
        Ok(())
    }

    /// Releases the latched fault; the board repeats its self-test.
    ///
    /// # Errors
    /// A refusal, or no answer.
    pub fn acknowledge(&mut self) -> Result<(), BoardError> {
        self.order(Command::Acknowledge, &[State::SelfTest, State::Off, State::Ready])
    }

    /// The state as soon as the self-test is over, or, when none takes that long, as it is.
    ///
    /// # Errors
    /// No answer; a fault that is latched.
    pub fn settled(&mut self) -> Result<State, BoardError> {
        let deadline = Instant::now() + SELF_TEST;
        loop {
            let (state, fault) = self.state()?;
            if state == State::Fault {
                return Err(BoardError::Fault(fault));
            }
            if state != State::SelfTest || Instant::now() > deadline {
                return Ok(state);
            }
            thread::sleep(LOOK);
        }
    }
}

fn span(client: &mut Client, first: Id, last: Id) -> Result<Block, BusError> {
    let (address, end) = (first.register().address, last.register().end());
    Ok(Block { address, words: client.read(address, end.saturating_sub(address))? })
}

/// What a board says of itself; `None` if that cannot be.
fn identity(block: &Block) -> Option<Identity> {
    let scaling = |zero: Id, gain: Id| {
        let (zero_code, codes_per_unit) = (block.number(zero) as f32, block.number(gain) as f32);
        let is_sane = zero_code.is_finite() && codes_per_unit.is_finite() && codes_per_unit > 0.0;
        is_sane.then_some(Scaling { zero_code, codes_per_unit, code_min: 0, code_max: u16::MAX })
    };
    let mut release = [0; 3];
    release.iter_mut().zip(block.words(Id::Release)).for_each(|(number, word)| *number = *word);
    let period_us = block.whole(Id::TickPeriod);
    Some(Identity {
        wire_version: block.whole(Id::WireVersion) as u16,
        storage_version: block.whole(Id::StorageVersion) as u16,
        release,
        period_s: (period_us > 0).then_some(f64::from(period_us) * 1e-6)?,
        pressure: scaling(Id::PressureZero, Id::PressureGain)?,
        contraction: scaling(Id::ContractionZero, Id::ContractionGain)?,
        command: scaling(Id::CommandZero, Id::CommandGain)?,
    })
}
