//! The CSV files the rig writes: recordings of the plant, and references to track.
//!
//! Comment lines say how the file was made, then comes the header. Times are rounded to 1 µs, pressures to
//! 0.1 mbar, contractions to 0.1 µm: a tenth of the noise and less.

use std::f64::consts::TAU;
use std::io::{self, Write};

use crate::plant::Plant;
use crate::protocol::Protocol;

/// Plays `protocol` on `plant` at `rate_hz` and writes `time_s,command_bar,pressure_bar,contraction_mm`.
///
/// `made_by` are the comment lines, without their mark.
///
/// # Errors
/// `out` refuses.
pub fn write_recording(
    out: &mut dyn Write,
    made_by: &[String],
    protocol: &Protocol,
    plant: &mut Plant,
    rate_hz: f64,
) -> io::Result<()> {
    write_head(out, made_by, "time_s,command_bar,pressure_bar,contraction_mm")?;
    let mut last_s = 0.0;
    for time_s in instants_s(protocol.duration_s(), rate_hz) {
        let command_bar = protocol.command_bar(time_s);
        let measured = plant.step(command_bar, time_s - last_s);
        last_s = time_s;
        let (pressure_bar, contraction_mm) = (measured.pressure_bar, measured.contraction_mm);
        writeln!(
            out,
            "{},{},{},{}",
            rounded(time_s, 1e6),
            rounded(command_bar, 1e4),
            rounded(pressure_bar, 1e4),
            rounded(contraction_mm, 1e4)
        )?;
    }
    Ok(())
}

/// Writes `time_s,reference_mm`: a raised cosine from 0 and back for each of `amplitudes_mm` (its peak), each
/// of `period_s`.
pub fn write_reference(
    out: &mut dyn Write,
    made_by: &[String],
    amplitudes_mm: &[f64],
    period_s: f64,
    rate_hz: f64,
) -> io::Result<()> {
    write_head(out, made_by, "time_s,reference_mm")?;
    for time_s in instants_s(period_s * amplitudes_mm.len() as f64, rate_hz) {
        let period = (time_s / period_s) as usize;
        // The last instant ends the last period.
        let amplitude_mm = amplitudes_mm.get(period).copied().unwrap_or_default();
        let reference_mm = 0.5 * amplitude_mm * (1.0 - (TAU * time_s / period_s).cos());
        writeln!(out, "{},{}", rounded(time_s, 1e6), rounded(reference_mm, 1e4))?;
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

    fn columns(csv: &[u8]) -> Vec<(f64, f64)> {
        let text = std::str::from_utf8(csv).unwrap();
        let number = |field: Option<&str>| field.unwrap().parse().unwrap();
        let rows = text.lines().filter(|line| !line.starts_with(['#', 't']));
        rows.map(|row| row.split(',')).map(|mut row| (number(row.next()), number(row.next()))).collect()
    }

    #[test]
    fn reference_rises_to_each_amplitude_and_returns_to_zero() {
        let mut csv = Vec::new();
        write_reference(&mut csv, &["how".to_owned()], &[110.0, 80.0], 20.0, 100.0).unwrap();
        assert!(csv.starts_with(b"# how\ntime_s,reference_mm\n0,0\n"));
        let rows = columns(&csv);
        assert_eq!(rows.len(), 4001);
        for (row, expected) in [
            (0, (0.0, 0.0)),
            (500, (5.0, 55.0)),
            (1000, (10.0, 110.0)),
            (2000, (20.0, 0.0)),
            (3000, (30.0, 80.0)),
            (4000, (40.0, 0.0)),
        ] {
            assert_eq!(rows[row], expected);
        }
    }
}
