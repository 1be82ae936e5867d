//! A board with its bus on the host, and the frames of a Modbus client.

use std::ops::{Deref, DerefMut};

use board_models::paper_parameters;
use firmware::{BlackBox, Capture, Control};
use fleet::board::{Board, SILENCE_TICKS};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use wire::registers::{Command, Exception, Id, UNIT, Value};
use wire::{Configuration, Protection, Request, Response, TickReply, VERSION};

/// Codes of a vented muscle at rest.
const AT_REST: (u16, u16) = (410, 205);
/// The CRC-16 of Modbus.
const CRC: crc::Crc<u16> = crc::Crc::<u16>::new(&crc::CRC_16_MODBUS);

/// A board, and a client that has it alone on its bus.
pub struct BusBoard(Board);

impl Deref for BusBoard {
    type Target = Board;

    fn deref(&self) -> &Board {
        &self.0
    }
}

impl DerefMut for BusBoard {
    fn deref_mut(&mut self) -> &mut Board {
        &mut self.0
    }
}

impl BusBoard {
    /// A board whose muscle is a simulation.
    pub fn new() -> Self {
        // The control keeps both for as long as the board runs.
        Self::with(Box::leak(Box::default()), Box::leak(Box::default()))
    }

    /// A board with the paper's model.
    ///
    /// # Panics
    /// It does not take that.
    pub fn configured() -> Self {
        let mut board = Self::new();
        let tracking = paper_parameters().expect("valid");
        let configuration = Configuration { version: VERSION, tracking };
        assert_eq!(board.request(&Request::Configure(configuration)), Response::Accepted);
        board
    }

    /// The same board, reset to its state when it was new.
    pub fn reset(self) -> Self {
        let (black_box, capture) = self.0.into_control().into_memory();
        *black_box = BlackBox::default();
        *capture = Capture::default();
        Self::with(black_box, capture)
    }

    fn with(black_box: &'static mut BlackBox, capture: &'static mut Capture) -> Self {
        Self::of(Control::simulated(black_box, capture))
    }

    /// The board with this control.
    pub fn of(control: Control) -> Self {
        Self(Board::of(control, Protection::SIMULATED))
    }

    /// A tick with a vented muscle at rest; the reference stays that of the bus.
    pub fn tick(&mut self) -> TickReply {
        let (pressure_code, contraction_code) = AT_REST;
        self.tick_at(pressure_code, contraction_code)
    }

    /// Ticks in which nothing is on the bus, enough for a frame to begin; answers what the board
    /// sends meanwhile.
    pub fn be_silent(&mut self) -> Vec<u8> {
        (0..SILENCE_TICKS)
            .flat_map(|_| {
                self.tick();
                self.idle()
            })
            .collect()
    }

    /// Sends a request (function and data) to the board, and answers function and data of its
    /// response; empty if the server did not answer. The first byte of an exception is its function with the
    /// highest bit.
    ///
    /// # Panics
    /// The response is no frame of the board.
    pub fn ask(&mut self, pdu: &[u8]) -> Vec<u8> {
        let response = self.send(&frame(UNIT, pdu));
        match &*response {
            [] => Vec::new(),
            [UNIT, pdu @ .., _, _] => {
                assert_eq!(frame(UNIT, pdu), response);
                pdu.to_vec()
            }
            _ => panic!("no frame: {response:02x?}"),
        }
    }

    /// Reads registers from an address on.
    ///
    /// # Errors
    /// The number of the exception.
    ///
    /// # Panics
    /// There is no response, or one of another length.
    pub fn read(&mut self, address: u16, count: u16) -> Result<Vec<u16>, u8> {
        match &*self.ask(&[&[3], &address.to_be_bytes()[..], &count.to_be_bytes()].concat()) {
            [0x83, exception] => Err(*exception),
            [3, length, bytes @ ..]
                if bytes.len() == 2 * usize::from(count) && usize::from(*length) == bytes.len() =>
            {
                Ok(bytes.chunks(2).map(|pair| u16::from_be_bytes([pair[0], pair[1]])).collect())
            }
            other => panic!("no answer to a reading: {other:02x?}"),
        }
    }

    /// Writes registers from an address on.
    ///
    /// # Errors
    /// The number of the exception.
    ///
    /// # Panics
    /// There is no response, or another one.
    pub fn write(&mut self, address: u16, words: &[u16]) -> Result<(), u8> {
        let head = [&address.to_be_bytes()[..], &(words.len() as u16).to_be_bytes()].concat();
        let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_be_bytes()).collect();
        match &*self.ask(&[&[16], &head[..], &[bytes.len() as u8], &bytes].concat()) {
            [0x90, exception] => Err(*exception),
            [16, echo @ ..] if echo == head => Ok(()),
            other => panic!("no answer to a write: {other:02x?}"),
        }
    }

    /// Opens the valve by a command, in two steps.
    ///
    /// # Panics
    /// One of them is refused.
    pub fn open(&mut self, command: Command) {
        for command in [Command::Arm, command] {
            self.set(Id::Command, command.number().into()).expect("taken");
        }
    }

    /// Reads a register that exists, the first of a run.
    pub fn get(&mut self, id: Id) -> Value {
        let register = id.register();
        let words = self.read(register.address, register.kind.words()).expect(register.name);
        Value::of_words(register.kind, &words).expect(register.name)
    }

    /// Reads a register of whole numbers.
    pub fn number(&mut self, id: Id) -> u32 {
        self.get(id).number() as u32
    }

    /// Writes a number to a register.
    ///
    /// # Errors
    /// The number of the exception.
    pub fn set(&mut self, id: Id, number: f64) -> Result<(), u8> {
        let register = id.register();
        let words: Vec<u16> = Value::of_number(register.kind, number).words().collect();
        self.write(register.address, &words)
    }
}

impl Default for BusBoard {
    fn default() -> Self {
        Self::new()
    }
}

/// The answer of a board that refuses.
///
/// # Errors
/// Always: the number of the exception.
pub fn refused<T>(exception: Exception) -> Result<T, u8> {
    Err(exception.number() as u8)
}

/// What is no request, for ever: three in four are bytes, the rest whole frames to the board that
/// ask for something that it does not have.
pub fn random_frames(seed: u64) -> impl Iterator<Item = Vec<u8>> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    (0..).map(move |number| {
        let mut bytes = vec![0; random.random_range(1..=300)];
        random.fill_bytes(&mut bytes);
        if number % 4 == 0 {
            bytes.truncate(200);
            bytes = frame(UNIT, &[&[random.random_range(44..=127)][..], &bytes].concat());
        }
        bytes
    })
}

/// The frame of a request.
pub fn frame(unit: u8, pdu: &[u8]) -> Vec<u8> {
    let content = [&[unit], pdu].concat();
    let crc = CRC.checksum(&content).to_le_bytes();
    [content, crc.to_vec()].concat()
}
