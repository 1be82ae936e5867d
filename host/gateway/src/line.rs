//! A line and its thread: each board in turn is given its next set point and asked for what it
//! measures, in one exchange; orders go between the questions. Boards that know the exchange in
//! slots are all told and asked by one frame, each with the last tick of its own clock at which what
//! it is told counts. Of a line without such boards what all are told alike goes out once, to all.
//!
//! # Timing contract
//! A round takes an exchange a board, or one of all in slots: the frames' bytes, the silence between frames, up to a tick
//! of the board. A board that has not answered `LOST` times in a row is asked once in
//! `PATIENCE` from then on, so that one that is switched off costs the others an answer's time a
//! second. Orders go before the next question; a stop goes to all boards of the line at once. Starts
//! take several exchanges each: they have `STARTS` of a round, in which a stop goes before the next.

use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, Sender, TryRecvError};
use std::thread;
use std::time::{Duration, Instant};

use board_client::bus::client::{Address, BusError, Client};
use board_client::bus::port::PortError;
use model_core::Mode;
use wire::State;
use wire::registers::{Access, Command, Id, VERSION, Value, mode_number, state_number};
use wire::slots::{self, LEAST_GAP_US, MOST_MEMBERS, Outcome};

use crate::boards::Boards;
use crate::clock::Clock;
use crate::driving::{Driving, Said};
use crate::lines::{Exchange, Member};
use crate::seen::{Problem, Progress, Telemetry};
use crate::start::{Phase, Start};
use crate::stream::{self, Stream, Time};
use crate::trajectory::Trajectory;

/// After so many questions without an answer a board counts as silent.
const LOST: u32 = 3;
/// How long a silent board, one with other registers, and a port that is not there are left alone.
const PATIENCE: Duration = Duration::from_secs(1);
/// How often all boards are told to vent, which none of them answers.
const STOPS: usize = 3;
/// How often each step of a start is tried: the other boards of the line wait meanwhile, and vent if
/// they wait for longer than 0.5 s.
const TRIES: usize = 2;
/// For how long of a round boards are started, the last one begun within it: a fifth of the patience
/// of those that wait for their turn.
const STARTS: Duration = Duration::from_millis(100);
/// How long before a start the boards begin to count down: a frame to all, and a look at each board
/// whether it has heard it, twice over; eight boards at 115,200 bit/s take 0.08 s a round. Unit: s.
const COUNTDOWN_S: f64 = 0.3;
/// Until when before its start a board has to have its points: a countdown and one round. Unit: s.
const PREPARED_S: f64 = 0.2;
/// The shortest countdown, 20 ticks: a board takes a frame within two. Unit: s.
const LEAST_S: f64 = 0.02;
/// How long after its start a board may at the latest be seen to play: as long as a silent board is
/// left alone. Unit: s.
const LATEST_S: f64 = 1.0;
/// How often a countdown is sent where this machine has been too slow in between.
const COUNTS: usize = 5;
/// What is said of a board that leaves its slots empty.
const NO_ANSWER: &str = "no answer in its slot: is the board powered, are A and B swapped?";
/// How long this machine may take to send a countdown: a tick of the board. Unit: s.
const SENT_S: f64 = 1e-3;

/// What is asked of a board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ask {
    /// To track, from where the muscle is, for whom it is granted to by this grant.
    Start(u32),
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
    /// Something of the board of this number among all; who is told what became of it.
    One(usize, Ask, Sender<Result<(), String>>),
    /// A trajectory for the board of this number among all.
    Play(usize, Trajectory, Start),
    /// These are the line's boards from now on, with their numbers among all.
    Members(Vec<(usize, Member)>),
}

/// A board as its line's thread knows it.
struct Asked {
    member: Member,
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
    /// Its client has said that it lives since its last turn, by an order to all.
    lives: bool,
    stream: Option<Stream>,
    /// It has points of a trajectory that is left off.
    clears: bool,
    /// Whether it knows the exchange in slots, once that was tried.
    in_slots: Option<bool>,
    /// What it has told by itself alone. Unit: core clock cycle.
    deadline_cycles: u32,
}

/// What a line's thread works with.
struct Work<'a> {
    client: &'a mut Client,
    exchange: Exchange,
    all: &'a Boards,
    driving: &'a Driving,
    /// The last sign of life, of all its boards: none hears the same twice.
    heartbeat: &'a mut u16,
    /// Boards that are to be started.
    starts: VecDeque<Waiting>,
}

