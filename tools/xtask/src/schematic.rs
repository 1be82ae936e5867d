//! `docs/schematic.svg`: the board's analogue front ends and outputs, with the values of the
//! netlist `hardware/board.cir`.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;

use anyhow::{Context, Result, ensure};

use crate::run;

const NETLIST: &str = "hardware/board.cir";
const DRAWING: &str = "docs/schematic.svg";
/// Unit: px.
const SIZE: [i32; 2] = [900, 850];
/// Half the length of a part. Unit: px.
const HALF: i32 = 24;

/// Draws it, or only compares.
///
/// # Errors
/// The netlist lacks a part that is drawn, or the drawing differs from the one that is there.
pub fn schematic(check: bool) -> Result<()> {
    let text = drawn(&fs::read_to_string(run::root().join(NETLIST)).context(NETLIST)?)?;
    let path = run::root().join(DRAWING);
    if check {
        let is_current = fs::read_to_string(&path).is_ok_and(|found| found == text);
        ensure!(is_current, "{DRAWING} is out of date: cargo xtask figures");
        return Ok(());
    }
    fs::write(&path, text).with_context(|| format!("cannot write {DRAWING}"))
}

/// The values of the netlist's parts by their references; of one with a tolerance the value alone.
fn values(netlist: &str) -> BTreeMap<&str, &str> {
    let parts = netlist.lines().filter(|line| line.starts_with(['R', 'C', 'D', 'X']));
    parts
        .filter_map(|line| {
            let (reference, rest) = line.split_once(' ')?;
            let value = match rest.split_once('{') {
                Some((_, expression)) => expression.split_whitespace().next()?,
                None => rest.split_whitespace().last()?,
            };
            Some((reference, value))
        })
        .collect()
}

/// What is drawn, and the values that are written beside it.
struct Sheet<'a> {
    svg: String,
    values: BTreeMap<&'a str, &'a str>,
}

/// A place. Unit: px.
type At = (i32, i32);

