//! What a board protects its muscle by: limits of the plant, which the host may set while the valve
//! is vented.
//!
//! A limit that is infinite, or a number of ticks that is [`NEVER`], switches its monitor off.

use serde::{Deserialize, Serialize};

use crate::Refusal;

/// A number of ticks that does not pass.
pub const NEVER: u32 = u32::MAX;

/// The board's tick, which the standard limits of a change from tick to tick are for. Unit: s.
const TICK_S: f32 = 1e-3;

/// The limits.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Protection {
    /// Length of the self-test between configuration and readiness, valve vented. Unit: tick.
    pub self_test_ticks: u32,
    /// Highest pressure at the end of the self-test. Unit: bar.
    pub vented_bar: f32,
    /// Pressure that vents in the sample that shows it. Unit: bar.
    pub overpressure_hard_bar: f32,
    /// Pressure that vents when its average over some 16 samples is above. Unit: bar.
    pub overpressure_soft_bar: f32,
    /// Lowest pressure of the supply, as an average. Unit: bar.
    pub supply_min_bar: f32,
    /// Largest credible change of the pressure in a tick. Unit: bar.
    pub pressure_jump_bar: f32,
    /// Largest credible change of the contraction in a tick. Unit: mm.
    pub contraction_jump_mm: f32,
    /// A sensor that shows no change while the command moves by as much is stuck. Unit: bar.
    pub stuck_command_bar: f32,
    /// How far outside the model's loop a contraction is implausible, as a share of the stroke.
    /// Unit: 1.
    pub implausible_share: f32,
    /// How far pressure and command may differ for good. Unit: bar.
    pub following_band_bar: f32,
    /// Integral over time of what they differ beyond that, at which the valve does not follow.
    /// Unit: bar s.
    pub following_limit_bar_s: f32,
    /// How much the feedback may put on the feed-forward for good. Unit: bar.
    pub authority_bar: f32,
    /// How long the host may be silent while the valve is driven. Unit: tick.
    pub bus_silent_ticks: u32,
    /// Rise of the highest command after a start. Unit: bar/s, above 0.
    pub soft_start_bar_per_s: f32,
    /// Largest rate of change of the command, whatever the controller asks for. Unit: bar/s, above
    /// 0.
    pub slew_bar_per_s: f32,
    /// Highest temperature of the board. Unit: °C.
    pub temperature_max_c: f32,
    /// What follows when the installed model does not stand its test.
    pub on_model_fault: OnModelFault,
}

/// What follows when the installed model does not stand its test.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum OnModelFault {
    /// The valve stays vented.
    Vent,
    /// Feedback alone may track.
    FeedbackOnly,
}

impl Protection {
    /// Of a board on a real muscle, until the host says otherwise: a muscle for up to 6 bar.
    pub const STANDARD: Self = Self {
        self_test_ticks: 250,
        vented_bar: 0.5,
        overpressure_hard_bar: 7.5,
        overpressure_soft_bar: 6.6,
        supply_min_bar: 4.0,
        pressure_jump_bar: 1.0,
        contraction_jump_mm: 10.0,
        stuck_command_bar: 1.5,
        implausible_share: 0.3,
        following_band_bar: 1.0,
        following_limit_bar_s: 1.0,
        authority_bar: 2.0,
        bus_silent_ticks: 500,
        soft_start_bar_per_s: 10.0,
        slew_bar_per_s: 100.0,
        temperature_max_c: 85.0,
        on_model_fault: OnModelFault::FeedbackOnly,
    };

    /// Of a board whose muscle is a simulation, which cannot be hurt and may behave as it likes:
    /// what concerns sensors, numbers and program stays on, what concerns the plant is off.
    pub const SIMULATED: Self = Self {
        self_test_ticks: 0,
        vented_bar: f32::INFINITY,
        overpressure_hard_bar: f32::INFINITY,
        overpressure_soft_bar: f32::INFINITY,
        supply_min_bar: 0.0,
        pressure_jump_bar: f32::INFINITY,
        contraction_jump_mm: f32::INFINITY,
        stuck_command_bar: f32::INFINITY,
        implausible_share: f32::INFINITY,
        following_band_bar: f32::INFINITY,
        following_limit_bar_s: f32::INFINITY,
        authority_bar: f32::INFINITY,
        bus_silent_ticks: NEVER,
        soft_start_bar_per_s: 200.0,
        slew_bar_per_s: 200.0,
        temperature_max_c: f32::INFINITY,
        on_model_fault: OnModelFault::FeedbackOnly,
    };

