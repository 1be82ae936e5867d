//! The columns of a recording that a diagnosis looks at.

use recording::Recording;
use recording::table::Table;
use recording::unit::Unit;

use super::Columns;

impl Columns {
    /// Those of a recording from a table: load, temperature and, beside a pressure, the command
    /// where they are there; a noisy input is smoothed, in the recording too. What was done is
    /// noted in the recording.
    pub fn of(table: &Table, recording: &mut Recording) -> Self {
        let mut notes = Vec::new();
        let mut column = |name: &str, unit: Unit| match recording.drive.beside(table, name, unit) {
            Ok(found) => found.map(|found| {
                notes.extend(found.note);
                found.values
            }),
            Err(why) => {
                notes.push(format!("{name} is not used: {why}"));
                None
            }
        };
        let (load_n, temperature_c) = (column("load_n", Unit::N), column("temperature_c", Unit::CELSIUS));
        let input_is_command = recording.drive.input.channel.name.starts_with("command");
        let input_unit = recording.drive.input.channel.unit;
        let command = if input_is_command {
            None
        } else {
            column(&format!("command_{}", input_unit.suffix()), input_unit)
        };
        recording.drive.notes.extend(notes);
        let Recording { drive, output, left_out } = &*recording;
        let columns = Self {
            command,
            load_n,
            temperature_c,
            time_s: drive.time_s.clone(),
            input: drive.input.values.clone(),
            input_unit: drive.input.channel.unit,
            output_unit: output.channel.unit,
            input_is_command,
            output: output.values.clone(),
            scored: drive.scored.clone(),
            past_unknown_until_s: left_out.past_unknown_until_s(),
            drop_outs: left_out.drop_outs.clone(),
            smoothing: None,
            measured_input: None,
        }
        .with_smooth_input();
        recording.drive.input.values.clone_from(&columns.input);
        columns
    }
}
