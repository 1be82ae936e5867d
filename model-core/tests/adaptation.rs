//! What follows a muscle that moves away from its model, in the tracking controller.

use model_core::adaptation::{Adapted, BEYOND, Change, OFFSET};
use model_core::paper::{self, SIZE};
use model_core::pid::PidParameters;
use model_core::{
    ExtensionParameters, Hysteresis, Mgpi, Mode, ModelParameters, ObserverParameters, Real, Surroundings,
    Tracking, TrackingParameters,
};

const PERIOD_S: f64 = 1e-2;
/// Of the reference. Unit: s.
const CYCLE_S: f64 = 20.0;

fn tracking<T: Real>() -> Tracking<T, SIZE, SIZE> {
    let model: ModelParameters<f64, SIZE, SIZE> = ModelParameters::Cascade(paper::mgpi().expect("valid"));
    Tracking::try_new(&TrackingParameters {
        model: model.convert().expect("fits"),
        extensions: ExtensionParameters::default(),
        pid: PidParameters { kp: T::ZERO, ki: T::from_f64(0.05), ..PidParameters::paper() },
        observer: ObserverParameters::default(),
        command_min: T::ZERO,
        command_max: T::from_f64(6.0),
        slew_bar_per_s: T::from_f64(1000.0),
        period_s: T::from_f64(PERIOD_S),
    })
    .expect("valid")
}

/// A raised cosine between 20 and 90 mm.
fn reference(tick: usize) -> f64 {
    20.0 + 35.0 * (1.0 - (std::f64::consts::TAU * tick as f64 * PERIOD_S / CYCLE_S).cos())
}

/// What a run goes by.
#[derive(Clone, Copy)]
struct Course<'a> {
    mode: Mode,
    reference: &'a dyn Fn(usize) -> f64,
    /// The pressure that acts, of the tick and the command. Unit: bar.
    acts: &'a dyn Fn(usize, f64) -> f64,
    /// Where the muscle is, of the tick and the contraction of its model. Unit: mm.
    is: &'a dyn Fn(usize, f64) -> f64,
    /// What the sensor says of where it is. Unit: mm.
    says: &'a dyn Fn(f64) -> f64,
    learns: bool,
}

/// A muscle that is as its model says.
const SOUND: Course<'static> = Course {
    mode: Mode::FeedforwardOnly,
    reference: &reference,
    acts: &|_, bar| bar,
    is: &|_, mm| mm,
    says: &|mm| mm,
    learns: true,
};

/// Runs so many ticks; answers the root mean square of the error of the last cycle. Unit: mm.
fn run<T: Real>(
    controller: &Tracking<T, SIZE, SIZE>,
    adapted: &mut Adapted<T>,
    course: &Course<'_>,
    ticks: usize,
) -> f64 {
    let muscle = Mgpi::<f64, SIZE, SIZE>::try_new(&paper::mgpi().expect("valid")).expect("valid");
    let (mut state, mut plant) = (controller.rest_state(course.mode), muscle.rest_state());
    let (mut command, mut squares) = (0.0, 0.0);
    let last = (CYCLE_S / PERIOD_S) as usize;
    for tick in 0..ticks {
        let pressure = (course.acts)(tick, command);
        let contraction = (course.is)(tick, muscle.step(&mut plant, pressure).expect("finite"));
        let due = T::from_f64((course.reference)(tick));
        let asked = controller.asked(adapted, due);
        let none = Surroundings::default();
        let prepared = controller.prepare_asked(&mut state, (asked, due), &none).expect("finite");
        let seen = (course.says)(contraction);
        // A sensor that says nothing does not get as far as the controller.
        let is_seen = seen.is_finite();
        let seen = T::from_f64(if is_seen { seen } else { 0.0 });
        let done = controller.act(&mut state, course.mode, prepared, seen).expect("finite");
        if course.learns {
            controller.learn(&state, &prepared, is_seen && !done.limited, adapted);
        }
        command = done.command.to_f64();
        if tick + last >= ticks {
            squares += (due.to_f64() - contraction).powi(2);
        }
    }
    (squares / last as f64).sqrt()
}

fn cycles(count: f64) -> usize {
    (count * CYCLE_S / PERIOD_S) as usize
}

/// A muscle that is 8 mm shorter in the middle, and more so at the upper end.
fn longer(_: usize, mm: f64) -> f64 {
    mm + 8.0 + 0.06 * (mm - 60.0)
}

