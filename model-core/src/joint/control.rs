//! The controller of a joint: its angle by the torque balance and a PID, its stiffness by what both
//! muscles pull together.
//!
//! ```text
//! angle ─▶ rate ─┬─▶ stops ─▶ torque balance ─▶ two equations ─▶ lead of the valves ─┐
//! stiffness ─▶ rate ───────────────────────────▶     │                                ├─▶ + ─▶ slew, limits ─▶ commands
//!                └─▶ PID (◀─ measured angle) ─▶ torque ─▶ two equations ── less those ─┘
//! ```
//!
//! The PID acts in torque: its gains are shares of the stiffness that the pressures bring about, so
//! that they are the same for a soft and a stiff joint. What feedback adds is not led, which would
//! make noise of it.
//!
//! # Rates
//! A jump of angle or stiffness is followed at the rate of the parameters: what both pressures can
//! follow together leaves the torque balanced on the way.
//!
//! # Start
//! The joint is vented, the muscles are slack. Until the slew limit has let both commands come to
//! what is asked for the integral rests.

use super::balance::share;
use super::stops::Stops;
use super::{Joint, JointParameters};
use crate::error::{Check, InputError, ParameterError, finite_input};
use crate::extension::valve_lag::LEAD_LIMIT;
use crate::extension::valve_lag::first_order::FirstOrderStep;
use crate::pid::{Pid, PidParameters, PidState};
use crate::range::Range;
use crate::real::Real;

/// Raw parameters of the controller.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "T: Real + serde::Serialize + serde::de::DeserializeOwned")
)]
pub struct JointControlParameters<T, const N: usize> {
    /// The joint.
    pub joint: JointParameters<T, N>,
    /// The feedback, its gains as shares of the stiffness: kp 1, ki 1/s, kd s.
    pub pid: PidParameters<T>,
    /// Fastest turn. Unit: rad/s, above 0.
    pub turn_rad_per_s: T,
    /// Fastest change of the stiffness. Unit: N m/(rad s), above 0.
    pub stiffen_per_s: T,
    /// Largest rate of change of a command. Unit: bar/s, above 0.
    pub slew_bar_per_s: T,
    /// Time from sample to sample. Unit: s, above 0.
    pub period_s: T,
}

/// What the joint is to do.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct JointTarget<T> {
    /// Unit: rad.
    pub angle: T,
    /// Unit: N m/rad.
    pub stiffness: T,
    /// Torque that acts on the joint from outside, as far as it is known. Unit: N m.
    pub load: T,
}

/// A validated controller of a joint.
///
/// See [`crate::joint`] for the model.
#[derive(Clone, Debug, PartialEq)]
pub struct JointControl<T, const N: usize> {
    joint: Joint<T, N>,
    pid: Pid<T>,
    leads: [FirstOrderStep<T>; 2],
    commands: [Range<T>; 2],
    period_s: T,
    largest_turn: T,
    largest_stiffening: T,
    largest_change: T,
}

/// What the controller remembers.
#[derive(Clone, Debug, PartialEq)]
pub struct JointState<T, const N: usize> {
    stops: Stops<T, N>,
    /// Unit: N m/rad; none before the first sample.
    stiffness: Option<T>,
    pid: PidState<T>,
    /// What the feed-forward has brought both pressures to. Unit: bar.
    led: [T; 2],
    /// Unit: bar.
    commands: [T; 2],
}

impl<T: Real, const N: usize> JointState<T, N> {
    /// The angle that was due at the last sample. Unit: rad.
    pub fn due(&self) -> T {
        self.stops.angle()
    }
}

/// A sample's commands and what they are made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointCommand<T> {
    /// To the regulators. Unit: bar.
    pub commands: [T; 2],
    /// The pressures that are asked for. Unit: bar.
    pub pressures: [T; 2],
    /// Those of the feed-forward alone. Unit: bar.
    pub forward: [T; 2],
    /// What bounds of the pressures keep back of the torque that is asked for; 0 where they allow
    /// it. Unit: N m.
    pub withheld: T,
    /// The angle that is due. Unit: rad.
    pub due: T,
    /// The stiffness that is due. Unit: N m/rad.
    pub stiffness: T,
    /// The torque that the PID asked for. Unit: N m.
    pub feedback: T,
    /// Whether a bound of a pressure, or the slew rate, keeps the angle from being reached.
    pub limited: bool,
    /// Whether the bounds of the pressures allow the stiffness.
    pub is_as_stiff: bool,
}

