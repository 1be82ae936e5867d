//! Sets of parameters to keep.

use board_models::joint::joint_parameters;
use board_models::paper_parameters;
use firmware::store::{JointParameters, Parameters, Sealed, Set};
use model_core::cascade::CascadeParameters;
use model_core::dead_zone::DeadZoneParameters;
use model_core::envelope::{EnvelopeParameters, PiecewiseLinearParameters};
use model_core::play::PlayParameters;
use model_core::{ModelParameters, TrackingParameters};
use wire::joint::JointCalibration;
use wire::{Calibration, Input, Inputs, Line, Protection, Signal};

/// A set with limits of the plant in it.
pub trait Limited: Set {
    /// The limits.
    fn protection(&mut self) -> &mut Protection;
}

impl Limited for Parameters {
    fn protection(&mut self) -> &mut Protection {
        &mut self.protection
    }
}

impl Limited for JointParameters {
    fn protection(&mut self) -> &mut Protection {
        &mut self.protection
    }
}

/// The set with a number in it, by which sets can be told apart.
pub fn numbered<P: Limited>(number: u32, mut set: P) -> P {
    set.protection().bus_silent_ticks = number;
    set
}

/// A set of a joint, whose muscles are not alike: every list of the model is full, and no sensor is
/// the standard one.
pub fn joint_set() -> JointParameters {
    let mut control = joint_parameters();
    let [_, b] = &mut control.joint.muscles;
    (b.knee, b.valve_lag_s) = (0.15, 0.06);
    JointParameters {
        protection: Protection { bus_silent_ticks: 1000, ..Protection::STANDARD },
        calibration: Some(Sealed::new(joint_calibration())),
        control: Some(control),
    }
}

/// A calibration of a joint's working sensors, no two alike.
pub fn joint_calibration() -> JointCalibration {
    let line = |zero_code, codes_per_unit| Some(Line { zero_code, codes_per_unit });
    JointCalibration { pressures: [line(430.0, 300.0), line(380.0, 350.0)], angle: line(2250.0, 1100.0) }
}

/// The paper's model with the limits of a new board.
///
/// # Panics
/// The paper's model is not valid.
pub fn paper_set() -> Parameters {
    Parameters { tracking: Some(paper_parameters().expect("valid")), ..Parameters::FACTORY }
}

/// A calibration of working sensors, none of them the standard one.
pub fn calibration() -> Calibration {
    let line = |zero_code, codes_per_unit| Line { zero_code, codes_per_unit };
    Calibration {
        pressure: line(401.5, 330.25),
        contraction: line(200.0, 25.5),
        supply: line(420.0, 320.75),
        command: line(3.5, 400.5),
        day: 20_783,
        inputs: Inputs::STANDARD,
    }
}

/// The longest set: every list of the model full, no number short.
///
/// # Panics
/// The paper's model is not valid.
pub fn full_set() -> Parameters {
    fn full<const L: usize>() -> model_core::List<f32, L> {
        (1..=L).map(|i| 0.123_456_79 * i as f32).collect()
    }
    let model = ModelParameters::Cascade(CascadeParameters {
        envelope: EnvelopeParameters::PiecewiseLinear(PiecewiseLinearParameters {
            inputs: full(),
            values: full(),
        }),
        plays: PlayParameters { q: 1.0, thresholds: full(), weights: full() },
        dead_zones: DeadZoneParameters { thresholds: full(), weights: full(), offset: 0.1 },
        input_min: 0.0,
        input_max: 6.0,
        preconditioned: true,
    });
    let tracking = TrackingParameters { model, ..paper_parameters().expect("valid") };
    let input = Input { signal: Signal::Current, pin_v: 2.987_654_3, low: -1.234_567_9, high: 123.456_79 };
    let inputs = Inputs { pressure: input, contraction: input, supply: input };
    let calibration = Some(Sealed::new(Calibration { day: 100_000, inputs, ..calibration() }));
    Parameters { tracking: Some(tracking), calibration, ..Parameters::FACTORY }
}
