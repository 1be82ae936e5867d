//! Runs of the emulated firmware with a plant that is a program, side by side.

use std::panic::resume_unwind;
use std::path::Path;
use std::thread;

use model_core::Mode;
use wire::{Configuration, Protection, Request, Response};

use super::lock_step::{self, Board, Run};
use super::plant::{PlantProcess, Program};
use super::reference::Reference;
use super::{PilError, preview_s};
use crate::emulator::Emulator;
use crate::stop::Stop;

impl Board for Emulator {
    fn request(&mut self, request: &Request) -> Result<Response, PilError> {
        Ok(Self::request(self, request)?)
    }
}

/// What the three runs have in common.
#[derive(Debug)]
pub struct Bench<'a> {
    /// The firmware's ELF file.
    pub firmware: &'a Path,
    /// For the board.
    pub configuration: &'a Configuration,
    /// By which limits it protects the plant.
    pub protection: Protection,
    /// What starts a plant.
    pub plant: &'a Program,
    /// What is to be tracked.
    pub reference: &'a Reference,
    /// Asked to stop by whoever wants the runs to end, and by a run that fails.
    pub stop: Stop,
}

/// A finished run with what firmware and plant said.
#[derive(Debug)]
pub struct Finished {
    /// The run.
    pub run: Run,
    /// The firmware's log, a line an entry.
    pub log: String,
    /// What the plant said on its standard error.
    pub plant_messages: String,
}

/// Runs that did not all come to their end.
#[derive(Debug)]
pub struct Broken {
    /// The first one's reason; [`PilError::Stopped`] when a stop was requested from outside.
    pub problem: Box<PilError>,
    /// What each has come to, one a mode.
    pub runs: Vec<Run>,
}

/// What firmware and plant had to say.
type Words = (String, String);

impl Bench<'_> {
    /// The runs of the given modes, side by side; `ticked` is called after each tick of each.
    ///
    /// # Errors
    /// A run has failed, and has stopped the others, or a stop was requested from outside.
    pub fn run(&self, modes: &[Mode], ticked: &(dyn Fn() + Sync)) -> Result<Vec<Finished>, Broken> {
        let (runs, ends): (Vec<Run>, Vec<Result<Words, PilError>>) = thread::scope(|scope| {
            let threads: Vec<_> =
                modes.iter().map(|&mode| scope.spawn(move || self.run_one(mode, ticked))).collect();
            threads
                .into_iter()
                .map(|thread| thread.join().unwrap_or_else(|panic| resume_unwind(panic)))
                .unzip()
        });
        let (mut words, mut problems) = (Vec::new(), Vec::new());
        for end in ends {
            match end {
                Ok(said) => words.push(said),
                Err(problem) => problems.push(problem),
            }
        }
        // A run that was stopped because of another one knows no reason.
        let reason = problems.iter().position(|problem| !matches!(problem, PilError::Stopped)).unwrap_or(0);
        if !problems.is_empty() {
            return Err(Broken { problem: Box::new(problems.swap_remove(reason)), runs });
        }
        let finished = |(run, (log, plant_messages))| Finished { run, log, plant_messages };
        Ok(runs.into_iter().zip(words).map(finished).collect())
    }

    /// One run as far as it comes, and how it ends.
    fn run_one(&self, mode: Mode, ticked: &dyn Fn()) -> (Run, Result<Words, PilError>) {
        let mut run = Run { samples: Vec::new(), overruns: 0 };
        let end = self.try_run(mode, &mut run, ticked).map_err(|problem| {
            self.stop.request();
            match problem {
                PilError::Stopped => PilError::Stopped,
                problem => PilError::Run { mode, problem: Box::new(problem) },
            }
        });
        (run, end)
    }

    fn try_run(&self, mode: Mode, run: &mut Run, ticked: &dyn Fn()) -> Result<Words, PilError> {
        let mut plant = PlantProcess::start(self.plant, &self.stop)?;
        let mut board = Emulator::start(self.firmware, &self.stop)?;
        lock_step::protect(&mut board, self.protection)?;
        run.overruns = lock_step::track(
            &mut board,
            &mut plant,
            self.configuration,
            mode,
            self.reference.samples(preview_s(self.configuration)),
            &mut run.samples,
            ticked,
        )?;
        Ok((board.log(), plant.messages()))
    }
}
