//! Boards on a desk: their bus on a pseudo terminal, the rig's muscle at each valve, time at a pace
//! of its own.

use std::path::{Path, PathBuf};
use std::thread::{self, JoinHandle};

use board_client::emulator::terminal::PseudoTerminal;
use board_client::stop::Stop;
use fleet::board::Board;
use fleet::line::{self, Driven, Pace, Watch, Way};
use rig::plant::{Plant, Setup};
use wire::Protection;
use wire::registers::UNIT;

/// The boards, until they are dropped.
#[derive(Debug)]
pub struct Desk {
    path: PathBuf,
    stop: Stop,
    boards: Option<JoinHandle<()>>,
}

impl Desk {
    /// A board whose time passes `pace` times as fast as ours; `disturb` may change the bytes of
    /// either direction, the board's own first.
    ///
    /// # Panics
    /// There is no pseudo terminal.
    pub fn new(pace: f64, disturb: impl FnMut(Way, Vec<u8>) -> Vec<u8> + Send + 'static) -> Self {
        Self::line(pace, &[UNIT], disturb)
    }

    /// The same with a board each of these numbers, on one line.
    ///
    /// # Panics
    /// There is no pseudo terminal.
    pub fn line(
        pace: f64,
        units: &[u8],
        disturb: impl FnMut(Way, Vec<u8>) -> Vec<u8> + Send + 'static,
    ) -> Self {
        let units = units.to_owned();
        let board = |unit| Board::of_number(unit, Protection::SIMULATED);
        Self::of(pace, move || units.into_iter().map(board).collect(), disturb)
    }

    /// The same of boards that are made there.
    ///
    /// # Panics
    /// There is no pseudo terminal.
    pub fn of(
        pace: f64,
        make: impl FnOnce() -> Vec<Board> + Send + 'static,
        disturb: impl FnMut(Way, Vec<u8>) -> Vec<u8> + Send + 'static,
    ) -> Self {
        let mut terminal = PseudoTerminal::open().expect("a pseudo terminal");
        let path = terminal.path().to_owned();
        let (stop, pace) = (Stop::default(), Pace { factor: pace, has_bit_times: false });
        let stopped = stop.clone();
        let boards = thread::spawn(move || {
            let driven = |board| Driven::new(board, Plant::new(&Setup::sound(1)));
            let mut boards: Vec<Driven> = make().into_iter().map(driven).collect();
            line::run(terminal.end(), &mut boards, pace, &stopped, &Watch::default(), disturb)
                .expect("a line that can be read and written");
        });
        Self { path, stop, boards: Some(boards) }
    }

    /// The end that a host opens.
    pub fn port(&self) -> &Path {
        &self.path
    }
}

impl Drop for Desk {
    fn drop(&mut self) {
        self.stop.request();
        if let Some(boards) = self.boards.take() {
            let ended = boards.join();
            // A test that fails already says more than this.
            assert!(ended.is_ok() || thread::panicking(), "a board has panicked");
        }
    }
}
