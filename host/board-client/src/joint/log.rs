//! The log of a run of a joint as CSV, and its figures.

use recording::figures::Figures;

use super::JointSample;

/// The columns of a log: its first line.
pub const COLUMNS: &str = "time_s,reference_deg,angle_deg,stiffness_nm_per_rad,command_a_bar,command_b_bar,\
                           pressure_a_bar,pressure_b_bar,feedback_newton_metre,limited\n";

/// A run as CSV.
pub fn log(samples: &[JointSample]) -> String {
    COLUMNS.to_owned() + &samples.iter().map(row).collect::<String>()
}

/// The row of a tick. The stiffness is the one that was due.
pub fn row(sample: &JointSample) -> String {
    let JointSample { time_s, wanted, measured, commands_bar, reply } = sample;
    let ([command_a, command_b], [a, b]) = (commands_bar, measured.pressures_bar);
    let (angle, feedback, stiffness) = (measured.angle_deg, reply.feedback_nm, reply.stiffness);
    let limited = u8::from(reply.is_limited || !reply.is_as_stiff);
    format!(
        "{time_s:.6},{},{angle},{stiffness},{command_a},{command_b},{a},{b},{feedback},{limited}\n",
        wanted.angle_deg
    )
}

/// The error of the angle over all ticks. Unit: degrees.
pub fn figures(samples: &[JointSample]) -> Figures {
    let of = |value: fn(&JointSample) -> f64| -> Vec<f64> { samples.iter().map(value).collect() };
    let (wanted, angle) = (of(|sample| sample.wanted.angle_deg), of(|sample| sample.measured.angle_deg));
    Figures::of(&wanted, &angle, &vec![true; samples.len()])
}

/// In how many ticks the pressures' bounds have kept the angle, and the stiffness, from what was
/// wanted.
pub fn limited(samples: &[JointSample]) -> [usize; 2] {
    let count = |is: fn(&&JointSample) -> bool| samples.iter().filter(is).count();
    [count(|sample| sample.reply.is_limited), count(|sample| !sample.reply.is_as_stiff)]
}