impl<T: Real, const N: usize> JointControl<T, N> {
    /// # Errors
    /// The first parameter that no controller can be made of.
    pub fn try_new(parameters: &JointControlParameters<T, N>) -> Result<Self, ParameterError> {
        let JointControlParameters { joint, pid, turn_rad_per_s, stiffen_per_s, slew_bar_per_s, period_s } =
            parameters;
        let period = Check::new("period_s", "s").above(*period_s, T::ZERO)?;
        let per_period = |name, unit, rate: T| Ok(Check::new(name, unit).above(rate, T::ZERO)? * period);
        let [a, b] = &joint.muscles;
        let lead = |lag_s| {
            let lag_s = Check::new("valve_lag_s", "s").above(lag_s, T::ZERO)?;
            Ok(FirstOrderStep::new(lag_s, T::from_f64(LEAD_LIMIT), period))
        };
        let range = |[first, last]: [T; 2]| Range::try_new(T::ZERO, first.at_least(last), "highest", "bar");
        Ok(Self {
            joint: Joint::try_new(joint)?,
            pid: Pid::try_new(pid, period)?,
            leads: [lead(a.valve_lag_s)?, lead(b.valve_lag_s)?],
            commands: [range(a.highest)?, range(b.highest)?],
            period_s: period,
            largest_turn: per_period("turn_rad_per_s", "rad/s", *turn_rad_per_s)?,
            largest_stiffening: per_period("stiffen_per_s", "N m/(rad s)", *stiffen_per_s)?,
            largest_change: per_period("slew_bar_per_s", "bar/s", *slew_bar_per_s)?,
        })
    }

    /// The joint.
    pub fn joint(&self) -> &Joint<T, N> {
        &self.joint
    }

    /// The state before the first sample: vented, at an angle (rad).
    pub fn rest_state(&self, angle: T) -> JointState<T, N> {
        JointState {
            stops: Stops::relaxed(self.joint.angles().limit(angle)),
            stiffness: None,
            pid: PidState::starting_at(angle),
            led: [T::ZERO; 2],
            commands: [T::ZERO; 2],
        }
    }

    /// Pressures (bar) as far as the model knows their friction: not below the lowest ones, as they
    /// are while the joint is filled.
    fn held(&self, angle: T, pressures: [T; 2]) -> [T; 2] {
        let ([a, b], [pressure_a, pressure_b]) = (self.joint.muscles(), pressures);
        [pressure_a.at_least(a.bounds(angle).0), pressure_b.at_least(b.bounds(angle).0)]
    }

    /// One sample. `angle`, now: rad.
    ///
    /// # Errors
    /// A value that is not finite; the state is then as it was.
    pub fn step(
        &self,
        state: &mut JointState<T, N>,
        target: &JointTarget<T>,
        angle: T,
    ) -> Result<JointCommand<T>, InputError> {
        let load = finite_input(target.load)?;
        let asked_stiffness = finite_input(target.stiffness)?;
        let asked_angle = self.joint.angles().limit(finite_input(target.angle)?);
        let angle = finite_input(angle)?;

        let last = state.stops.angle();
        let due = last + (asked_angle - last).limit(-self.largest_turn, self.largest_turn);
        let soft = state.stiffness.unwrap_or(asked_stiffness);
        let stiff = soft + (asked_stiffness - soft).limit(-self.largest_stiffening, self.largest_stiffening);
        state.stiffness = Some(stiff);
        let held = self.held(due, state.led);
        self.joint.turn(&mut state.stops, due, held);

        let torque = self.joint.torque_form(due, (due - last) / self.period_s, &state.stops);
        let stiffness = self.joint.stiffness_form(due, self.joint.drives(held));
        let shared = |wanted| share(self.joint.muscles(), due, (&torque, wanted), (&stiffness, stiff));
        let error = due - angle;
        let forward = shared(-load);
        // What the pressures bring about, which is above 0 whatever is asked for.
        let gain = self.joint.stiffness(due, forward.pressures);
        let feedback = gain * self.pid.output(&mut state.pid, error, angle);
        let both = shared(feedback - load);

        let mut has_arrived = true;
        let JointState { led, commands, .. } = state;
        let muscles = led.iter_mut().zip(commands.iter_mut()).zip(&self.leads).zip(&self.commands);
        for ((((led, command), lead), range), (forward, both)) in
            muscles.zip(forward.pressures.iter().zip(&both.pressures))
        {
            let set_point = lead.set_point(*led, *forward);
            *led = lead.pressure(*led, set_point);
            let asked = range.limit(set_point + (*both - *forward));
            *command = range.step_toward(*command, asked, self.largest_change);
            has_arrived = has_arrived && *command == asked;
        }
        if has_arrived {
            self.pid.settle(&mut state.pid, error, both.excess / gain);
        }
        Ok(JointCommand {
            commands: state.commands,
            pressures: both.pressures,
            forward: forward.pressures,
            withheld: both.excess,
            due,
            stiffness: stiff,
            feedback,
            limited: !has_arrived || both.excess != T::ZERO,
            is_as_stiff: both.is_as_stiff,
        })
    }
}
