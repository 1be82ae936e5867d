//! The gains of the feedback, for the commands that configure a board.

use clap::Args;
use model_core::pid::PidParameters;

/// The gains of the feedback.
#[derive(Args, Clone, Copy, Debug)]
pub struct Gains {
    /// Proportional gain in bar/mm
    #[arg(long, default_value_t = PidParameters::<f32>::paper().kp, value_name = "GAIN")]
    kp: f32,
    /// Integral gain in bar/(mm s)
    #[arg(long, default_value_t = INTEGRAL_GAIN, value_name = "GAIN")]
    ki: f32,
    /// Derivative gain in bar s/mm
    #[arg(long, default_value_t = PidParameters::<f32>::paper().kd, value_name = "GAIN")]
    kd: f32,
}

/// The integral gain by default. The paper's 0.01 takes tens of seconds to mend an offset; ten times that settles in
/// seconds and still lies far below what a regulator's lag allows beside the paper's proportional gain. Unit:
/// bar/(mm s).
const INTEGRAL_GAIN: f32 = 0.1;

impl Gains {
    /// The feedback with these gains.
    pub fn pid(self) -> PidParameters<f32> {
        PidParameters { kp: self.kp, ki: self.ki, kd: self.kd, ..PidParameters::paper() }
    }
}
