//! A line and its thread: each board in turn is asked for what it measures, and orders go between
//! the questions.
//!
//! # Timing contract
//! A round takes an exchange a board: the frames' bytes, the silence between frames, up to a tick
//! of the board. A board that has not answered `LOST` times in a row is asked once in
//! `PATIENCE` from then on, so that one that is switched off costs the others an answer's time a
//! second. Orders go before the next question; a stop goes to all boards of the line at once.

use std::sync::mpsc::{Receiver, TryRecvError};
use std::thread;
use std::time::{Duration, Instant};

use board_client::bus::client::{BusError, Client};
use board_client::bus::port::PortError;
use wire::registers::{Command, Id, VERSION};

use crate::boards::Boards;
use crate::clock::Clock;
use crate::lines::{Line, Member};
use crate::seen::{Problem, Telemetry};

/// After so many questions without an answer a board counts as silent.
const LOST: u32 = 3;
/// How long a silent board, one with other registers, and a port that is not there are left alone.
const PATIENCE: Duration = Duration::from_secs(1);
/// How often all boards are told to vent, which none of them answers.
const STOPS: usize = 3;

/// What a line is asked to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Stop and vent every board.
    StopAll,
    /// Release the latched fault of the board at this place of the line.
    Acknowledge(usize),
}

/// A board as its line's thread knows it.
struct Asked<'a> {
    member: &'a Member,
    /// Its place among all boards.
    index: usize,
    /// Time from tick to tick, once it has said who it is. Unit: s.
    period_s: Option<f64>,
    /// Its ticks and their wraps. Unit: tick.
    ticks: u64,
    clock: Option<Clock>,
    lost: u32,
    /// When it is asked again, if it is left alone.
    until: Option<Instant>,
}

/// Why a round ends.
enum Ended {
    Port(PortError),
    /// Nobody is there any more to give orders: the gateway ends.
    Gateway,
}

/// Asks the boards of a line until the sender of its orders is gone. `first`: the place of its first
/// board among all boards.
pub fn run(line: &Line, first: usize, all: &Boards, orders: &Receiver<Order>) {
    let asked = |(index, member)| Asked {
        member,
        index: first + index,
        period_s: None,
        ticks: 0,
        clock: None,
        lost: 0,
        until: None,
    };
    let mut boards: Vec<Asked<'_>> = line.boards.iter().enumerate().map(asked).collect();
    loop {
        let ended = match Client::open(line.address.clone()) {
            Ok(mut client) => rounds(&mut client, &mut boards, all, orders),
            Err(error) => Ended::Port(error),
        };
        let Ended::Port(error) = ended else { return };
        for board in &mut boards {
            all.problem(board.index, Problem::Port(error.to_string()));
            (board.period_s, board.clock) = (None, None);
        }
        if !is_patient(orders) {
            return;
        }
    }
}

/// Waits a while; whether the gateway goes on. Orders that come meanwhile reach nobody.
fn is_patient(orders: &Receiver<Order>) -> bool {
    thread::sleep(PATIENCE);
    loop {
        match orders.try_recv() {
            Ok(_) => {}
            Err(TryRecvError::Empty) => return true,
            Err(TryRecvError::Disconnected) => return false,
        }
    }
}

