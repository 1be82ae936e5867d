//! A line and its thread: each board in turn is given its next set point and asked for what it
//! measures, in one exchange; orders go between the questions.
//!
//! # Timing contract
//! A round takes an exchange a board: the frames' bytes, the silence between frames, up to a tick
//! of the board. A board that has not answered `LOST` times in a row is asked once in
//! `PATIENCE` from then on, so that one that is switched off costs the others an answer's time a
//! second. Orders go before the next question; a stop goes to all boards of the line at once.

use std::sync::mpsc::{Receiver, Sender, TryRecvError};
use std::thread;
use std::time::{Duration, Instant};

use board_client::bus::client::{BusError, Client};
use board_client::bus::port::PortError;
use model_core::Mode;
use wire::State;
use wire::registers::{Access, Command, Id, VERSION, Value, mode_number, state_number};

use crate::boards::Boards;
use crate::clock::Clock;
use crate::driving::Driving;
use crate::lines::{Line, Member};
use crate::seen::{Problem, Telemetry};

/// After so many questions without an answer a board counts as silent.
const LOST: u32 = 3;
/// How long a silent board, one with other registers, and a port that is not there are left alone.
const PATIENCE: Duration = Duration::from_secs(1);
/// How often all boards are told to vent, which none of them answers.
const STOPS: usize = 3;
/// How often each step of a start is tried: the other boards of the line wait meanwhile, and vent if
/// they wait for longer than 0.5 s.
const TRIES: usize = 2;

/// What is asked of a board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ask {
    /// To track, from where the muscle is.
    Start,
    /// To stop and vent.
    Stop,
    /// To release the latched fault.
    Acknowledge,
}

/// What a line is asked to do.
#[derive(Debug)]
pub enum Order {
    /// Stop and vent every board.
    StopAll,
    /// Something of the board at this place of the line; who is told what became of it.
    One(usize, Ask, Sender<Result<(), String>>),
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
    /// The last sign of life.
    heartbeat: u16,
}

/// Why a round ends.
enum Ended {
    Port(PortError),
    /// Nobody is there any more to give orders: the gateway ends.
    Gateway,
}

