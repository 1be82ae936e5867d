//! The tracking controller with extensions.

#[path = "common/effects.rs"]
mod effects;

use effects::{EXACT, Extensions, LOSSY, PERIOD_S, SIZE, muscle, together};
use model_core::extension::{Sample, SupplySaturationParameters, TransportDelayParameters};
use model_core::pid::PidParameters;
use model_core::tracking::Command;
use model_core::{
    ExtendedModel, Measured, Mode, ObserverParameters, Surroundings, Tracking, TrackingParameters,
    TrackingState,
};

type Controller = Tracking<f64, SIZE, SIZE>;

fn parameters(extensions: Extensions) -> TrackingParameters<f64, SIZE, SIZE> {
    TrackingParameters {
        model: muscle(),
        extensions,
        pid: PidParameters::paper(),
        observer: ObserverParameters::default(),
        command_min: -5.0,
        command_max: 15.0,
        slew_bar_per_s: 1e6,
        period_s: PERIOD_S,
    }
}

fn controller(extensions: Extensions) -> Controller {
    Tracking::try_new(&parameters(extensions)).expect("valid")
}

fn step(
    controller: &Controller,
    state: &mut TrackingState<f64, SIZE>,
    mode: Mode,
    reference: f64,
    contraction: f64,
) -> Command<f64> {
    controller.step(state, mode, reference, contraction).expect("finite")
}

/// Two raised cosines of the reference, from standstill. Unit: s, mm.
fn reference(time_s: f64) -> f64 {
    20.0 + 40.0 * (1.0 - (std::f64::consts::TAU * time_s / 2.0).cos())
}

fn surroundings(tick: usize) -> Surroundings<f64> {
    let t = tick as f64 * PERIOD_S;
    Surroundings { load: Some(20.0 + t), temperature: Some(25.0 - 0.5 * t) }
}

/// The largest error of tracking a muscle with `plant`'s effects by feed-forward alone, that of the
/// first half second aside. Unit: mm.
fn worst(plant: &Extensions, compensated: Extensions) -> f64 {
    let ahead_s = compensated.preview_s(PERIOD_S);
    let controller = controller(compensated);
    let plant = ExtendedModel::<f64, SIZE, SIZE>::try_new(&muscle(), plant).expect("valid");
    let (mut state, mut plant_state) = (controller.rest_state(Mode::FeedforwardOnly), plant.rest_state());
    let mut worst = 0.0_f64;
    for tick in 0..4000 {
        // Measured a delay too early, as it has to be: what changes slowly is compensated all but
        // exactly.
        let measured = Measured { contraction: 0.0, surroundings: surroundings(tick) };
        let time_s = tick as f64 * PERIOD_S;
        let ahead = reference(time_s + ahead_s);
        let command = controller.step(&mut state, Mode::FeedforwardOnly, ahead, measured).expect("finite");
        let sample = Sample { input: command.command, surroundings: surroundings(tick), dt_s: PERIOD_S };
        let contraction = plant.step(&mut plant_state, &sample).expect("finite").contraction;
        if tick > 500 {
            worst = worst.max((contraction - reference(time_s)).abs());
        }
    }
    worst
}

#[test]
fn with_every_extension_the_feedforward_alone_tracks_its_own_muscle() {
    let all = together(EXACT.iter().chain(&LOSSY[..1]));
    let compensated = worst(&all, all.clone());
    let delay_only = Extensions { transport_delay: all.transport_delay, ..Extensions::default() };
    let plain = worst(&all, delay_only);
    assert!(compensated < 0.05, "{compensated} mm");
    assert!(plain > 5.0, "{plain} mm without compensation: the effects are too weak to show anything");
}