fn rounds(client: &mut Client, boards: &mut [Asked<'_>], all: &Boards, orders: &Receiver<Order>) -> Ended {
    let numbers: Vec<u8> = boards.iter().map(|board| board.member.number).collect();
    loop {
        let begin = Instant::now();
        let mut is_idle = true;
        for board in &mut *boards {
            if let Err(ended) = obey(client, &numbers, orders) {
                return ended;
            }
            if board.until.is_some_and(|until| Instant::now() < until) {
                continue;
            }
            is_idle = false;
            client.turn_to(board.member.number);
            match board.ask(client) {
                Ok(telemetry) => {
                    board.lost = 0;
                    board.until = None;
                    all.telemetry(board.index, telemetry);
                }
                Err(Unanswered::Port(error)) => return Ended::Port(error),
                Err(Unanswered::Other(problem)) => {
                    board.lost = board.lost.saturating_add(1);
                    all.lost(board.index);
                    if board.lost >= LOST || !matches!(problem, Problem::Silent(_)) {
                        board.until = Some(Instant::now() + PATIENCE);
                        board.period_s = None;
                        all.problem(board.index, problem);
                    }
                }
            }
        }
        if is_idle {
            thread::sleep(Duration::from_millis(10));
        } else {
            all.round(boards.iter().map(|board| board.index), begin.elapsed());
        }
    }
}

/// Carries out what the line was asked for.
fn obey(client: &mut Client, numbers: &[u8], orders: &Receiver<Order>) -> Result<(), Ended> {
    loop {
        let order = match orders.try_recv() {
            Ok(order) => order,
            Err(TryRecvError::Empty) => return Ok(()),
            Err(TryRecvError::Disconnected) => return Err(Ended::Gateway),
        };
        match order {
            Order::StopAll => {
                for _ in 0..STOPS {
                    let stop = [Command::Stop.number()];
                    client.write_all(Id::Command.register().address, &stop).map_err(Ended::Port)?;
                }
            }
            Order::Acknowledge(place) => {
                let Some(&number) = numbers.get(place) else { continue };
                client.turn_to(number);
                // Whether it was taken shows in the board's state; it may be repeated.
                let acknowledge = [Command::Acknowledge.number()];
                if let Err(BusError::Port(error)) =
                    client.write_once(Id::Command.register().address, &acknowledge, 1)
                {
                    return Err(Ended::Port(error));
                }
            }
        }
    }
}

/// Why there is no telemetry.
enum Unanswered {
    Port(PortError),
    Other(Problem),
}

impl From<BusError> for Unanswered {
    fn from(error: BusError) -> Self {
        match error {
            BusError::Port(error) => Self::Port(error),
            error if error.is_lost() => Self::Other(Problem::Silent(error.to_string())),
            error => Self::Other(Problem::NotABoard(error.to_string())),
        }
    }
}

impl Asked<'_> {
    /// Asks once.
    fn ask(&mut self, client: &mut Client) -> Result<Telemetry, Unanswered> {
        let period_s = match self.period_s {
            Some(period_s) => period_s,
            None => *self.period_s.insert(period_s(client)?),
        };
        let (first, last) = (Id::State.register(), Telemetry::LAST.register());
        let sent_s = Boards::now_s();
        let words = client.read_in(first.address, last.end() - first.address, 1)?;
        let received_s = Boards::now_s();
        let mut telemetry = Telemetry::of_words(&words);
        // What passed since the last tick the board does not tell.
        let interval = [sent_s - period_s, received_s];
        let wrapped = self.ticks + u64::from(telemetry.ticks.wrapping_sub(self.ticks as u32));
        let has_restarted = self.clock.is_some() && wrapped - self.ticks > u64::from(u32::MAX / 2);
        self.ticks = if has_restarted || self.clock.is_none() { telemetry.ticks.into() } else { wrapped };
        let board_s = self.ticks as f64 * period_s;
        match &mut self.clock {
            Some(clock) if !has_restarted => {
                clock.exchange(board_s, interval);
            }
            clock => *clock = Some(Clock::new(board_s, interval)),
        }
        if let Some(clock) = &self.clock {
            (telemetry.time_s, telemetry.time_bound_s) = clock.at(board_s);
            telemetry.drift = clock.drift();
        }
        telemetry.round_trip_s = received_s - sent_s;
        Ok(telemetry)
    }
}

/// Asks a board who it is; answers the time from tick to tick. Unit: s.
fn period_s(client: &mut Client) -> Result<f64, Unanswered> {
    let version = client.read_in(Id::RegistersVersion.register().address, 1, 1)?;
    if version != [VERSION] {
        return Err(Unanswered::Other(Problem::OtherVersion(version.first().copied().unwrap_or_default())));
    }
    let period = Id::TickPeriod.register();
    let words = client.read_in(period.address, period.words(), 1)?;
    match wire::registers::Value::of_words(period.kind, &words).map(|value| value.number() * 1e-6) {
        Some(period_s) if period_s > 0.0 => Ok(period_s),
        _ => Err(Unanswered::Other(Problem::NotABoard("its ticks take no time".to_owned()))),
    }
}
