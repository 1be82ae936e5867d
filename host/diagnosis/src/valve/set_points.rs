//! What a valve's lag is given: the command behind delay, dead band and supply.

use std::borrow::Cow;
use std::sync::OnceLock;

use super::BandForm;
use crate::delay::delayed;

/// How many times as fast as in the rows beside it a command moves where it jumps. A choice: a sine with more than six rows a period stays
/// below it. Unit: 1.
const JUMP: f64 = 2.0;

/// A command behind a delay, from which the set points with any dead band are made.
pub struct SetPoints<'a> {
    time_s: &'a [f64],
    commands: Cow<'a, [f64]>,
    /// Whether it comes to a row by a jump: asked for by one form of the band alone.
    jumps: OnceLock<Vec<bool>>,
}

impl<'a> SetPoints<'a> {
    /// Of a command. `delay_s`: s.
    pub fn of(time_s: &'a [f64], command: &'a [f64], delay_s: Option<f64>) -> Self {
        let commands = match delay_s {
            Some(delay_s) => Cow::Owned(delayed(command, time_s, delay_s)),
            None => Cow::Borrowed(command),
        };
        Self { time_s, commands, jumps: OnceLock::new() }
    }

    /// Behind a dead band and a supply, if they are there. Unit: of the pressure.
    pub fn through(&self, band: Option<(BandForm, f64)>, supply: Option<f64>) -> Vec<f64> {
        let mut values = match band {
            Some((form, band)) => self.banded(form, band),
            None => self.commands.to_vec(),
        };
        if let Some(supply) = supply {
            values.iter_mut().for_each(|value| *value = value.min(supply));
        }
        values
    }

    fn banded(&self, form: BandForm, band: f64) -> Vec<f64> {
        let mut held = self.commands.first().copied().unwrap_or(0.0);
        let jumps = || self.jumps.get_or_init(|| jumps(self.time_s, &self.commands));
        let all = self.commands.iter();
        match form {
            BandForm::Hold => all
                .map(|&command| {
                    if (command - held).abs() >= band {
                        held = command;
                    }
                    held
                })
                .collect(),
            BandForm::HoldBetween => {
                let mut before = held;
                all.zip(jumps())
                    .map(|(&command, &jumps)| {
                        let value;
                        (held, value) = match (command - held).abs() < band {
                            true => (held, held),
                            false if jumps => (command, command),
                            false => passed(held, band, (before, command)),
                        };
                        before = command;
                        value
                    })
                    .collect()
            }
            BandForm::Backlash => all
                .map(|&command| {
                    held = held.clamp(command - 0.5 * band, command + 0.5 * band);
                    held
                })
                .collect(),
        }
    }
}

/// What a band holds behind a row in which the command goes straight from one value to the other, and its mean over the row.
fn passed(held: f64, band: f64, (before, command): (f64, f64)) -> (f64, f64) {
    let step = band.copysign(command - held);
    let levels = ((command - held) / step) as usize;
    // What is left of the row when the command comes to a level.
    let left = |level: f64| ((command - level) / (command - before)).clamp(0.0, 1.0);
    let mean = held + (1..=levels).map(|level| step * left(held + level as f64 * step)).sum::<f64>();
    (held + levels as f64 * step, mean)
}

/// Whether a command comes to each row by a jump: it moves far faster than before and behind.
fn jumps(time_s: &[f64], command: &[f64]) -> Vec<bool> {
    let speed = |row: usize| {
        let last = row.checked_sub(1)?;
        Some((command.get(row)? - command[last]).abs() / (time_s[row] - time_s[last]))
    };
    let beside = |row: usize| {
        let before = row.checked_sub(1).and_then(speed).unwrap_or(0.0);
        before.max(speed(row + 1).unwrap_or(0.0))
    };
    (0..command.len()).map(|row| speed(row).is_some_and(|speed| speed > JUMP * beside(row))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_jumps_where_it_moves_far_faster_than_before_and_behind() {
        let time_s = [0.0, 0.01, 0.02, 0.05, 0.06, 0.07, 0.08, 0.09];
        // A row is lost between the third and the fourth; the jump is at the sixth; the triangle turns at the end.
        let command = [0.0, 0.1, 0.2, 0.5, 0.6, 1.2, 1.3, 1.2];
        let at: Vec<usize> =
            jumps(&time_s, &command).iter().enumerate().filter(|(_, j)| **j).map(|(row, _)| row).collect();
        assert_eq!(at, [5]);
    }
}
