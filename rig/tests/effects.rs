//! Each hidden effect does what its name and its parameters say, on both plants.

use rig::body::{Balance, Body};
use rig::effect::Effect;
use rig::effects::{
    Creep, Effects, Inertia, Load, RateDependentWidth, Temperature, TransportDelay, ViscousLag, WarmUp,
};
use rig::operator::Operator;
use rig::parameters::DEAD_LOAD_N;
use rig::plant::{Kind, Plant, Setup};
use rig::protocol::Protocol;
use rig::recording::{Row, record};
use rig::surroundings::{REFERENCE_TEMPERATURE_C, Surroundings};

const KINDS: [Kind; 2] = [Kind::Rig, Kind::Mgpi];
const DT_S: f64 = 1e-3;
/// What the finer steps inside a plant with effects change, mm.
const PATH_MM: f64 = 0.02;
const SOUND: Surroundings = Surroundings {
    load_n: DEAD_LOAD_N,
    recorded_load_n: DEAD_LOAD_N,
    temperature_c: REFERENCE_TEMPERATURE_C,
    friction: 1.0,
};
/// Without friction both bodies have no memory, so that what is left is the effect.
const FRICTIONLESS: Surroundings = Surroundings { friction: 0.0, ..SOUND };

fn body(kind: Kind, effects: &Effects) -> Box<dyn Body> {
    match kind {
        Kind::Rig => Box::new(Balance::at_rest(DEAD_LOAD_N, effects)),
        Kind::Mgpi => Box::new(Operator::at_rest(DEAD_LOAD_N, effects, 1)),
    }
}

fn none() -> Effects {
    Effects::default()
}

/// The contraction after every millisecond of a pressure over time, mm.
fn driven_mm(
    body: &mut dyn Body,
    surroundings: &Surroundings,
    duration_s: f64,
    pressure_bar: impl Fn(f64) -> f64,
) -> Vec<f64> {
    let steps = (duration_s / DT_S).round() as usize;
    (1..=steps).map(|step| body.step(pressure_bar(step as f64 * DT_S), surroundings, DT_S)).collect()
}

fn noiseless(kind: Kind, effects: Effects) -> Vec<Row> {
    let mut plant = Plant::new(&Setup { kind, effects, noise: false, ..Setup::sound(1) });
    record(&Protocol::rich(1), &mut plant, 100.0).collect()
}

fn contractions_mm(rows: &[Row]) -> Vec<f64> {
    rows.iter().map(|row| row.measured.contraction_mm).collect()
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) = values.fold((0, 0.0), |(count, sum), value| (count + 1, sum + value * value));
    (sum / f64::from(count)).sqrt()
}

#[test]
fn strength_zero_is_none_bit_for_bit_and_the_same_seed_is_the_same_recording() {
    for kind in KINDS {
        let recorded = |effects| -> Vec<Row> {
            let mut plant = Plant::new(&Setup { kind, effects, ..Setup::sound(3) });
            record(&Protocol::rich(3), &mut plant, 100.0).collect()
        };
        let sound = recorded(none());
        assert_eq!(sound.len(), 12_000);
        for effect in Effect::ALL {
            let name = effect.name();
            assert_eq!(recorded(Effects::drawn(&[effect], 0.0, 3)), sound, "{name} at strength 0");
            let hidden = recorded(Effects::drawn(&[effect], 1.0, 3));
            assert!(hidden == recorded(Effects::drawn(&[effect], 1.0, 3)), "{name} does not repeat itself");
            assert!(hidden != sound, "{name} does nothing");
        }
    }
}

#[test]
fn weaker_effects_change_less_in_proportion() {
    for kind in KINDS {
        let sound = contractions_mm(&noiseless(kind, none()));
        let changed_mm = |effect, strength| {
            let other = contractions_mm(&noiseless(kind, Effects::drawn(&[effect], strength, 1)));
            rms(sound.iter().zip(&other).map(|(sound, other)| sound - other))
        };
        for effect in Effect::ALL {
            let (strong_mm, weak_mm) = (changed_mm(effect, 1.0), changed_mm(effect, 0.33));
            println!("{kind:?} {}: {strong_mm:.2} and {weak_mm:.2} mm", effect.name());
            // Saturation sets in at the top of the range only, where the curve is flat.
            let highest = if effect == Effect::SupplySaturation { 12.0 } else { 6.0 };
            let ratio = strong_mm / weak_mm;
            assert!((2.0..highest).contains(&ratio), "{} on {kind:?}: {ratio}", effect.name());
        }
    }
}

