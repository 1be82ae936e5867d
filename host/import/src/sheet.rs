//! A sheet of a spreadsheet as text, fields separated by tabs, so that it is read as a logger's
//! file is: rows of units, repeated headers and comments too.

use std::fs::File;
use std::io::{Cursor, Read};
use std::sync::Arc;

use calamine::{Data, Reader, open_workbook_auto_from_rs};
use recording::input::FromPlace;

use super::Problem;

/// The text of a sheet, by default the first.
///
/// # Errors
/// The file is damaged; there is no such sheet.
pub fn text(file: &Arc<File>, sheet: Option<&str>) -> Result<String, Problem> {
    let mut bytes = Vec::new();
    FromPlace::new(file, 0).read_to_end(&mut bytes)?;
    let damaged = |error: calamine::Error| Problem::Damaged(error.to_string());
    let mut book = open_workbook_auto_from_rs(Cursor::new(bytes)).map_err(damaged)?;
    let names = book.sheet_names();
    let name = match sheet {
        Some(wanted) if names.iter().any(|name| name == wanted) => wanted.to_owned(),
        Some(wanted) => {
            return Err(Problem::NoSheet { wanted: wanted.to_owned(), present: names.join(", ") });
        }
        None => names.first().ok_or(Problem::Nothing)?.clone(),
    };
    let range = book.worksheet_range(&name).map_err(damaged)?;
    let mut text = String::new();
    for row in range.rows() {
        let fields: Vec<String> = row.iter().map(field).collect();
        text += &fields.join("\t");
        text.push('\n');
    }
    Ok(text)
}

/// A cell as a logger writes it; numbers so that they read back as the same bits.
fn field(cell: &Data) -> String {
    match cell {
        Data::Int(value) => value.to_string(),
        Data::Float(value) => value.to_string(),
        Data::Bool(value) => u8::from(*value).to_string(),
        Data::String(text) | Data::DateTimeIso(text) | Data::DurationIso(text) => {
            text.replace(['\t', '\n', '\r'], " ")
        }
        Data::DateTime(time) => {
            let (year, month, day, hour, minute, second, milli) = time.to_ymd_hms_milli();
            format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}.{milli:03}")
        }
        Data::Error(_) | Data::Empty => String::new(),
        // What a later version of the reader tells apart is nothing that we know.
        #[allow(unreachable_patterns, reason = "the list of kinds may grow")]
        _ => String::new(),
    }
}