    /// The widest limits that a board with a muscle takes, by bus and by link: the ends of the
    /// ranges of its registers. For tests without a muscle.
    pub const WIDEST: Self = Self {
        self_test_ticks: 0,
        vented_bar: 1.0,
        overpressure_hard_bar: 8.5,
        overpressure_soft_bar: 8.0,
        supply_min_bar: 0.0,
        pressure_jump_bar: 10.0,
        contraction_jump_mm: 200.0,
        stuck_command_bar: 10.0,
        implausible_share: 10.0,
        following_band_bar: 10.0,
        following_limit_bar_s: 100.0,
        authority_bar: 10.0,
        bus_silent_ticks: 60_000,
        soft_start_bar_per_s: 200.0,
        slew_bar_per_s: 200.0,
        temperature_max_c: 105.0,
        on_model_fault: OnModelFault::FeedbackOnly,
    };

    /// These limits, if all can be compared with: none is NaN or negative, and what has to be above
    /// 0 is.
    ///
    /// # Errors
    /// The first that is not, by name and value.
    pub fn checked(self) -> Result<Self, Refusal> {
        let at_least_0 = [
            ("vented_bar", self.vented_bar),
            ("overpressure_hard_bar", self.overpressure_hard_bar),
            ("overpressure_soft_bar", self.overpressure_soft_bar),
            ("supply_min_bar", self.supply_min_bar),
            ("pressure_jump_bar", self.pressure_jump_bar),
            ("contraction_jump_mm", self.contraction_jump_mm),
            ("stuck_command_bar", self.stuck_command_bar),
            ("implausible_share", self.implausible_share),
            ("following_band_bar", self.following_band_bar),
            ("following_limit_bar_s", self.following_limit_bar_s),
            ("authority_bar", self.authority_bar),
            ("temperature_max_c", self.temperature_max_c),
        ];
        let above_0 =
            [("soft_start_bar_per_s", self.soft_start_bar_per_s), ("slew_bar_per_s", self.slew_bar_per_s)];
        if let Some((name, value)) = at_least_0.iter().find(|(_, value)| value.is_nan() || *value < 0.0) {
            return Err(Refusal::parameter(format_args!("{name} is {value}, must be at least 0")));
        }
        match above_0.iter().find(|(_, value)| !value.is_finite() || *value <= 0.0) {
            Some((name, value)) => {
                Err(Refusal::parameter(format_args!("{name} is {value}, must be above 0 and finite")))
            }
            None => Ok(self),
        }
    }

    /// The same limits for ticks that are `period_s` apart: what may change from one tick to the
    /// next grows with the time between them. Limits are those of the board's tick where ticks are
    /// closer.
    #[must_use]
    pub fn for_period(self, period_s: f32) -> Self {
        let longer = (period_s / TICK_S).max(1.0);
        Self {
            pressure_jump_bar: longer * self.pressure_jump_bar,
            contraction_jump_mm: longer * self.contraction_jump_mm,
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::registers::fields::{PROTECTION, excess_of_protection, of_protection};
    use crate::registers::{Access, Id};

    #[test]
    fn the_widest_limits_are_the_ends_of_their_registers_and_a_simulations_lie_beyond() {
        assert_eq!(excess_of_protection(&Protection::WIDEST), None);
        assert_eq!(excess_of_protection(&Protection::STANDARD), None);
        assert!(excess_of_protection(&Protection::SIMULATED).is_some());
        let mut widest = Protection::WIDEST;
        for id in PROTECTION {
            let Access::Write(min, max) = id.register().access else { panic!("{id:?} is written") };
            let end = if matches!(id, Id::SelfTestTicks | Id::SupplyMin) { min } else { max };
            let held = of_protection(&mut widest, id).map(|field| field.get().number());
            assert_eq!(held, Some(f64::from(end as f32)), "{id:?}");
        }
    }

    #[test]
    fn a_longer_tick_may_see_larger_changes_and_no_other_limit_moves() {
        let standard = Protection::STANDARD;
        assert_eq!(standard.for_period(TICK_S), standard);
        assert_eq!(standard.for_period(0.2 * TICK_S), standard);
        let slow = standard.for_period(10.0 * TICK_S);
        assert_eq!((slow.pressure_jump_bar, slow.contraction_jump_mm), (10.0, 100.0));
        assert_eq!(Protection { pressure_jump_bar: 1.0, contraction_jump_mm: 10.0, ..slow }, standard);
    }
}