#[test]
fn of_a_muscle_that_is_as_its_model_says_hardly_anything_is_learnt() {
    let mut adapted = Adapted::default();
    run(&tracking::<f64>(), &mut adapted, &SOUND, cycles(5.0));
    let Change { offset, gain, bend, width, flare } = adapted.change();
    assert!(adapted.steps() > 400);
    // It answers a tick late, by up to 0.11 mm.
    let most = [offset, gain, bend, width, flare].map(f64::abs).into_iter().fold(0.0, f64::max);
    let most_mm = most * 60.0;
    assert!(most_mm < 0.22, "{most_mm} mm, {:?}", adapted.change());
}

#[test]
fn a_muscle_that_is_shorter_is_followed_with_and_without_feedback_in_both_precisions() {
    fn followed<T: Real>(mode: Mode) {
        let course = Course { mode, is: &longer, ..SOUND };
        let (controller, mut adapted) = (tracking::<T>(), Adapted::default());
        let before =
            run(&controller, &mut Adapted::default(), &Course { learns: false, ..course }, cycles(8.0));
        let after = run(&controller, &mut adapted, &course, cycles(8.0));
        assert!(after < 0.05 * before, "{mode:?}: {before} mm, {after} mm, {:?}", adapted.change());
        // Over what it has moved through it is asked for what it takes.
        for wanted in [25.0, 40.0, 55.0, 70.0, 85.0] {
            let asked = controller.asked(&mut adapted, T::from_f64(wanted)).to_f64();
            let missed = longer(0, asked) - wanted;
            assert!(missed.abs() < 0.6, "{mode:?}: {missed} mm at {wanted} mm, {:?}", adapted.change());
        }
    }
    followed::<f64>(Mode::FeedforwardOnly);
    followed::<f32>(Mode::FeedforwardOnly);
    followed::<f64>(Mode::Both);
    followed::<f32>(Mode::Both);
}

#[test]
fn a_muscle_that_takes_more_pressure_is_followed() {
    let course = Course { acts: &|_, bar| (bar - 0.2) / 1.08, ..SOUND };
    let (controller, mut adapted) = (tracking::<f64>(), Adapted::default());
    let before = run(&controller, &mut Adapted::default(), &Course { learns: false, ..course }, cycles(8.0));
    let after = run(&controller, &mut adapted, &course, cycles(8.0));
    assert!(after < 0.2 * before, "{before} mm, {after} mm, {:?}", adapted.change());
}

#[test]
fn a_wider_loop_is_followed() {
    // A play of 4 mm in half width, of which a sixth comes on top.
    let stood = std::cell::Cell::new(0.0_f64);
    let wider = |_: usize, mm: f64| {
        stood.set(stood.get().clamp(mm - 4.0, mm + 4.0));
        mm - 0.17 * (mm - stood.get())
    };
    let course = Course { is: &wider, ..SOUND };
    let (controller, mut adapted) = (tracking::<f64>(), Adapted::default());
    let before = run(&controller, &mut Adapted::default(), &Course { learns: false, ..course }, cycles(8.0));
    let after = run(&controller, &mut adapted, &course, cycles(8.0));
    assert!(
        after < 0.5 * before && adapted.change().width < 0.0,
        "{before} mm, {after} mm, {:?}",
        adapted.change()
    );
}

#[test]
fn a_steady_drift_is_followed_without_a_lag() {
    // 3 mm in a cycle: by the memory of a stroke, 1.6 mm would be lagged without a rate.
    let drifts = |tick: usize, mm: f64| mm + 3.0 * tick as f64 / cycles(1.0) as f64;
    let course = Course { is: &drifts, ..SOUND };
    let error = run(&tracking::<f64>(), &mut Adapted::default(), &course, cycles(6.0));
    assert!(error < 0.3, "{error} mm");
}

#[test]
fn what_was_learnt_stays_where_nothing_is_learnt() {
    let course = Course { is: &longer, ..SOUND };
    let (controller, mut adapted) = (tracking::<f64>(), Adapted::default());
    let learnt = run(&controller, &mut adapted, &course, cycles(8.0));
    let before = adapted.change();
    let kept = run(&controller, &mut adapted, &Course { learns: false, ..course }, cycles(2.0));
    assert!(kept < learnt + 0.1, "{learnt} mm, {kept} mm");
    assert_eq!(adapted.change(), before);
}

