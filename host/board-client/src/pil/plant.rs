//! A plant that is a program. Once a tick it gets a line `time_s command_bar` on its standard input
//! and answers `pressure_bar contraction_mm [load_n temperature_c]` on its standard output.
//!
//! A joint gets `time_s command_a_bar command_b_bar` and answers `pressure_a_bar pressure_b_bar
//! angle_deg`.
//!
//! The first line finds the plant at rest; every further one says: this command, from the time
//! before to this one. Its time-out, or an answer that cannot be read, is an error that quotes it.

use std::io::{self, Read, Write};
use std::os::fd::AsFd;
use std::path::PathBuf;
use std::process::{ChildStdin, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};

use model_core::Surroundings;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use thiserror::Error;

use super::PilError;
use super::lock_step::{Measurement, Plant};
use crate::child::{ChildGroup, WAIT_SLICE};
use crate::joint::{JointMeasured, JointPlant};
use crate::stop::Stop;

/// The longest answer: many times four numbers. Unit: byte.
const LONGEST_ANSWER: usize = 1024;

/// Why a plant is of no use.
#[derive(Debug, Error)]
#[error("the plant `{plant}`, at {time_s} s: {problem}")]
pub struct PlantError {
    plant: String,
    time_s: f64,
    problem: Problem,
}

