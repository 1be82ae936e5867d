//! What is said of drop-outs.

use serde_json::{Value, json};

use super::DropOut;

/// So many are listed for people; programs get all.
const LISTED: usize = 5;

/// A sentence without its full stop, for people; None where there are none.
pub fn in_words(drop_outs: &[DropOut]) -> Option<String> {
    let samples: usize = drop_outs.iter().map(|drop_out| drop_out.samples.len()).sum();
    let listed: Vec<String> = drop_outs.iter().take(LISTED).map(DropOut::in_words).collect();
    let more = match drop_outs.len().saturating_sub(LISTED) {
        0 => String::new(),
        more => format!("; and {more} more"),
    };
    let places = if drop_outs.len() == 1 { "one place" } else { &format!("{} places", drop_outs.len()) };
    let are = if samples == 1 { "1 sample is".to_owned() } else { format!("{samples} samples are") };
    (samples > 0)
        .then(|| format!("{are} no measurement and left out, in {places}: {}{more}", listed.join("; ")))
}

/// For programs.
pub fn to_json(drop_outs: &[DropOut]) -> Value {
    let each = drop_outs.iter().map(|drop_out| {
        let DropOut { channel, samples, time_s, lines, values, .. } = drop_out;
        json!({
            "column": channel.name,
            "samples": samples.len(),
            "first_row": samples.start,
            "from_s": time_s.0,
            "to_s": time_s.1,
            "first_line": lines.0,
            "last_line": lines.1,
            "lowest": values.0,
            "highest": values.1,
        })
    });
    Value::Array(each.collect())
}

impl DropOut {
    fn in_words(&self) -> String {
        let Self { channel, time_s, lines, values, .. } = self;
        let values = if values.0 == values.1 {
            format!("{} {}", values.0, channel.unit)
        } else {
            format!("{} to {} {}", values.0, values.1, channel.unit)
        };
        let places = if lines.0 == lines.1 {
            format!("line {} ({:.3} s)", lines.0, time_s.0)
        } else {
            format!("lines {} to {} ({:.3} to {:.3} s)", lines.0, lines.1, time_s.0, time_s.1)
        };
        format!("{} is {values} in {places}", channel.name)
    }
}