#[test]
fn only_the_valves_effects_show_in_the_pressure_and_only_the_load_in_its_column() {
    for kind in KINDS {
        let sound = noiseless(kind, none());
        for effect in Effect::ALL {
            let hidden = noiseless(kind, Effects::drawn(&[effect], 1.0, 2));
            let same = |of: fn(&Row) -> f64| {
                sound.iter().zip(&hidden).all(|(sound, hidden)| (of(sound) - of(hidden)).abs() < 2e-4)
            };
            assert_eq!(!same(|row| row.measured.pressure_bar), effect <= Effect::SupplySaturation);
            assert_eq!(!same(|row| row.measured.load_n), effect == Effect::Load);
            assert!(same(|row| row.measured.temperature_c) && same(|row| row.command_bar));
        }
    }
}

#[test]
fn transport_delay_shifts_the_contraction_in_time_and_nothing_else() {
    for kind in KINDS {
        let transport_delay = Some(TransportDelay { delay_s: 0.05 });
        let sound = contractions_mm(&noiseless(kind, none()));
        let late = contractions_mm(&noiseless(kind, Effects { transport_delay, ..none() }));
        let apart_mm = rms(sound.iter().zip(&late[5..]).map(|(sound, late)| sound - late));
        assert!(apart_mm < PATH_MM, "{apart_mm} mm apart on {kind:?}");
    }
}

#[test]
fn viscous_lag_delays_a_ramp_through_mid_stroke_by_its_time_constant() {
    for kind in KINDS {
        for time_constant_s in [0.03, 0.1] {
            let viscous_lag = Some(ViscousLag { time_constant_s });
            let passes_s = |effects: &Effects| {
                let ramp = driven_mm(&mut *body(kind, effects), &SOUND, 6.0, |time_s| time_s);
                ramp.iter().position(|mm| *mm >= 61.0).expect("mid stroke is reached") as f64 * DT_S
            };
            let lag_s = passes_s(&Effects { viscous_lag, ..none() }) - passes_s(&none());
            println!("{kind:?}: {lag_s} s for {time_constant_s} s");
            assert!((lag_s / time_constant_s - 1.0).abs() < 0.1, "{lag_s} s on {kind:?}");
        }
    }
}

#[test]
fn inertia_rings_at_its_frequency_and_dies_away_by_its_damping_ratio() {
    for kind in KINDS {
        let parameters = Inertia { natural_frequency_hz: 4.0, damping_ratio: 0.15 };
        let effects = Effects { inertia: Some(parameters), ..none() };
        let mut body = body(kind, &effects);
        driven_mm(&mut *body, &FRICTIONLESS, 5.0, |_| 1.9);
        let ringing = driven_mm(&mut *body, &FRICTIONLESS, 5.0, |_| 2.0);
        let rest_mm = ringing[ringing.len() - 1];
        let peaks: Vec<_> = (1..ringing.len() - 1)
            .filter(|&k| ringing[k] > rest_mm && ringing[k] >= ringing[k - 1] && ringing[k] > ringing[k + 1])
            .take(2)
            .map(|k| (k as f64 * DT_S, ringing[k] - rest_mm))
            .collect();
        let [(first_s, first_mm), (second_s, second_mm)] = peaks[..] else {
            panic!("no ringing on {kind:?}")
        };
        let decrement = (first_mm / second_mm).ln();
        let damping = decrement / decrement.hypot(std::f64::consts::TAU);
        let frequency_hz = 1.0 / (second_s - first_s) / (1.0 - damping * damping).sqrt();
        println!("{kind:?}: {frequency_hz} Hz, damping {damping}");
        assert!((frequency_hz / 4.0 - 1.0).abs() < 0.05, "{frequency_hz} Hz on {kind:?}");
        assert!((damping / 0.15 - 1.0).abs() < 0.1, "damping {damping} on {kind:?}");
    }
}

