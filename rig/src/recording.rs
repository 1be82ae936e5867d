//! The CSV files the rig writes: recordings of the plant, and references to track.
//!
//! Comment lines say how the file was made, then comes the header. Times are rounded to 1 µs,
//! pressures to 0.1 mbar, contractions to 0.1 µm, loads to 1 mN and temperatures to 1 mK: a tenth
//! of the noise and less.

use std::f64::consts::TAU;
use std::io::{self, Write};

use crate::plant::Plant;
use crate::protocol::Protocol;
use crate::sensor::{Columns, Measurement};

/// One row of a recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// Time, s.
    pub time_s: f64,
    /// Command, held since the row before, bar.
    pub command_bar: f64,
    /// What the sensors say.
    pub measured: Measurement,
}

/// Plays `protocol` on `plant` at `rate_hz`: the rows, rounded as in a file.
pub fn record<'a>(
    protocol: &'a Protocol,
    plant: &'a mut Plant,
    rate_hz: f64,
) -> impl Iterator<Item = Row> + 'a {
    let mut last_s = 0.0;
    instants_s(protocol.duration_s(), rate_hz).map(move |time_s| {
        let command_bar = protocol.command_bar(time_s);
        let measured = plant.step(command_bar, time_s - last_s);
        last_s = time_s;
        Row { time_s, command_bar, measured }.rounded()
    })
}

impl Row {
    /// As it is in a file.
    pub(crate) fn rounded(self) -> Self {
        let Self { time_s, command_bar, measured } = self;
        Self {
            time_s: rounded(time_s, 1e6),
            command_bar: rounded(command_bar, 1e4),
            measured: Measurement {
                pressure_bar: rounded(measured.pressure_bar, 1e4),
                contraction_mm: rounded(measured.contraction_mm, 1e4),
                load_n: rounded(measured.load_n, 1e3),
                temperature_c: rounded(measured.temperature_c, 1e3),
            },
        }
    }
}

/// Writes the rows of a recording as `time_s,command_bar,pressure_bar,contraction_mm`, and
/// `load_n,temperature_c` where asked for.
///
/// `made_by` are the comment lines, without their mark.
///
/// # Errors
/// `out` refuses.
pub fn write_recording(
    out: &mut dyn Write,
    made_by: &[String],
    rows: impl Iterator<Item = Row>,
    columns: Columns,
) -> io::Result<()> {
    let all = columns == Columns::All;
    let further = if all { ",load_n,temperature_c" } else { "" };
    write_head(out, made_by, &format!("time_s,command_bar,pressure_bar,contraction_mm{further}"))?;
    for Row { time_s, command_bar, measured } in rows {
        let Measurement { pressure_bar, contraction_mm, load_n, temperature_c } = measured;
        write!(out, "{time_s},{command_bar},{pressure_bar},{contraction_mm}")?;
        if all {
            write!(out, ",{load_n},{temperature_c}")?;
        }
        writeln!(out)?;
    }
    Ok(())
}

/// A reference to track: raised cosines of one period between a trough and a peak each, rising from
/// 0 at first.
#[derive(Debug, Clone)]
pub struct RaisedCosines {
    /// Peak of each, mm.
    pub peaks_mm: Vec<f64>,
    /// Where each ends and the next begins, mm. A muscle that has contracted does not come back to
    /// 0 mm by itself.
    pub trough_mm: f64,
    /// Period of each, s.
    pub period_s: f64,
}

impl RaisedCosines {
    /// The reference at `time_s`, mm.
    fn at_mm(&self, time_s: f64) -> f64 {
        let period = (time_s / self.period_s) as usize;
        let Some(peak_mm) = self.peaks_mm.get(period) else { return self.trough_mm };
        let phase = time_s / self.period_s - period as f64;
        let foot_mm = if period == 0 && phase < 0.5 { 0.0 } else { self.trough_mm };
        foot_mm + (peak_mm - foot_mm) * 0.5 * (1.0 - (TAU * phase).cos())
    }
}

/// Writes `time_s,reference_mm` at `rate_hz`, with comment lines as in [`write_recording`].
///
/// # Errors
/// `out` refuses.
pub fn write_reference(
    out: &mut dyn Write,
    made_by: &[String],
    reference: &RaisedCosines,
    rate_hz: f64,
) -> io::Result<()> {
    write_head(out, made_by, "time_s,reference_mm")?;
    for time_s in instants_s(reference.period_s * reference.peaks_mm.len() as f64, rate_hz) {
        writeln!(out, "{},{}", rounded(time_s, 1e6), rounded(reference.at_mm(time_s), 1e4))?;
    }
    Ok(())
}

fn write_head(out: &mut dyn Write, made_by: &[String], header: &str) -> io::Result<()> {
    for line in made_by {
        writeln!(out, "# {line}")?;
    }
    writeln!(out, "{header}")
}

/// The instants from 0 to `duration_s`, both included.
fn instants_s(duration_s: f64, rate_hz: f64) -> impl Iterator<Item = f64> {
    let count = (duration_s * rate_hz).round() as u64;
    (0..=count).map(move |instant| instant as f64 / rate_hz)
}

/// `value` to one part in `parts` of its unit; never a negative zero.
fn rounded(value: f64, parts: f64) -> f64 {
    (value * parts).round() / parts + 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reference_starts_at_zero_and_runs_between_trough_and_peaks() {
        let reference = RaisedCosines { peaks_mm: vec![110.0, 80.0], trough_mm: 10.0, period_s: 20.0 };
        let turns =
            [(0.0, 0.0), (5.0, 55.0), (10.0, 110.0), (15.0, 60.0), (20.0, 10.0), (30.0, 80.0), (40.0, 10.0)];
        for (time_s, expected_mm) in turns {
            assert!((reference.at_mm(time_s) - expected_mm).abs() < 1e-9, "at {time_s} s");
        }
    }

    #[test]
    fn reference_file_says_how_it_was_made_and_has_both_ends() {
        let reference = RaisedCosines { peaks_mm: vec![100.0], trough_mm: 0.0, period_s: 2.0 };
        let mut csv = Vec::new();
        write_reference(&mut csv, &["how".to_owned()], &reference, 2.0).unwrap();
        let expected = "# how\ntime_s,reference_mm\n0,0\n0.5,50\n1,100\n1.5,50\n2,0\n";
        assert_eq!(String::from_utf8(csv).unwrap(), expected);
    }
}
