//! A board on a desk: its bus on a pseudo terminal, the rig's muscle at its valve, time at a pace
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

use crate::PERIOD_S;
use crate::bus::BusBoard;

/// How long the board waits for bytes before it looks at the time.
const SLICE: Timespec = Timespec { tv_sec: 0, tv_nsec: 200_000 };

/// The board, until it is dropped.
#[derive(Debug)]
pub struct Desk {
    path: PathBuf,
    is_over: Arc<AtomicBool>,
    board: Option<JoinHandle<()>>,
}

impl Desk {
    /// A board whose time passes `pace` times as fast as ours; `disturb` may change the bytes of
    /// either direction, the board's own first.
    ///
    /// # Panics
    /// There is no pseudo terminal.
    pub fn new(pace: f64, mut disturb: impl FnMut(Way, Vec<u8>) -> Vec<u8> + Send + 'static) -> Self {
        let mut terminal = PseudoTerminal::open().expect("a pseudo terminal");
        let path = terminal.path().to_owned();
        let is_over = Arc::new(AtomicBool::new(false));
        let over = is_over.clone();
        let board = thread::spawn(move || {
            let line = terminal.end();
            let (mut board, mut plant) = (BusBoard::new(), Plant::new(&Setup::sound(1)));
            let (begin, mut ticks, mut command_bar) = (Instant::now(), 0_u64, 0.0);
            while !over.load(Ordering::Relaxed) {
                let mut sent = Vec::new();
                let due = (begin.elapsed().as_secs_f64() * pace / PERIOD_S) as u64;
                for _ in ticks..due {
                    let measured = plant.step(f64::from(command_bar), PERIOD_S);
                    let pressure = PRESSURE.code(measured.pressure_bar as f32);
                    let contraction = CONTRACTION.code(measured.contraction_mm as f32);
                    command_bar = COMMAND.value(board.tick_at(pressure, contraction).dac_code);
                    sent.extend(board.idle());
                }
                ticks = due;
                if poll(&mut [PollFd::new(&*line, PollFlags::IN)], Some(&SLICE)) == Ok(1) {
                    let mut buffer = [0; 512];
                    let count = line.read(&mut buffer).expect("readable");
                    sent.extend(board.send(&disturb(Way::ToBoard, buffer[..count].to_vec())));
                }
                if !sent.is_empty() {
                    line.write_all(&disturb(Way::FromBoard, sent)).expect("writable");
                }
            }
        });
        Self { path, is_over, board: Some(board) }
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
        if let Some(board) = self.board.take() {
            let ended = board.join();
            // A test that fails already says more than this.
            assert!(ended.is_ok() || thread::panicking(), "the board has panicked");
        }
    }
}