#[test]
fn rate_dependent_width_opens_the_loop_with_speed_and_closes_it_at_rest() {
    for kind in KINDS {
        let parameters = RateDependentWidth { width_gain: 0.4, rate_exponent: 0.5 };
        let effects = Effects { rate_dependent_width: Some(parameters), ..none() };
        let width_mm = |effects: &Effects, half_s: f64| {
            let triangle = |time_s: f64| 6.0 * (1.0 - (time_s / half_s - 1.0).abs());
            let triangle = driven_mm(&mut *body(kind, effects), &SOUND, 2.0 * half_s, triangle);
            triangle[triangle.len() * 5 / 6] - triangle[triangle.len() / 6]
        };
        let growth = |half_s| width_mm(&effects, half_s) / width_mm(&none(), half_s) - 1.0;
        let (slow, fast) = (growth(60.0), growth(1.5));
        println!("{kind:?}: loop wider by {slow:.3} slowly, {fast:.3} fast");
        assert!(slow < 0.5 * fast && (0.3..1.2).contains(&fast));

        let held_mm = |effects: &Effects| {
            let held = driven_mm(&mut *body(kind, effects), &SOUND, 4.0, |time_s| (3.0 * time_s).min(3.0));
            held[held.len() - 1]
        };
        let left_mm = (held_mm(&effects) - held_mm(&none())).abs();
        assert!(left_mm < 0.1, "{left_mm} mm left after 3 s at rest on {kind:?}");
    }
}

#[test]
fn creep_adds_its_fraction_in_every_decade_of_a_hold() {
    let parameters = Creep { fraction_per_decade: 0.03, time_constants_s: [0.2, 2.0, 20.0] };
    for kind in KINDS {
        let effects = Effects { creep: Some(parameters.clone()), ..none() };
        let hold = driven_mm(&mut *body(kind, &effects), &SOUND, 30.0, |_| 2.0);
        let end_mm = hold[hold.len() - 1];
        let share =
            |from_s: f64, to_s: f64| (hold[(to_s / DT_S) as usize] - hold[(from_s / DT_S) as usize]) / end_mm;
        let (early, late) = (share(0.2, 2.0), share(2.0, 20.0));
        println!("{kind:?}: {early:.4}, {late:.4} a decade");
        for share in [early, late] {
            assert!((0.02..0.05).contains(&share), "{share} a decade on {kind:?}");
        }
    }
}

#[test]
fn load_and_temperature_shift_the_contraction_by_offset_and_gain() {
    for kind in KINDS {
        let temperature = Some(Temperature { expansion_mm_per_k: 0.5, softening_per_k: 0.01 });
        let effects = Effects { load: Some(Load { swing_n: 10.0 }), temperature, ..none() };
        let sensitivities = body(kind, &effects).sensitivities();
        for pressure_bar in [2.0, 3.0, 5.0] {
            let at_mm = |surroundings: &Surroundings| {
                let hold = driven_mm(&mut *body(kind, &effects), surroundings, 0.1, |_| pressure_bar);
                hold[hold.len() - 1]
            };
            let rest_mm = at_mm(&FRICTIONLESS);
            let heavier = Surroundings { load_n: DEAD_LOAD_N + 1.0, ..FRICTIONLESS };
            let warmer = Surroundings { temperature_c: REFERENCE_TEMPERATURE_C + 1.0, ..FRICTIONLESS };
            for (surroundings, expected) in
                [(heavier, sensitivities.per_n), (warmer, sensitivities.per_k.expect("it feels it"))]
            {
                let (shift_mm, line_mm) =
                    (at_mm(&surroundings) - rest_mm, expected.offset_mm + expected.gain * rest_mm);
                println!("{kind:?} at {pressure_bar} bar: {shift_mm:.3} mm, by the line {line_mm:.3} mm");
                assert!((shift_mm - line_mm).abs() < 0.1, "{shift_mm} mm, not {line_mm} mm");
            }
        }
    }
}

#[test]
fn a_warm_up_tells_the_most_that_a_first_stroke_lacks() {
    for kind in KINDS {
        let warm_up = Some(WarmUp { fraction: 0.1, travel_mm: 1e9 });
        let cold = Effects { warm_up, ..none() };
        let held_mm = |effects: &Effects, pressure_bar: f64| {
            let hold = driven_mm(&mut *body(kind, effects), &FRICTIONLESS, 0.1, |_| pressure_bar);
            hold[hold.len() - 1]
        };
        let stroke_mm = held_mm(&none(), 6.0) - held_mm(&none(), 0.0);
        let lacks_mm = |bar: u32| held_mm(&none(), f64::from(bar)) - held_mm(&cold, f64::from(bar));
        let lacking = (0..=6).map(lacks_mm).fold(0.0, f64::max) / stroke_mm;
        let told = body(kind, &cold).sensitivities().lacking.expect("it warms up");
        println!("{kind:?}: {lacking:.4}, told {told:.4}");
        assert!((told / lacking - 1.0).abs() < 0.1, "{lacking}, told {told}");
    }
}