impl Sheet<'_> {
    fn line(&mut self, points: &[At]) {
        let points: Vec<String> = points.iter().map(|(x, y)| format!("{x},{y}")).collect();
        let _ = writeln!(self.svg, r#"<polyline points="{}"/>"#, points.join(" "));
    }

    fn text(&mut self, (x, y): At, anchor: &str, text: &str) {
        let _ = writeln!(self.svg, r#"<text x="{x}" y="{y}" text-anchor="{anchor}">{text}</text>"#);
    }

    fn title(&mut self, (x, y): At, text: &str) {
        let _ = writeln!(self.svg, r#"<text class="title" x="{x}" y="{y}">{text}</text>"#);
    }

    fn dot(&mut self, (x, y): At) {
        let _ = writeln!(self.svg, r#"<circle cx="{x}" cy="{y}" r="3"/>"#);
    }

    /// A place that something else is connected to.
    fn terminal(&mut self, at: At, is_left: bool, text: &str) {
        let (x, y) = at;
        let _ = writeln!(self.svg, r#"<circle class="open" cx="{x}" cy="{y}" r="4"/>"#);
        let (x, anchor) = if is_left { (x - 10, "end") } else { (x + 10, "start") };
        self.text((x, y + 5), anchor, text);
    }

    fn ground(&mut self, (x, y): At) {
        for (half, below) in [(12, 0), (8, 5), (4, 10)] {
            self.line(&[(x - half, y + below), (x + half, y + below)]);
        }
    }

    /// Reference and value.
    fn label(&mut self, at: At, anchor: &str, reference: &str) -> Result<()> {
        let value = *self.values.get(reference).with_context(|| format!("{NETLIST} has no {reference}"))?;
        let unit = match reference.chars().next() {
            Some('R') => "Ω",
            Some('C') => "F",
            _ => "",
        };
        let value = if unit.is_empty() { String::new() } else { format!(" {value}{unit}") };
        self.text(at, anchor, &format!("{reference}{value}"));
        Ok(())
    }

    /// Between two places of one height, at their middle.
    fn resistor(&mut self, (x, y): At, to_x: i32, reference: &str) -> Result<()> {
        let middle = (x + to_x) / 2;
        let _ = writeln!(
            self.svg,
            r#"<rect x="{}" y="{}" width="{}" height="16"/>"#,
            middle - HALF,
            y - 8,
            2 * HALF
        );
        self.line(&[(x, y), (middle - HALF, y)]);
        self.line(&[(middle + HALF, y), (to_x, y)]);
        self.label((middle, y - 14), "middle", reference)
    }

    /// From a place down to ground.
    fn resistor_to_ground(&mut self, (x, y): At, reference: &str) -> Result<()> {
        self.dot((x, y));
        let _ =
            writeln!(self.svg, r#"<rect x="{}" y="{}" width="16" height="{}"/>"#, x - 8, y + 20, 2 * HALF);
        self.line(&[(x, y), (x, y + 20)]);
        self.line(&[(x, y + 20 + 2 * HALF), (x, y + 88)]);
        self.ground((x, y + 88));
        self.label((x + 14, y + 50), "start", reference)
    }

    fn capacitor_to_ground(&mut self, (x, y): At, reference: &str) -> Result<()> {
        self.dot((x, y));
        self.line(&[(x, y), (x, y + 40)]);
        self.line(&[(x - 14, y + 40), (x + 14, y + 40)]);
        self.line(&[(x - 14, y + 48), (x + 14, y + 48)]);
        self.line(&[(x, y + 48), (x, y + 88)]);
        self.ground((x, y + 88));
        self.label((x + 18, y + 66), "start", reference)
    }

    /// In a line, conducting to the right.
    fn diode(&mut self, (x, y): At, to_x: i32, reference: &str) -> Result<()> {
        let middle = (x + to_x) / 2;
        self.line(&[(x, y), (to_x, y)]);
        self.line(&[(middle - 8, y - 9), (middle - 8, y + 9), (middle + 8, y), (middle - 8, y - 9)]);
        self.line(&[(middle + 8, y - 9), (middle + 8, y + 9)]);
        self.label((middle, y - 16), "middle", reference)
    }

    fn sensor_input(&mut self, y: i32) -> Result<()> {
        self.title(
            (30, y),
            "Sensors: pressure PA0, contraction PA1, supply pressure PC0, the same three times",
        );
        let y = y + 50;
        self.terminal((150, y), true, "sensor");
        self.resistor((154, y), 300, "R1")?;
        self.line(&[(300, y), (426, y)]);
        self.capacitor_to_ground((330, y), "C1")?;
        self.terminal((430, y), false, "PA0, PA1, PC0");
        Ok(())
    }

    fn output_stage(&mut self, y: i32) -> Result<()> {
        self.title((30, y), "Set point of the regulator: PA4, 0 to 3.3 V, becomes 0 to 10 V");
        let y = y + 50;
        self.terminal((100, y), true, "PA4");
        self.line(&[(104, y), (400, y)]);
        self.resistor_to_ground((150, y), "R4")?;
        self.capacitor_to_ground((260, y), "C4")?;
        // The amplifier, its feedback below it.
        self.line(&[(400, y - 20), (400, y + 60), (470, y + 20), (400, y - 20)]);
        self.text((408, y + 5), "start", "+");
        self.text((408, y + 46), "start", "-");
        self.text((400, y - 32), "start", "X1: +12 V, -0.23 V");
        self.line(&[(400, y + 40), (370, y + 40), (370, y + 100)]);
        self.resistor((370, y + 100), 480, "R6")?;
        self.resistor((480, y + 100), 590, "R7")?;
        self.line(&[(590, y + 100), (590, y + 20)]);
        self.dot((590, y + 20));
        self.resistor_to_ground((370, y + 100), "R5")?;
        self.line(&[(470, y + 20), (590, y + 20)]);
        self.resistor((590, y + 20), 700, "R8")?;
        self.line(&[(700, y + 20), (766, y + 20)]);
        self.capacitor_to_ground((710, y + 20), "C5")?;
        self.terminal((770, y + 20), false, "set point +");
        Ok(())
    }

    fn charge_pump(&mut self, y: i32) -> Result<()> {
        self.title((30, y), "Dump valve: PB13 changes in each tick, and only that keeps it closed");
        let y = y + 50;
        self.terminal((100, y), true, "PB13");
        self.line(&[(104, y), (190, y)]);
        self.resistor_to_ground((140, y), "R9")?;
        self.resistor((190, y), 290, "R10")?;
        self.line(&[(290, y), (316, y)]);
        self.line(&[(316, y - 14), (316, y + 14)]);
        self.line(&[(324, y - 14), (324, y + 14)]);
        self.label((320, y - 22), "middle", "C6")?;
        self.line(&[(324, y), (490, y)]);
        self.resistor_to_ground((350, y), "R13")?;
        self.dot((470, y));
        // From ground up.
        self.line(&[(470, y), (470, y + 88)]);
        self.line(&[(461, y + 52), (479, y + 52), (470, y + 36), (461, y + 52)]);
        self.line(&[(461, y + 36), (479, y + 36)]);
        self.label((486, y + 36), "start", "D1")?;
        self.ground((470, y + 88));
        self.diode((490, y), 550, "D2")?;
        self.line(&[(550, y), (770, y)]);
        self.capacitor_to_ground((560, y), "C7")?;
        self.resistor_to_ground((670, y), "R11")?;
        // The transistor, and what it switches.
        self.line(&[(770, y - 14), (770, y + 14)]);
        self.line(&[(778, y - 14), (778, y + 14)]);
        self.line(&[(778, y + 10), (800, y + 10), (800, y + 88)]);
        self.ground((800, y + 88));
        self.line(&[(778, y - 10), (800, y - 10), (800, y - 24)]);
        self.text((810, y + 6), "start", "Q1");
        self.text((880, y - 32), "end", "coil with D3, emergency stop, 24 V");
        Ok(())
    }

    fn kept_low(&mut self, y: i32) -> Result<()> {
        self.title(
            (30, y),
            "Low in a reset: PA6 (coil's driver), PA8 (bus's driver), the same twice; contacts; bus",
        );
        let y = y + 50;
        self.terminal((100, y), true, "PA6, PA8");
        self.line(&[(104, y), (226, y)]);
        self.resistor_to_ground((150, y), "R12")?;
        self.terminal((230, y), false, "driver");
        for (x, pin, contact) in [(440, "PB14", "emergency stop"), (640, "PB15", "coil without a voltage")] {
            self.terminal((x, y), true, pin);
            self.line(&[(x + 4, y), (x + 20, y), (x + 44, y - 10)]);
            self.line(&[(x + 46, y), (x + 60, y), (x + 60, y + 30)]);
            self.ground((x + 60, y + 30));
            self.text((x, y + 66), "start", contact);
        }
        self.text((440, y + 96), "start", "PA9, PA10, PA8: transceiver U2, 120 Ω at both ends of the bus");
        Ok(())
    }
}

fn drawn(netlist: &str) -> Result<String> {
    let [width, height] = SIZE;
    let mut sheet = Sheet { svg: String::new(), values: values(netlist) };
    sheet.sensor_input(30)?;
    sheet.output_stage(210)?;
    sheet.charge_pump(490)?;
    sheet.kept_low(680)?;
    Ok(format!(
        r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="14">
<!-- Made by `cargo xtask figures` from {NETLIST}. -->
<style>rect, polyline, .open {{ fill: none; stroke: black; stroke-width: 1.5 }} .open {{ fill: white }} .title {{ font-weight: bold }}</style>
<rect x="0" y="0" width="{width}" height="{height}" style="fill: white; stroke: none"/>
{}</svg>
"#,
        sheet.svg
    ))
}

#[cfg(test)]
mod tests {
    use super::{drawn, values};

    #[test]
    fn the_value_of_a_part_is_its_last_word_or_what_its_tolerance_is_of() {
        let values = values("* R9 x\nR1 a b 1k\nR6 a b {20k * (1 + r)}\n.model R3\nD1 0 a schottky");
        assert_eq!(values.get("R1"), Some(&"1k"));
        assert_eq!(values.get("R6"), Some(&"20k"));
        assert_eq!(values.get("D1"), Some(&"schottky"));
        assert_eq!(values.len(), 3);
    }

    #[test]
    fn a_part_that_the_netlist_lacks_is_not_drawn() {
        assert_eq!(drawn("R1 a b 1k").unwrap_err().to_string(), "hardware/board.cir has no C1");
    }
}