/// Asks the boards of a line until the sender of its orders is gone. `first`: the place of its first
/// board among all boards.
pub fn run(line: &Line, first: usize, all: &Boards, driving: &Driving, orders: &Receiver<Order>) {
    let asked = |(index, member)| Asked {
        member,
        index: first + index,
        period_s: None,
        ticks: 0,
        clock: None,
        lost: 0,
        until: None,
        heartbeat: 0,
    };
    let mut boards: Vec<Asked<'_>> = line.boards.iter().enumerate().map(asked).collect();
    loop {
        let ended = match Client::open(line.address.clone()) {
            Ok(mut client) => rounds(&mut client, &mut boards, (all, driving), orders),
            Err(error) => Ended::Port(error),
        };
        let Ended::Port(error) = ended else { return };
        for board in &mut boards {
            driving.end(board.index);
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

fn rounds(
    client: &mut Client,
    boards: &mut [Asked<'_>],
    (all, driving): (&Boards, &Driving),
    orders: &Receiver<Order>,
) -> Ended {
    loop {
        let begin = Instant::now();
        let mut is_idle = true;
        for place in 0..boards.len() {
            if let Err(ended) = obey(client, boards, driving, orders) {
                return ended;
            }
            let Some(board) = boards.get_mut(place) else { continue };
            if board.until.is_some_and(|until| Instant::now() < until) {
                continue;
            }
            is_idle = false;
            client.turn_to(board.member.number);
            match board.ask(client, driving) {
                Ok(telemetry) => {
                    board.lost = 0;
                    board.until = None;
                    if !telemetry.state.is_driven() {
                        driving.vented(board.index);
                    }
                    all.telemetry(board.index, telemetry);
                }
                Err(Unanswered::Port(error)) => return Ended::Port(error),
                Err(Unanswered::Other(problem)) => {
                    board.lost = board.lost.saturating_add(1);
                    all.lost(board.index);
                    if board.lost >= LOST || !matches!(problem, Problem::Silent(_)) {
                        board.until = Some(Instant::now() + PATIENCE);
                        board.period_s = None;
                        driving.end(board.index);
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
fn obey(
    client: &mut Client,
    boards: &mut [Asked<'_>],
    driving: &Driving,
    orders: &Receiver<Order>,
) -> Result<(), Ended> {
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
            Order::One(place, ask, told) => {
                let Some(board) = boards.get_mut(place) else { continue };
                client.turn_to(board.member.number);
                let done = match ask {
                    Ask::Start => board.start(client),
                    Ask::Stop => command(client, Command::Stop),
                    Ask::Acknowledge => command(client, Command::Acknowledge),
                };
                if ask == Ask::Start && done.is_ok() {
                    driving.started(board.index);
                }
                // Who has asked may have given up meanwhile.
                let _ = told.send(done.as_ref().copied().map_err(BusError::to_string));
                if let Err(BusError::Port(error)) = done {
                    return Err(Ended::Port(error));
                }
            }
        }
    }
}

/// Gives the board that the client is turned to a command, once.
fn command(client: &mut Client, command: Command) -> Result<(), BusError> {
    client.write_once(Id::Command.register().address, &[command.number()], 1)
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
    /// Brings the board to track from where its muscle is. The valve opens in two steps; where it is
    /// not known whether it has, the board is stopped.
    fn start(&mut self, client: &mut Client) -> Result<(), BusError> {
        let (setpoint, contraction) = (Id::SetpointMm.register(), Id::ContractionMm.register());
        let words = client.read_in(contraction.address, contraction.words(), TRIES)?;
        let measured_mm = Value::of_words(contraction.kind, &words).map_or(0.0, Value::number);
        let here_mm = match setpoint.access {
            Access::Write(min, max) => measured_mm.clamp(min, max),
            _ => measured_mm,
        };
        let mode = [mode_number(Mode::Both)];
        let words: Vec<u16> = mode.into_iter().chain(self.set_point(here_mm)).collect();
        client.write_in(Id::Mode.register().address, &words, TRIES)?;
        client.write_in(Id::Command.register().address, &[Command::Arm.number()], TRIES)?;
        match command(client, Command::Start) {
            Err(lost) if lost.is_lost() => {
                let tracking = [state_number(State::Tracking)];
                let state = client.read_in(Id::State.register().address, 1, TRIES);
                if state.is_ok_and(|state| state == tracking) {
                    return Ok(());
                }
                command(client, Command::Stop)?;
                Err(lost)
            }
            done => done,
        }
    }

    /// A set point with the next sign of life, from the register `setpoint_mm` on.
    fn set_point(&mut self, mm: f64) -> Vec<u16> {
        self.heartbeat = self.heartbeat.wrapping_add(1);
        let points = [Value::F32(mm as f32), Value::F32(0.0), Value::U16(self.heartbeat)];
        points.into_iter().flat_map(Value::words).collect()
    }

    /// Asks once; gives the board its next set point, if there is one.
    fn ask(&mut self, client: &mut Client, driving: &Driving) -> Result<Telemetry, Unanswered> {
        let period_s = match self.period_s {
            Some(period_s) => period_s,
            None => *self.period_s.insert(period_s(client)?),
        };
        let (first, last) = (Id::State.register(), Telemetry::LAST.register());
        let sent_s = Boards::now_s();
        let (address, count) = (first.address, last.end() - first.address);
        let words = match driving.take(self.index) {
            Some(mm) => {
                let written = self.set_point(mm);
                client.write_and_read((Id::SetpointMm.register().address, &written), address, count)
            }
            None => client.read_in(address, count, 1),
        }?;
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