#[test]
fn drift_and_tone_are_added_to_the_reading_as_named() {
    let effects = Effects::drawn(&[Effect::Drift, Effect::PeriodicDisturbance], 1.0, 5);
    let (drift, tone) =
        (effects.drift.clone().expect("drawn"), effects.periodic_disturbance.clone().expect("drawn"));
    for kind in KINDS {
        for (sound, hidden) in noiseless(kind, none()).iter().zip(noiseless(kind, effects.clone())) {
            let angle = std::f64::consts::TAU * tone.frequency_hz * sound.time_s + tone.phase_rad;
            let expected_mm = drift.mm_per_s * sound.time_s + tone.amplitude_mm * angle.sin();
            let shift_mm = hidden.measured.contraction_mm - sound.measured.contraction_mm;
            assert!((shift_mm - expected_mm).abs() < PATH_MM, "{shift_mm} mm, not {expected_mm} mm");
        }
    }
}

#[test]
fn warm_up_changes_the_first_cycles_and_fades_with_travel() {
    for kind in KINDS {
        let warm_up = Some(WarmUp { fraction: 0.15, travel_mm: 300.0 });
        let peaks_and_trough_mm = |effects: &Effects| {
            let cycle = |time_s: f64| 3.0 * (1.0 - (std::f64::consts::TAU * time_s / 4.0).cos());
            let cycles = driven_mm(&mut *body(kind, effects), &SOUND, 40.0, cycle);
            let peaks: Vec<_> = cycles.chunks(4000).map(|cycle| cycle[2000]).collect();
            (peaks, cycles[cycles.len() - 1])
        };
        let (sound_mm, troughs_mm) = peaks_and_trough_mm(&none());
        let (hidden_mm, _) = peaks_and_trough_mm(&Effects { warm_up, ..none() });
        let less_mm: Vec<_> = sound_mm.iter().zip(&hidden_mm).map(|(sound, hidden)| sound - hidden).collect();
        println!("{kind:?}: {less_mm:.2?} mm less");
        assert!(less_mm[0] > 2.0 && less_mm[9] < 0.05);
        let expected = (-2.0 * (sound_mm[2] - troughs_mm) / 300.0).exp();
        let ratio = less_mm[2] / less_mm[1];
        assert!((ratio / expected - 1.0).abs() < 0.15, "{ratio} a cycle, not {expected}, on {kind:?}");
    }
}

#[test]
fn the_truth_names_causes_with_the_parameters_of_a_diagnosis() {
    let truth = |effects: &[Effect]| {
        Plant::new(&Setup { effects: Effects::drawn(effects, 1.0, 4), ..Setup::sound(4) }).truth()
    };
    for (cause, parameters) in [
        (Effect::ValveLag, &["time_constant_s"][..]),
        (Effect::ValveDeadband, &["band_bar"]),
        (Effect::SupplySaturation, &["supply_bar"]),
        (Effect::TransportDelay, &["delay_s"]),
        (Effect::ViscousLag, &["time_constant_s"]),
        (Effect::RateDependentWidth, &["width_gain", "rate_exponent"]),
        (Effect::Inertia, &["natural_frequency_hz", "damping_ratio"]),
        (Effect::Creep, &["fraction_per_decade", "time_constants_s"]),
        (Effect::Load, &["offset_mm_per_n", "gain_per_n"]),
        (Effect::Temperature, &["offset_mm_per_k", "gain_per_k"]),
        (Effect::Drift, &["mm_per_s"]),
        (Effect::WarmUp, &["fraction", "travel_mm"]),
        (Effect::PeriodicDisturbance, &["frequency_hz", "amplitude_mm"]),
    ] {
        let truth = truth(&[cause]);
        assert_eq!(truth.causes.len(), 1);
        for name in parameters {
            assert!(truth.causes[cause.name()].contains_key(*name), "{name} of {}", cause.name());
        }
    }
    let both = truth(&[Effect::Drift, Effect::Leak]);
    assert!(both.causes.contains_key("drift") && both.outsiders.contains_key("leak"));
    assert_eq!(truth(&[]), Plant::new(&Setup::sound(1)).truth());
}