/// What was learnt, and what is left of it after ten seconds of trouble.
fn through_trouble(trouble: &Course<'_>) -> (Change<f64>, Change<f64>) {
    let course = Course { mode: Mode::Both, is: &longer, ..SOUND };
    let (controller, mut adapted) = (tracking(), Adapted::default());
    run(&controller, &mut adapted, &course, cycles(5.0));
    let before = adapted.change();
    run(&controller, &mut adapted, &Course { mode: Mode::Both, ..*trouble }, cycles(0.5));
    (before, adapted.change())
}

#[test]
fn a_sensor_that_is_unplugged_spoils_nothing() {
    let (before, after) = through_trouble(&Course { is: &longer, says: &|_| f64::NAN, ..SOUND });
    assert_eq!(before, after);
}

#[test]
fn a_reference_out_of_the_range_spoils_nothing() {
    let far = |tick: usize| 200.0 + reference(tick);
    let (before, after) = through_trouble(&Course { is: &longer, reference: &far, ..SOUND });
    assert_eq!(before, after);
}

#[test]
fn a_load_beyond_the_muscle_s_force_spoils_nothing() {
    // It hangs at its end, whatever the pressure.
    let (before, after) = through_trouble(&Course { acts: &|_, _| 0.0, is: &|_, mm| mm - 30.0, ..SOUND });
    assert_eq!(before, after);
}

#[test]
fn a_reference_that_is_no_number_spoils_nothing() {
    let (controller, mut adapted) = (tracking::<f64>(), Adapted::default());
    run(&controller, &mut adapted, &Course { is: &longer, ..SOUND }, cycles(3.0));
    let before = adapted;
    for wrong in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert!(!controller.asked(&mut adapted, wrong).is_finite());
        assert_eq!(adapted, before);
    }
}

#[test]
fn a_saturated_valve_teaches_nothing() {
    // Half of the pressure that is asked for is there: the command goes to its end.
    let course = Course {
        mode: Mode::Both,
        reference: &|tick| 118.0 + 1.5 * (tick as f64 * PERIOD_S).sin(),
        acts: &|_, bar| 0.5 * bar,
        ..SOUND
    };
    let mut adapted = Adapted::default();
    run(&tracking::<f64>(), &mut adapted, &course, cycles(3.0));
    assert_eq!(adapted.change(), Change::default());
}

#[test]
fn at_rest_nothing_is_learnt() {
    let (controller, mut adapted) = (tracking::<f64>(), Adapted::default());
    run(&controller, &mut adapted, &Course { is: &longer, ..SOUND }, cycles(3.0));
    let before = adapted.change();
    let rests = Course { reference: &|_| 55.0, is: &|_, mm| longer(0, mm) + 5.0, ..SOUND };
    run(&controller, &mut adapted, &rests, cycles(5.0));
    assert_eq!(adapted.change(), before);
}

#[test]
fn little_moves_for_an_hour_leave_what_they_do_not_show() {
    // Between 50 and 60 mm, where gain, bend and width can hardly be told from an offset.
    let (controller, mut adapted) = (tracking::<f64>(), Adapted::default());
    let course = Course { is: &longer, ..SOUND };
    let learnt = run(&controller, &mut adapted, &course, cycles(8.0));
    let little = |tick: usize| 55.0 + (reference(tick) - 55.0) / 7.0;
    run(&controller, &mut adapted, &Course { reference: &little, ..course }, cycles(180.0));
    let after = run(&controller, &mut adapted, &Course { learns: false, ..course }, cycles(2.0));
    assert!(after < learnt + 1.0, "{learnt} mm, {after} mm, {:?}", adapted.change());
}

#[test]
fn a_muscle_that_is_another_one_is_told() {
    // It moves away, slowly enough to be followed, as far as the bounds, and on.
    let leaves = |tick: usize, mm: f64| mm + 2.0 * tick as f64 / cycles(1.0) as f64;
    let course = Course { is: &leaves, ..SOUND };
    let (controller, mut adapted) = (tracking::<f64>(), Adapted::default());
    run(&controller, &mut adapted, &course, cycles(9.0));
    assert!(!adapted.is_beyond(), "{:?}", adapted.change());
    run(&controller, &mut adapted, &Course { is: &|_, mm| mm + 30.0, ..course }, cycles(6.0));
    assert!(adapted.is_beyond() && BEYOND > 0, "{:?}", adapted.change());
    assert!(adapted.change().offset <= OFFSET, "{:?}", adapted.change());
}
