//! Recordings of a joint as CSV.

use std::io::{self, Write};

use super::JointPlant;
use super::protocol::JointProtocol;

/// Rows a second, Hz: five in the lag of a regulator.
pub const RATE_HZ: f64 = 100.0;

/// The columns.
const HEADER: &str = "time_s,command_a_bar,command_b_bar,pressure_a_bar,pressure_b_bar,angle_deg,\
                      torque_newton_metre,valid";

/// Plays a protocol on a joint and writes a row at each of `rate_hz` instants a second. `made_by`
/// are the comment lines, without their mark.
///
/// # Errors
/// `out` refuses.
pub fn record(
    out: &mut dyn Write,
    made_by: &[String],
    protocol: &JointProtocol,
    joint: &mut JointPlant,
    rate_hz: f64,
) -> io::Result<()> {
    for line in made_by {
        writeln!(out, "# {line}")?;
    }
    writeln!(out, "{HEADER}")?;
    let count = (protocol.duration_s() * rate_hz).round() as u64;
    let mut last_s = 0.0;
    for instant in 0..=count {
        let time_s = instant as f64 / rate_hz;
        let ([a, b], load_nm) = (protocol.commands_bar(time_s), protocol.load_nm(time_s));
        joint.put_on(load_nm);
        let measured = joint.step([a, b], time_s - last_s);
        last_s = time_s;
        let [pressure_a, pressure_b] = measured.pressures_bar;
        let (angle, valid) = (measured.angle_deg, u8::from(protocol.counts(time_s)));
        writeln!(
            out,
            "{time_s:.6},{a:.4},{b:.4},{pressure_a:.4},{pressure_b:.4},{angle:.4},{load_nm:.4},{valid}"
        )?;
    }
    Ok(())
}