/// A board that is to be started.
struct Waiting {
    /// Its place among all.
    index: usize,
    grant: u32,
    told: Sender<Result<(), String>>,
}

/// Why a round ends.
enum Ended {
    Port(PortError),
    /// Nobody is there any more to give orders: the gateway ends.
    Gateway,
}

/// Asks the boards of a line until the sender of its orders is gone.
pub fn run(
    address: &Address,
    exchange: Exchange,
    members: Vec<(usize, Member)>,
    all: &Boards,
    driving: &Driving,
    orders: &Receiver<Order>,
) {
    let mut boards: Vec<Asked> = members.into_iter().map(Asked::new).collect();
    let mut heartbeat = 0;
    loop {
        let ended = match Client::open(address.clone()) {
            Ok(mut client) => {
                let (heartbeat, starts) = (&mut heartbeat, VecDeque::new());
                let work = Work { client: &mut client, exchange, all, driving, heartbeat, starts };
                work.rounds(&mut boards, orders)
            }
            Err(error) => Ended::Port(error),
        };
        let Ended::Port(error) = ended else { return };
        for board in &mut boards {
            driving.end(board.index);
            board.leave_off(all, driving, "the line's port is gone".to_owned());
            all.problem(board.index, Problem::Port(error.to_string()));
            board.clock = None;
            board.is_unknown();
        }
        if !is_patient(&mut boards, orders) {
            return;
        }
    }
}

/// Waits a while; whether the gateway goes on. Orders that come meanwhile reach nobody.
fn is_patient(boards: &mut Vec<Asked>, orders: &Receiver<Order>) -> bool {
    thread::sleep(PATIENCE);
    loop {
        match orders.try_recv() {
            Ok(Order::Members(members)) => drop(arrange(boards, members)),
            Ok(Order::Play(_, _, start)) => start.give_up("the line's port is not there".to_owned()),
            Ok(Order::StopAll | Order::One(..)) => {}
            Err(TryRecvError::Empty) => return true,
            Err(TryRecvError::Disconnected) => return false,
        }
    }
}

/// Gives a line these boards; those that stay are as they were. Answers those that go.
fn arrange(boards: &mut Vec<Asked>, members: Vec<(usize, Member)>) -> Vec<Asked> {
    let mut before = std::mem::take(boards);
    for (index, member) in members {
        match before.iter().position(|board| board.index == index) {
            Some(place) => boards.push(Asked { member, ..before.swap_remove(place) }),
            None => boards.push(Asked::new((index, member))),
        }
    }
    before
}

