//! Gains of the feedback and limits of the command, for the commands that configure a board.

use clap::Args;
use wire::registers::Id;

/// What of a controller's settings options say.
#[derive(Args, Clone, Copy, Debug)]
#[command(
    next_help_heading = "Controller (gains that are not given are those tuned for the model; limits stay as the board has them)"
)]
pub struct Gains {
    /// Proportional gain in bar/mm
    #[arg(long, value_name = "GAIN")]
    kp: Option<f32>,
    /// Integral gain in bar/(mm s)
    #[arg(long, value_name = "GAIN")]
    ki: Option<f32>,
    /// Derivative gain in bar s/mm
    #[arg(long, value_name = "GAIN")]
    kd: Option<f32>,
    /// Time constant of the derivative's filter in s
    #[arg(long, alias = "filter", value_name = "S")]
    filter_s: Option<f32>,
    /// Time constant of the anti-windup in s
    #[arg(long, alias = "anti-windup", value_name = "S")]
    anti_windup_s: Option<f32>,
    /// Rate of the disturbance observer in 1/s, which takes the place of the integral; 0 switches
    /// it off
    #[arg(long, alias = "observer", value_name = "1/S")]
    observer_per_s: Option<f32>,
    /// Lowest command in bar [default: the lower end of the model's range, at least 0]
    #[arg(long, value_name = "BAR")]
    min_bar: Option<f32>,
    /// Highest command in bar [default: the upper end of the model's range, which it never exceeds]
    #[arg(long, value_name = "BAR")]
    max_bar: Option<f32>,
    /// Largest rate of change of the command in bar/s [default: by the valve's lag]
    #[arg(long, alias = "slew", value_name = "BAR/S")]
    slew_bar_per_s: Option<f32>,
}

impl Gains {
    /// What is given, by its register.
    pub fn asked(&self) -> Vec<(Id, f32)> {
        let Self { kp, ki, kd, filter_s, anti_windup_s, observer_per_s, min_bar, max_bar, slew_bar_per_s } =
            *self;
        let given = [
            (Id::Kp, kp),
            (Id::Ki, ki),
            (Id::Kd, kd),
            (Id::DerivativeFilter, filter_s),
            (Id::TrackingTime, anti_windup_s),
            (Id::ObserverRate, observer_per_s),
            (Id::CommandMin, min_bar),
            (Id::CommandMax, max_bar),
            (Id::CommandSlew, slew_bar_per_s),
        ];
        given.into_iter().filter_map(|(id, value)| Some((id, value?))).collect()
    }
}