/// The last digit of a reference file is a ten-thousandth of a millimetre, and its rows are 5 ms
/// apart.
#[test]
fn a_mass_asks_for_no_pressure_for_the_digits_and_corners_of_a_reference() {
    let effects = together(EXACT.iter().filter(|(name, _)| ["inertia", "valve_lag"].contains(name)));
    assert!(effects.inertia.is_some() && effects.valve_lag.is_some());
    let row = |row: usize| (1e4 * reference(5.0 * PERIOD_S * row as f64)).round() / 1e4;
    let filed = |tick: usize| {
        let (from, share) = (row(tick / 5), (tick % 5) as f64 / 5.0);
        from + share * (row(tick / 5 + 1) - from)
    };
    let commands = |reference: &dyn Fn(usize) -> f64| -> Vec<f64> {
        let controller = controller(effects.clone());
        let mut state = controller.rest_state(Mode::FeedforwardOnly);
        (0..4000)
            .map(|tick| step(&controller, &mut state, Mode::FeedforwardOnly, reference(tick), 0.0).command)
            .collect()
    };
    let (rough, smooth) = (commands(&filed), commands(&|tick| reference(tick as f64 * PERIOD_S)));
    let worst = rough.iter().zip(&smooth).map(|(rough, smooth)| (rough - smooth).abs()).fold(0.0, f64::max);
    assert!(worst < 0.05, "{worst} bar");
}

#[test]
fn the_feedback_sees_the_reference_that_is_due_now() {
    for (delay_s, periods) in [(0.0, 0.0), (0.02, 20.0), (0.0025, 2.5), (0.5, 500.0)] {
        let transport_delay = Some(TransportDelayParameters { delay_s });
        let controller = controller(Extensions { transport_delay, ..Extensions::default() });
        let mut state = controller.rest_state(Mode::FeedbackOnly);
        for tick in 0..2000 {
            // The contraction is what is due; the feedback has nothing to do.
            let due = 10.0 + 0.01 * (f64::from(tick) - periods).max(0.0);
            let given = 10.0 + 0.01 * f64::from(tick);
            let command = step(&controller, &mut state, Mode::FeedbackOnly, given, due);
            assert!(command.feedback.abs() < 1e-9, "{delay_s} s, tick {tick}: {command:?}");
        }
    }
}

#[test]
fn a_delay_that_the_controller_cannot_hold_is_refused_by_its_limit() {
    let delayed = |delay_s| {
        let transport_delay = Some(TransportDelayParameters { delay_s });
        Tracking::try_new(&parameters(Extensions { transport_delay, ..Extensions::default() }))
    };
    assert!(delayed(0.51).is_ok());
    let refused = delayed(0.52).expect_err("too long").to_string();
    assert_eq!(refused, "transport_delay delay_s is 0.52 s, must be at most 0.51 s");
}

#[test]
fn the_integral_does_not_wind_up_at_a_supply_below_the_highest_command() {
    let supply_saturation = Some(SupplySaturationParameters { supply: 4.0 });
    let extensions = Extensions { supply_saturation, ..Extensions::default() };
    let gains = PidParameters { ki: 0.05, ..PidParameters::paper() };
    let controller = Tracking::try_new(&TrackingParameters { pid: gains, ..parameters(extensions) });
    let controller = controller.expect("valid");
    let mut state = controller.rest_state(Mode::FeedbackOnly);
    for _ in 0..60_000 {
        let command = step(&controller, &mut state, Mode::FeedbackOnly, 140.0, 110.0);
        assert!(command.command <= 4.0);
    }
    let left =
        (0..1000).position(|_| step(&controller, &mut state, Mode::FeedbackOnly, 90.0, 110.0).command < 3.99);
    assert!(left.is_some_and(|tick| tick < 500), "left the supply after {left:?} ticks");
}

#[test]
fn a_supply_below_the_lowest_command_is_refused() {
    let supply_saturation = Some(SupplySaturationParameters { supply: -6.0 });
    let refused = Tracking::try_new(&parameters(Extensions { supply_saturation, ..Extensions::default() }));
    assert_eq!(refused.expect_err("no command is left").parameter, "command range");
}

#[test]
fn a_load_that_is_not_measured_is_taken_to_be_at_its_reference() {
    let controller = controller(together(EXACT.iter().filter(|(name, _)| *name == "load")));
    let command = |load| {
        let measured = Measured { contraction: 0.0, surroundings: Surroundings { load, temperature: None } };
        let mut state = controller.rest_state(Mode::FeedforwardOnly);
        controller.step(&mut state, Mode::FeedforwardOnly, 60.0, measured).expect("finite").feedforward
    };
    assert_eq!(command(None), command(Some(20.0)));
    // 0.02 bar/N at 60 mm.
    assert!((command(Some(30.0)) - command(None) - 0.2).abs() < 1e-12);
}
