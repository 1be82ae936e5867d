//! The plant protocol: a line of `time_s command_bar` in, a line of `pressure_bar contraction_mm`
//! out, with `load_n temperature_c` behind them where asked for.
//!
//! The first line sets the clock and finds the plant at rest. From then on a line says: this
//! command, from the previous time to this one; and the answer is what the sensors say at this
//! time. Numbers are written in the shortest form that reads back the same. The end of the input
//! ends the plant; a line that makes no sense is an error that names it.

use std::io::{BufRead, ErrorKind, Read, Write};

use anyhow::{Context, Result, bail, ensure};

use crate::plant::Plant;
use crate::sensor::Columns;

/// Longest line accepted, bytes: three numbers in any notation fit.
const LINE_LIMIT: usize = 256;

/// Answers every line of `input` on `output`, each flushed.
///
/// # Errors
/// A line that is not two finite numbers, or whose time is not after the previous one's; a broken
/// input or output.
pub fn serve(input: impl BufRead, output: impl Write, plant: &mut Plant, columns: Columns) -> Result<()> {
    answer_lines(input, output, ["command_bar"], |[command_bar], dt_s| {
        let measured = plant.step(command_bar, dt_s);
        let mut answer = format!("{} {}", measured.pressure_bar, measured.contraction_mm);
        if columns == Columns::All {
            answer += &format!(" {} {}", measured.load_n, measured.temperature_c);
        }
        answer
    })
}

/// The same of any plant: it gets the commands of these names, and for how long they hold (s).
pub(crate) fn answer_lines<const COMMANDS: usize>(
    mut input: impl BufRead,
    mut output: impl Write,
    names: [&str; COMMANDS],
    mut answer: impl FnMut([f64; COMMANDS], f64) -> String,
) -> Result<()> {
    let mut last_s = None;
    let mut line = Vec::with_capacity(LINE_LIMIT);
    for number in 1u64.. {
        line.clear();
        let length = input.by_ref().take(LINE_LIMIT as u64 + 1).read_until(b'\n', &mut line);
        if length.context("cannot read the commands")? == 0 {
            break;
        }
        let (time_s, commands) = parse(&line, names).with_context(|| format!("line {number}"))?;
        let start_s = last_s.replace(time_s).unwrap_or(time_s);
        ensure!(
            number == 1 || time_s > start_s,
            "line {number}: time_s is {time_s} s, not after the previous line's {start_s} s"
        );
        let answer = answer(commands, time_s - start_s) + "\n";
        match output.write_all(answer.as_bytes()).and_then(|()| output.flush()) {
            // A controller that has gone is the end, as the end of its commands is.
            Err(error) if error.kind() == ErrorKind::BrokenPipe => break,
            written => written.context("cannot answer")?,
        }
    }
    Ok(())
}

/// The time and the commands of a line.
fn parse<const COMMANDS: usize>(line: &[u8], names: [&str; COMMANDS]) -> Result<(f64, [f64; COMMANDS])> {
    ensure!(line.len() <= LINE_LIMIT, "longer than {LINE_LIMIT} bytes");
    let text = std::str::from_utf8(line).context("not text")?;
    let fields: Vec<&str> = text.split_whitespace().collect();
    if fields.len() != 1 + COMMANDS {
        let names = names.join(" ");
        bail!("{} numbers expected, `time_s {names}`, found {:?}", 1 + COMMANDS, text.trim_end());
    }
    let mut commands = [0.0; COMMANDS];
    for ((command, name), field) in commands.iter_mut().zip(names).zip(&fields[1..]) {
        *command = finite(name, field)?;
    }
    Ok((finite("time_s", fields[0])?, commands))
}

/// A finite number of a line.
fn finite(name: &str, field: &str) -> Result<f64> {
    match field.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => bail!("{name} is {field:?}, not a finite number"),
    }
}