impl Work<'_> {
    fn rounds(mut self, boards: &mut Vec<Asked>, orders: &Receiver<Order>) -> Ended {
        loop {
            if let Err(ended) = self.round(boards, orders) {
                return ended;
            }
        }
    }

    fn round(&mut self, boards: &mut Vec<Asked>, orders: &Receiver<Order>) -> Result<(), Ended> {
        let begin = Instant::now();
        let mut is_idle = true;
        self.tell_all(boards)?;
        self.obey(boards, orders)?;
        self.start_some(boards, orders)?;
        self.count_down(boards)?;
        let asked = self.turn_of_slots(boards)?;
        is_idle &= asked.is_empty();
        let mut place = 0;
        loop {
            self.obey(boards, orders)?;
            self.count_down(boards)?;
            let Some(board) = boards.get_mut(place) else { break };
            place += 1;
            if asked.contains(&board.index) {
                continue;
            }
            if board.until.is_some_and(|until| Instant::now() < until) {
                board.tend(self.all, self.driving);
                continue;
            }
            is_idle = false;
            self.turn(board)?;
        }
        if is_idle {
            // An order that comes is seen after as long.
            thread::sleep(Duration::from_millis(10));
        } else {
            self.all.round(boards.iter().map(|board| board.index), begin.elapsed());
        }
        Ok(())
    }

    /// A board's turn: it is told, asked, and given points of its trajectory.
    fn turn(&mut self, board: &mut Asked) -> Result<(), Ended> {
        self.client.turn_to(board.member.number);
        board.tend(self.all, self.driving);
        if board.clears {
            match stream::clear(self.client) {
                Err(BusError::Port(error)) => return Err(Ended::Port(error)),
                Err(error) if error.is_lost() => {}
                // What is refused it has not.
                _ => board.clears = false,
            }
        }
        let said = self.driving.take(board.index);
        let lives = std::mem::take(&mut board.lives) || said.is_some();
        match board.ask(self.client, said, self.heartbeat) {
            Ok(telemetry) => {
                if self.exchange == Exchange::Slots && board.in_slots.is_none() {
                    board.in_slots = Some(self.knows_slots(board.member.number)?);
                }
                self.heard(board, telemetry, lives)
            }
            Err(Unanswered::Port(error)) => Err(Ended::Port(error)),
            Err(Unanswered::Other(problem)) => {
                self.unheard(board, problem);
                Ok(())
            }
        }
    }

    /// Whether a board answers in a slot.
    fn knows_slots(&mut self, unit: u8) -> Result<bool, Ended> {
        let member = slots::Member { unit, said: slots::Said::Nothing, until: 0 };
        for _ in 0..LOST {
            let answers = self.client.exchange_in_slots(*self.heartbeat, LEAST_GAP_US, &[member]);
            if !answers.map_err(Ended::Port)?.is_empty() {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// The turn of all boards that know the exchange in slots. Answers which those are, of all.
    fn turn_of_slots(&mut self, boards: &mut [Asked]) -> Result<Vec<usize>, Ended> {
        let mut asked = Vec::new();
        let mut members: Vec<&mut Asked> = boards.iter_mut().filter(|board| board.is_in_slots()).collect();
        for members in members.chunks_mut(MOST_MEMBERS) {
            self.client.settle();
            *self.heartbeat = self.heartbeat.wrapping_add(1);
            let told: Vec<(slots::Member, bool)> = members
                .iter_mut()
                .map(|board| {
                    board.tend(self.all, self.driving);
                    let said = self.driving.take_fresh(board.index);
                    (board.told_in_slot(said), said.is_some())
                })
                .collect();
            let request: Vec<slots::Member> = told.iter().map(|(member, _)| *member).collect();
            let sent_s = Boards::now_s();
            let answers = self.client.exchange_in_slots(*self.heartbeat, LEAST_GAP_US, &request);
            let answers = answers.map_err(Ended::Port)?;
            // All tell of the moment at which they heard the request: before the first answer.
            let first_s = answers.iter().map(|(_, since)| sent_s + since.as_secs_f64()).reduce(f64::min);
            for (board, (member, says)) in members.iter_mut().zip(told) {
                asked.push(board.index);
                let answer = answers.iter().find(|(answer, _)| answer.unit == member.unit);
                let (Some((answer, since)), Some(first_s)) = (answer, first_s) else {
                    self.unheard(board, Problem::Silent(NO_ANSWER.to_owned()));
                    continue;
                };
                let telemetry = Telemetry::of_answer(answer, board.deadline_cycles);
                let mut telemetry = board.timed(telemetry, [sent_s, first_s]);
                telemetry.round_trip_s = since.as_secs_f64();
                if matches!(answer.outcome, Outcome::Ahead | Outcome::Repeated) {
                    // It has restarted, or heard others: it is told by itself, and then joins again.
                    board.in_slots = None;
                }
                let lives = std::mem::take(&mut board.lives) || says;
                self.client.turn_to(member.unit);
                self.heard(board, telemetry, lives)?;
            }
        }
        Ok(asked)
    }

    /// A board has answered.
    fn heard(&mut self, board: &mut Asked, telemetry: Telemetry, lives: bool) -> Result<(), Ended> {
        board.lost = 0;
        board.until = None;
        board.deadline_cycles = telemetry.deadline_cycles;
        if !telemetry.state.is_driven() {
            self.driving.vented(board.index);
        }
        self.all.telemetry(board.index, telemetry);
        if lives { self.play_on(board) } else { Ok(()) }
    }

    /// A board has not.
    fn unheard(&mut self, board: &mut Asked, problem: Problem) {
        board.lost = board.lost.saturating_add(1);
        self.all.lost(board.index);
        if board.lost >= LOST || !matches!(problem, Problem::Silent(_)) {
            board.until = Some(Instant::now() + PATIENCE);
            board.is_unknown();
            self.driving.end(board.index);
            self.all.problem(board.index, problem);
        }
    }

    /// Tells all boards of the line at once, where their clients have said the same to each.
    fn tell_all(&mut self, boards: &mut [Asked]) -> Result<(), Ended> {
        let is_apart = |board: &Asked| board.until.is_some() || board.is_in_slots();
        if boards.len() < 2 || boards.iter().any(is_apart) {
            return Ok(());
        }
        let indices: Vec<usize> = boards.iter().map(|board| board.index).collect();
        let Some(said) = self.driving.take_common(&indices) else { return Ok(()) };
        let (address, words) = told(said, self.heartbeat);
        self.client.write_all(address, &words).map_err(Ended::Port)?;
        boards.iter_mut().for_each(|board| board.lives = true);
        Ok(())
    }

    /// Counts the boards that wait for their start down to it, all at once.
    fn count_down(&mut self, boards: &mut [Asked]) -> Result<(), Ended> {
        if boards.iter().any(|board| board.clears && board.until.is_none()) {
            // It would begin with the others.
            return Ok(());
        }
        let waiting = boards.iter().find_map(|board| {
            let stream = board.stream.as_ref().filter(|stream| stream.awaits_countdown())?;
            Some((stream.start().clone(), board.period_s?))
        });
        let Some((start, period_s)) = waiting else { return Ok(()) };
        if start.at_s - Boards::now_s() > COUNTDOWN_S {
            return Ok(());
        }
        for _ in 0..COUNTS {
            self.client.settle();
            let sent_s = Boards::now_s();
            let left_s = start.at_s - sent_s - self.client.heard_in(1).as_secs_f64();
            if left_s < LEAST_S {
                break;
            }
            let ticks = (left_s / period_s).round() as u16;
            self.client.write_all(Id::StreamPlayIn.register().address, &[ticks]).map_err(Ended::Port)?;
            if Boards::now_s() - sent_s < SENT_S {
                boards.iter_mut().filter_map(|board| board.stream.as_mut()).for_each(Stream::counted);
                return Ok(());
            }
        }
        start.give_up("the countdown could not be sent in time".to_owned());
        Ok(())
    }

    /// Takes a board's trajectory a step further.
    fn play_on(&mut self, board: &mut Asked) -> Result<(), Ended> {
        if board.clears {
            // What is pushed now would be forgotten with the rest.
            return Ok(());
        }
        let (Some(stream), Some(period_s)) = (&mut board.stream, board.period_s) else { return Ok(()) };
        let drift = board.clock.as_ref().map_or(0.0, |clock| clock.drift().0);
        match stream.step(self.client, Time { now_s: Boards::now_s(), period_s, drift }) {
            Ok(None) => {}
            Ok(Some(Progress::Playing { start_tick, .. })) => {
                let (start_s, bound_s) = board.time_of(start_tick, period_s);
                self.all.progress(board.index, Progress::Playing { start_tick, start_s, bound_s });
            }
            Ok(Some(progress @ Progress::Ready { .. })) => self.all.progress(board.index, progress),
            Ok(Some(progress)) => {
                board.stream = None;
                self.driving.plays(board.index, false);
                self.all.progress(board.index, progress);
            }
            Err(BusError::Port(error)) => return Err(Ended::Port(error)),
            // It is asked again.
            Err(error) if error.is_lost() => {}
            Err(error) => board.leave_off(self.all, self.driving, error.to_string()),
        }
        Ok(())
    }

    /// Carries out what the line was asked for.
    fn obey(&mut self, boards: &mut Vec<Asked>, orders: &Receiver<Order>) -> Result<(), Ended> {
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
                        let address = Id::Command.register().address;
                        self.client.write_all(address, &stop).map_err(Ended::Port)?;
                    }
                }
                Order::One(index, Ask::Start(grant), told) => {
                    self.starts.push_back(Waiting { index, grant, told });
                }
                Order::One(index, ask, told) => {
                    if let Some(board) = of_index(boards, index) {
                        self.carry_out(board, ask, &told)?;
                    }
                }
                Order::Play(index, trajectory, start) => match of_index(boards, index) {
                    Some(board) => board.stream = Some(Stream::new(trajectory, start)),
                    None => start.give_up("a board is no longer on its line".to_owned()),
                },
                Order::Members(members) => {
                    for mut board in arrange(boards, members) {
                        board.leave_off(self.all, self.driving, "the board was taken out".to_owned());
                        if self.driving.is_driven(board.index) {
                            self.driving.end(board.index);
                            self.client.turn_to(board.member.number);
                            // It vents by itself where it has not heard this.
                            let _ = command(self.client, Command::Stop);
                        }
                    }
                }
            }
        }
    }

    /// Starts boards that are to be started, as many as a round has time for.
    fn start_some(&mut self, boards: &mut Vec<Asked>, orders: &Receiver<Order>) -> Result<(), Ended> {
        let until = Instant::now() + STARTS;
        while let Some(Waiting { index, grant, told }) = self.starts.pop_front() {
            if !self.driving.holds(index, grant) {
                // Who has asked may have given up meanwhile.
                let _ = told.send(Err("the board was stopped before it had been started".to_owned()));
            } else if let Some(board) = of_index(boards, index) {
                self.carry_out(board, Ask::Start(grant), &told)?;
            }
            if Instant::now() >= until {
                break;
            }
            self.obey(boards, orders)?;
        }
        Ok(())
    }

    fn carry_out(
        &mut self,
        board: &mut Asked,
        ask: Ask,
        told: &Sender<Result<(), String>>,
    ) -> Result<(), Ended> {
        self.client.turn_to(board.member.number);
        let done = match ask {
            Ask::Start(_) => board.start(self.client, self.heartbeat),
            // It may be heard twice.
            Ask::Stop => {
                let address = Id::Command.register().address;
                self.client.write_in(address, &[Command::Stop.number()], TRIES)
            }
            Ask::Acknowledge => command(self.client, Command::Acknowledge),
        };
        if let (Ask::Start(grant), Ok(())) = (ask, &done) {
            if self.driving.holds(board.index, grant) {
                self.driving.started(board.index);
            } else {
                // It was stopped while it was being started; where it does not hear this it hears no
                // sign of life either.
                let _ = command(self.client, Command::Stop);
            }
        }
        // Who has asked may have given up meanwhile.
        let _ = told.send(done.as_ref().copied().map_err(BusError::to_string));
        match done {
            Err(BusError::Port(error)) => Err(Ended::Port(error)),
            _ => Ok(()),
        }
    }
}

