//! Boards on a desk: their bus on a pseudo terminal, the rig's muscle at each valve, time at a pace
//! of its own.

use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Instant;

use board_client::emulator::terminal::PseudoTerminal;
use firmware::scaling::{COMMAND, CONTRACTION, PRESSURE};
use rig::plant::{Plant, Setup};
use rustix::event::{PollFd, PollFlags, Timespec, poll};

use wire::registers::UNIT;

use crate::PERIOD_S;
use crate::bus::BusBoard;

/// How long the board waits for bytes before it looks at the time.
const SLICE: Timespec = Timespec { tv_sec: 0, tv_nsec: 200_000 };

/// The boards, until they are dropped.
#[derive(Debug)]
pub struct Desk {
    path: PathBuf,
    is_over: Arc<AtomicBool>,
    boards: Option<JoinHandle<()>>,
}

/// A board with its muscle.
struct Driven {
    board: BusBoard,
    plant: Plant,
    command_bar: f32,
}

impl Driven {
    /// A tick; answers what the board sends.
    fn tick(&mut self) -> Vec<u8> {
        let measured = self.plant.step(f64::from(self.command_bar), PERIOD_S);
        let pressure = PRESSURE.code(measured.pressure_bar as f32);
        let contraction = CONTRACTION.code(measured.contraction_mm as f32);
        self.command_bar = COMMAND.value(self.board.tick_at(pressure, contraction).dac_code);
        self.board.idle()
    }
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

    /// The same with a board each of these numbers, on one line; of those that answer at once the
    /// answers come one behind the other.
    ///
    /// # Panics
    /// There is no pseudo terminal.
    pub fn line(
        pace: f64,
        units: &[u8],
        disturb: impl FnMut(Way, Vec<u8>) -> Vec<u8> + Send + 'static,
    ) -> Self {
        let units = units.to_owned();
        Self::of(pace, move || units.into_iter().map(BusBoard::of_number).collect(), disturb)
    }

    /// The same of boards that are made there.
    ///
    /// # Panics
    /// There is no pseudo terminal.
    pub fn of(
        pace: f64,
        make: impl FnOnce() -> Vec<BusBoard> + Send + 'static,
        mut disturb: impl FnMut(Way, Vec<u8>) -> Vec<u8> + Send + 'static,
    ) -> Self {
        let mut terminal = PseudoTerminal::open().expect("a pseudo terminal");
        let path = terminal.path().to_owned();
        let is_over = Arc::new(AtomicBool::new(false));
        let over = is_over.clone();
        let boards = thread::spawn(move || {
            let line = terminal.end();
            let driven = |board| Driven { board, plant: Plant::new(&Setup::sound(1)), command_bar: 0.0 };
            let mut boards: Vec<Driven> = make().into_iter().map(driven).collect();
            let (begin, mut ticks) = (Instant::now(), 0_u64);
            while !over.load(Ordering::Relaxed) {
                let mut sent = Vec::new();
                let due = (begin.elapsed().as_secs_f64() * pace / PERIOD_S) as u64;
                for _ in ticks..due {
                    boards.iter_mut().for_each(|board| sent.extend(board.tick()));
                }
                ticks = due;
                if poll(&mut [PollFd::new(&*line, PollFlags::IN)], Some(&SLICE)) == Ok(1) {
                    let mut buffer = [0; 512];
                    let count = line.read(&mut buffer).expect("readable");
                    let heard = disturb(Way::ToBoard, buffer[..count].to_vec());
                    boards.iter_mut().for_each(|board| sent.extend(board.board.send(&heard)));
                }
                if !sent.is_empty() {
                    line.write_all(&disturb(Way::FromBoard, sent)).expect("writable");
                }
            }
        });
        Self { path, is_over, boards: Some(boards) }
    }

    /// The end that a host opens.
    pub fn port(&self) -> &Path {
        &self.path
    }
}

/// Which way bytes go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// From the host.
    ToBoard,
    /// To the host.
    FromBoard,
}

impl Drop for Desk {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::Relaxed);
        if let Some(boards) = self.boards.take() {
            let ended = boards.join();
            // A test that fails already says more than this.
            assert!(ended.is_ok() || thread::panicking(), "a board has panicked");
        }
    }
}
