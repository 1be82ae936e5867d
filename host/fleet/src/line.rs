//! Boards on one line, and the muscles that they drive, in time.

use std::collections::VecDeque;
use std::io::{self, ErrorKind, Read, Write};
use std::os::fd::AsFd;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use board_client::emulator::real_time::PERIOD;
use board_client::stop::Stop;
use firmware::scaling::{COMMAND, CONTRACTION, PRESSURE};
use rig::plant::Plant;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use wire::registers::BAUD;

use crate::board::Board;

/// How long the boards wait for bytes before they look at the time.
const SLICE: Timespec = Timespec { tv_sec: 0, tv_nsec: 200_000 };
/// Delays of ticks that are made up for.
const MADE_UP_FOR: Duration = Duration::from_millis(50);
/// Bits of a byte on the line: a start bit, eight, a stop bit.
const BITS: u32 = 10;

/// Which way bytes go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// From the host.
    ToBoard,
    /// To the host.
    FromBoard,
}

/// How time passes on a line.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    /// How much faster than ours.
    pub factor: f64,
    /// Whether bytes take their time.
    pub has_bit_times: bool,
}

impl Pace {
    /// As on a real line.
    pub const REAL: Self = Self { factor: 1.0, has_bit_times: true };

    /// How long so many bytes take.
    fn takes(self, boards: &[Driven], bytes: usize) -> Duration {
        if self.has_bit_times { bit_times(boards, BITS * bytes as u32) } else { Duration::ZERO }
    }
}

/// How late the ticks of a line have been, for another thread.
#[derive(Clone, Debug, Default)]
pub struct Watch(Arc<AtomicU64>);

impl Watch {
    /// The longest delay of a tick.
    pub fn longest_delay(&self) -> Duration {
        Duration::from_nanos(self.0.load(Ordering::Relaxed))
    }

    fn tell(&self, delay: Duration) {
        self.0.fetch_max(delay.as_nanos() as u64, Ordering::Relaxed);
    }
}

/// A board with its muscle.
pub struct Driven {
    board: Board,
    plant: Plant,
    command_bar: f32,
}

impl Driven {
    /// A board at rest.
    pub fn new(board: Board, plant: Plant) -> Self {
        Self { board, plant, command_bar: 0.0 }
    }

    /// A tick; answers what the board sends.
    fn tick(&mut self) -> Vec<u8> {
        let measured = self.plant.step(f64::from(self.command_bar), PERIOD.as_secs_f64());
        let pressure = PRESSURE.code(measured.pressure_bar as f32);
        let contraction = CONTRACTION.code(measured.contraction_mm as f32);
        self.command_bar = COMMAND.value(self.board.tick_at(pressure, contraction).dac_code);
        self.board.idle()
    }
}

/// Runs boards until a stop is requested; `disturb` may change the bytes of either direction. Of
/// boards that answer at once the answers come one behind the other.
///
/// # Errors
/// The line cannot be read or written.
pub fn run(
    line: &mut (impl Read + Write + AsFd),
    boards: &mut [Driven],
    pace: Pace,
    stop: &Stop,
    watch: &Watch,
    mut disturb: impl FnMut(Way, Vec<u8>) -> Vec<u8>,
) -> io::Result<()> {
    let period = PERIOD.div_f64(pace.factor);
    let mut next = Instant::now();
    // What the boards have sent, and when the last of its bits is on the line.
    let mut on_its_way: VecDeque<(Instant, Vec<u8>)> = VecDeque::new();
    // By how much the last request is heard too early: its bytes come at once.
    let mut early = Duration::ZERO;
    while !stop.is_requested() {
        let now = Instant::now();
        let delay = now.saturating_duration_since(next);
        watch.tell(delay);
        next += delay.saturating_sub(MADE_UP_FOR);
        let mut sent = Vec::new();
        while next <= now {
            boards.iter_mut().for_each(|board| sent.extend(board.tick()));
            next += period;
        }
        push(&mut on_its_way, sent, early, boards, pace);
        let slice = match poll(&mut [PollFd::from_borrowed_fd(line.as_fd(), PollFlags::IN)], Some(&SLICE)) {
            Ok(0) | Err(Errno::INTR) => None,
            Ok(_) => Some([0; 512]),
            Err(error) => return Err(error.into()),
        };
        if let Some(mut buffer) = slice {
            let heard = match line.read(&mut buffer) {
                Ok(0) => return Ok(()),
                Ok(count) => count,
                Err(error) if error.kind() == ErrorKind::Interrupted => 0,
                Err(error) => return Err(error),
            };
            let bytes = disturb(Way::ToBoard, buffer[..heard].to_vec());
            early = pace.takes(boards, heard);
            let sent = boards.iter_mut().flat_map(|board| board.board.send(&bytes)).collect();
            push(&mut on_its_way, sent, early, boards, pace);
        }
        while let Some((until, _)) = on_its_way.front()
            && *until <= Instant::now()
            && let Some((_, bytes)) = on_its_way.pop_front()
        {
            line.write_all(&disturb(Way::FromBoard, bytes))?;
        }
    }
    Ok(())
}

/// Sends an answer behind those that are still on the line: it arrives when the bytes of its
/// request (`early`) and its own would have.
fn push(
    on_its_way: &mut VecDeque<(Instant, Vec<u8>)>,
    sent: Vec<u8>,
    early: Duration,
    boards: &[Driven],
    pace: Pace,
) {
    if sent.is_empty() {
        return;
    }
    let begins =
        on_its_way.back().map_or(Instant::now() + early, |(until, _)| (Instant::now() + early).max(*until));
    on_its_way.push_back((begins + pace.takes(boards, sent.len()), sent));
}

/// How long bits take at the rate of the line's first board.
fn bit_times(boards: &[Driven], bits: u32) -> Duration {
    let baud = boards.first().map_or(BAUD, |first| first.board.baud());
    Duration::from_secs_f64(f64::from(bits) / f64::from(baud))
}