/// The board at this place among all.
fn of_index(boards: &mut [Asked], index: usize) -> Option<&mut Asked> {
    boards.iter_mut().find(|board| board.index == index)
}

/// Gives the board that the client is turned to a command, once.
fn command(client: &mut Client, command: Command) -> Result<(), BusError> {
    client.write_once(Id::Command.register().address, &[command.number()], 1)
}

/// What a client says as registers, with the next sign of life: their address and words.
fn told(said: Said, heartbeat: &mut u16) -> (u16, Vec<u16>) {
    *heartbeat = heartbeat.wrapping_add(1);
    match said {
        Said::Lives => (Id::Heartbeat.register().address, vec![*heartbeat]),
        Said::SetPoint(mm) => {
            let points = [Value::F32(mm as f32), Value::F32(0.0), Value::U16(*heartbeat)];
            (Id::SetpointMm.register().address, points.into_iter().flat_map(Value::words).collect())
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

impl Asked {
    fn new((index, member): (usize, Member)) -> Self {
        Self {
            member,
            index,
            period_s: None,
            ticks: 0,
            clock: None,
            lost: 0,
            until: None,
            lives: false,
            stream: None,
            clears: false,
            in_slots: None,
            deadline_cycles: 0,
        }
    }

    /// Who it is has to be asked again.
    fn is_unknown(&mut self) {
        (self.period_s, self.in_slots) = (None, None);
    }

    /// Whether it is asked with others, in slots.
    fn is_in_slots(&self) -> bool {
        self.in_slots == Some(true) && !self.clears && self.until.is_none() && self.clock.is_some()
    }

    /// What it is told in a slot: what its client has said, as long as that is still fresh.
    fn told_in_slot(&self, said: Option<(Said, Duration)>) -> slots::Member {
        let (said, left) = match said {
            None => (slots::Said::Nothing, Duration::ZERO),
            Some((Said::Lives, left)) => (slots::Said::Lives, left),
            Some((Said::SetPoint(mm), left)) => (slots::Said::SetPoint(mm as f32), left),
        };
        let period_s = self.period_s.unwrap_or(1.0);
        let (seen_s, bound_s) =
            self.clock.as_ref().map_or((0.0, 0.0), |clock| clock.at(self.ticks as f64 * period_s));
        // The last answer was told at the latest then: the board may be further.
        let since_s = Boards::now_s() - (seen_s + bound_s) + left.as_secs_f64();
        let until = (self.ticks as u32).wrapping_add((since_s / period_s).max(0.0) as u32);
        slots::Member { unit: self.member.number, said, until }
    }

    /// Looks whether its trajectory is still to be played; leaves it off if not.
    fn tend(&mut self, all: &Boards, driving: &Driving) {
        let Some(stream) = &self.stream else { return };
        if !driving.is_driven(self.index) {
            self.leave_off(all, driving, "the board is driven no longer".to_owned());
        } else if let (true, Phase::GivenUp(reason)) = (stream.waits(), stream.start().phase()) {
            self.leave_off(all, driving, reason);
        } else if !stream.is_filled() && stream.start().at_s - Boards::now_s() < PREPARED_S {
            stream.start().give_up(format!(
                "{} has not got its points in time: does its client say that it lives?",
                self.member.name
            ));
        } else if stream.waits() && stream.start().at_s - Boards::now_s() < -LATEST_S {
            stream.start().give_up(format!("{} has not begun", self.member.name));
        }
    }

    /// Leaves its trajectory off, and that of those that were to begin with it.
    fn leave_off(&mut self, all: &Boards, driving: &Driving, reason: String) {
        if let Some(stream) = self.stream.take() {
            if stream.waits() {
                stream.start().give_up(format!("{}: {reason}", self.member.name));
            }
            self.clears = true;
            driving.plays(self.index, false);
            all.progress(self.index, Progress::Ended { reason });
        }
    }

    /// When a tick was that lies not far back, and by how much that may be off. Unit: s.
    fn time_of(&self, tick: u32, period_s: f64) -> (f64, f64) {
        let since = (self.ticks as u32).wrapping_sub(tick).cast_signed();
        let board_s = (self.ticks as f64 - f64::from(since)) * period_s;
        self.clock.as_ref().map_or((0.0, f64::INFINITY), |clock| clock.at(board_s))
    }

    /// Brings the board to track from where the muscle is. The valve opens in two steps; where it is
    /// not known whether it has, the board is stopped.
    fn start(&mut self, client: &mut Client, heartbeat: &mut u16) -> Result<(), BusError> {
        let (setpoint, contraction) = (Id::SetpointMm.register(), Id::ContractionMm.register());
        let words = client.read_in(contraction.address, contraction.words(), TRIES)?;
        let measured_mm = Value::of_words(contraction.kind, &words).map_or(0.0, Value::number);
        let here_mm = match setpoint.access {
            Access::Write(min, max) => measured_mm.clamp(min, max),
            _ => measured_mm,
        };
        let mode = [mode_number(Mode::Both)];
        let (_, set_point) = told(Said::SetPoint(here_mm), heartbeat);
        let words: Vec<u16> = mode.into_iter().chain(set_point).collect();
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

    /// Asks once; tells the board what its client has said, if it has said anything.
    fn ask(
        &mut self,
        client: &mut Client,
        said: Option<Said>,
        heartbeat: &mut u16,
    ) -> Result<Telemetry, Unanswered> {
        if self.period_s.is_none() {
            self.period_s = Some(period_s(client)?);
        }
        let (first, last) = (Id::State.register(), Telemetry::LAST.register());
        let sent_s = Boards::now_s();
        let (address, count) = (first.address, last.end() - first.address);
        let words = match said {
            Some(said) => {
                let (to, written) = told(said, heartbeat);
                client.write_and_read((to, &written), address, count)
            }
            None => client.read_in(address, count, 1),
        }?;
        let received_s = Boards::now_s();
        let mut telemetry = self.timed(Telemetry::of_words(&words), [sent_s, received_s]);
        telemetry.round_trip_s = received_s - sent_s;
        Ok(telemetry)
    }

    /// Telemetry with the time at which it was so: between these, by this machine's clock.
    fn timed(&mut self, mut telemetry: Telemetry, [sent_s, received_s]: [f64; 2]) -> Telemetry {
        let period_s = self.period_s.unwrap_or(0.0);
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
        telemetry
    }
}

/// Asks a board who it is; answers the time from tick to tick. Unit: s.
fn period_s(client: &mut Client) -> Result<f64, Unanswered> {
    // What is late of questions before is nobody's second answer.
    client.forget().map_err(Unanswered::Port)?;
    let version = client.read_in(Id::RegistersVersion.register().address, 1, 1)?;
    if client.forget().map_err(Unanswered::Port)? > 0 {
        return Err(Unanswered::Other(Problem::Several));
    }
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