#[derive(Debug, Error)]
enum Problem {
    #[error("cannot be started: {0}")]
    NotStarted(io::Error),
    #[error("no answer within {0} s")]
    Late(f64),
    #[error("{0}")]
    Ended(String),
    #[error("cannot be talked to: {0}")]
    Io(#[from] io::Error),
    #[error("the answer `{0}` is not `{1}`, finite numbers")]
    Answer(String, &'static str),
    #[error("more than one line is answered; the second begins with `{0}`")]
    Unasked(String),
    #[error("the answer is longer than {LONGEST_ANSWER} bytes")]
    TooLong,
    #[error("stopped")]
    Stopped,
}

impl PlantError {
    /// Whether it is not an error of the plant: a stop was requested.
    pub fn is_stop(&self) -> bool {
        matches!(self.problem, Problem::Stopped)
    }
}

/// A program with its arguments.
#[derive(Clone, Debug)]
pub struct Program {
    /// What it is called in messages.
    pub name: String,
    /// Its file, or its name on the search path.
    pub file: PathBuf,
    /// Its arguments.
    pub arguments: Vec<String>,
    /// How long it may take for an answer.
    pub limit: Duration,
}

impl Program {
    /// A command line for the shell.
    pub fn shell(line: &str, limit: Duration) -> Self {
        let arguments = vec!["-c".to_owned(), line.to_owned()];
        Self { name: line.to_owned(), file: "sh".into(), arguments, limit }
    }
}

/// A running plant.
#[derive(Debug)]
pub struct PlantProcess {
    name: String,
    group: ChildGroup,
    commands: ChildStdin,
    answers: ChildStdout,
    /// What has come of the answer.
    received: Vec<u8>,
    limit: Duration,
    stop: Stop,
}

impl PlantProcess {
    /// Starts the program.
    ///
    /// # Errors
    /// It cannot be started.
    pub fn start(program: &Program, stop: &Stop) -> Result<Self, PlantError> {
        let mut command = Command::new(&program.file);
        command.args(&program.arguments).stdin(Stdio::piped()).stdout(Stdio::piped());
        let started = ChildGroup::spawn(&mut command).and_then(|mut group| match group.pipes() {
            (Some(commands), Some(answers)) => Ok((group, commands, answers)),
            _ => Err(io::ErrorKind::BrokenPipe.into()),
        });
        let name = program.name.clone();
        match started {
            Ok((group, commands, answers)) => Ok(Self {
                name,
                group,
                commands,
                answers,
                received: Vec::new(),
                limit: program.limit,
                stop: stop.clone(),
            }),
            Err(error) => Err(PlantError { plant: name, time_s: 0.0, problem: Problem::NotStarted(error) }),
        }
    }

    /// What it said on its standard error so far.
    pub fn messages(&self) -> String {
        self.group.messages()
    }

    /// Asks, and takes the answer, which is of the form `wanted`.
    fn ask<R>(
        &mut self,
        question: &str,
        read: impl FnOnce(&[u8]) -> Option<R>,
        wanted: &'static str,
    ) -> Result<R, Problem> {
        if !self.received.is_empty() {
            return Err(Problem::Unasked(String::from_utf8_lossy(&self.received).trim_end().to_owned()));
        }
        let deadline = Instant::now() + self.limit;
        wait(&self.commands, PollFlags::OUT, deadline, self)?;
        if self.commands.write_all(question.as_bytes()).is_err() {
            return Err(Problem::Ended(self.group.end()));
        }
        loop {
            if let Some(end) = self.received.iter().position(|&byte| byte == b'\n') {
                let line: Vec<u8> = self.received.drain(..=end).collect();
                let said = || String::from_utf8_lossy(&line).trim_end().to_owned();
                return read(&line).ok_or_else(|| Problem::Answer(said(), wanted));
            }
            if self.received.len() > LONGEST_ANSWER {
                return Err(Problem::TooLong);
            }
            wait(&self.answers, PollFlags::IN, deadline, self)?;
            let mut bytes = [0; LONGEST_ANSWER];
            match self.answers.read(&mut bytes)? {
                0 => return Err(Problem::Ended(self.group.end())),
                count => self.received.extend_from_slice(&bytes[..count]),
            }
        }
    }
}

impl Plant for PlantProcess {
    fn advance(&mut self, time_s: f64, command_bar: f32) -> Result<Measurement, PilError> {
        let wanted = "pressure_bar contraction_mm [load_n temperature_c]";
        let answer = self.ask(&format!("{time_s} {command_bar}\n"), measurement, wanted);
        Ok(answer.map_err(|problem| PlantError { plant: self.name.clone(), time_s, problem })?)
    }
}

impl JointPlant for PlantProcess {
    fn advance(&mut self, time_s: f64, [a, b]: [f32; 2]) -> Result<JointMeasured, PilError> {
        let wanted = "pressure_a_bar pressure_b_bar angle_deg";
        let answer = self.ask(&format!("{time_s} {a} {b}\n"), of_joint, wanted);
        Ok(answer.map_err(|problem| PlantError { plant: self.name.clone(), time_s, problem })?)
    }
}

/// Waits until a pipe of the plant can be used, or has been closed.
fn wait(pipe: &impl AsFd, use_as: PollFlags, deadline: Instant, plant: &PlantProcess) -> Result<(), Problem> {
    let slice = Timespec { tv_sec: 0, tv_nsec: WAIT_SLICE.subsec_nanos().into() };
    loop {
        match poll(&mut [PollFd::new(pipe, use_as)], Some(&slice)) {
            Ok(0) | Err(rustix::io::Errno::INTR) => {}
            Ok(_) => return Ok(()),
            Err(error) => return Err(Problem::Io(error.into())),
        }
        if plant.stop.is_requested() {
            return Err(Problem::Stopped);
        }
        if Instant::now() > deadline {
            return Err(Problem::Late(plant.limit.as_secs_f64()));
        }
    }
}

/// What an answer says; `None` if it is not two or four finite numbers.
pub fn measurement(line: &[u8]) -> Option<Measurement> {
    match *numbers(line)? {
        [pressure_bar, contraction_mm] => {
            Some(Measurement { pressure_bar, contraction_mm, surroundings: Surroundings::default() })
        }
        [pressure_bar, contraction_mm, load_n, temperature_c] => {
            let surroundings = Surroundings { load: Some(load_n), temperature: Some(temperature_c) };
            Some(Measurement { pressure_bar, contraction_mm, surroundings })
        }
        _ => None,
    }
}

/// What a joint's answer says; `None` if it is not three finite numbers.
fn of_joint(line: &[u8]) -> Option<JointMeasured> {
    match *numbers(line)? {
        [a, b, angle_deg] => Some(JointMeasured { pressures_bar: [a, b], angle_deg }),
        _ => None,
    }
}

/// The numbers of an answer, all finite.
fn numbers(line: &[u8]) -> Option<Vec<f64>> {
    std::str::from_utf8(line)
        .ok()?
        .split_whitespace()
        .map(|field| field.parse().ok().filter(|number: &f64| number.is_finite()))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_is_two_numbers_or_four() {
        let none = Surroundings::default();
        let both = Surroundings { load: Some(30.0), temperature: Some(21.5) };
        for (answer, surroundings) in [("1.5 -2", none), ("  1.5\t-2 30 21.5\r", both)] {
            let expected = Measurement { pressure_bar: 1.5, contraction_mm: -2.0, surroundings };
            assert_eq!(measurement(answer.as_bytes()).expect(answer), expected);
        }
    }

    #[test]
    fn what_is_no_answer_is_none() {
        for answer in ["", "1", "1 2 3", "1 2 3 4 5", "1,2", "nan 2", "1 inf", "hello there", "1 2 3 x"] {
            assert_eq!(measurement(answer.as_bytes()), None, "{answer}");
        }
    }
}
