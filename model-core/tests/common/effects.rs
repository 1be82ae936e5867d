//! Every effect, as strong as on a muscle, on the paper's model.
#![allow(dead_code, reason = "each file of tests uses a part of it")]

use model_core::extension::{
    CreepParameters, DeadbandForm, DriftParameters, PeriodicDisturbanceParameters, PressureRateParameters,
    ProfileParameters, RateDependentThresholdsParameters, RateDependentWidthParameters, ScheduleParameters,
    Site, SupplySaturationParameters, TransportDelayParameters, ValveDeadbandParameters, ValveLagParameters,
    WarmUpParameters,
};
use model_core::{ExtensionParameters, ModelParameters, paper};

pub const SIZE: usize = paper::SIZE;
pub const PERIOD_S: f64 = 1e-3;
/// Unit: s.
pub const DELAY_S: f64 = 0.02;
pub const DELAY_TICKS: usize = 20;

pub type Extensions = ExtensionParameters<f64>;
/// An effect: its name, and how it is put in.
pub type Effect = (&'static str, fn(&mut Extensions));

/// The paper's muscle, which has been through its range.
pub fn muscle() -> ModelParameters<f64, SIZE, SIZE> {
    ModelParameters::Cascade(paper::mgpi().expect("valid")).with_preconditioned(true)
}

pub fn profile(values: [f64; 3]) -> ProfileParameters<f64> {
    ProfileParameters {
        knots: [10.0, 60.0, 110.0].into_iter().collect(),
        values: values.into_iter().collect(),
    }
}

fn deadband(form: DeadbandForm) -> Option<ValveDeadbandParameters<f64>> {
    Some(ValveDeadbandParameters { band: 0.05, form })
}

/// Those of which forward of inverse and inverse of forward are exact.
pub const EXACT: [Effect; 12] = [
    ("valve_lag", |all| {
        all.valve_lag = Some(ValveLagParameters { lead_limit: 100.0, ..ValveLagParameters::new(0.05) })
    }),
    ("transport_delay", |all| all.transport_delay = Some(TransportDelayParameters { delay_s: DELAY_S })),
    ("load", |all| {
        all.load = Some(ScheduleParameters { reference: 20.0, offset: profile([0.01, 0.02, 0.04]) })
    }),
    ("temperature", |all| {
        all.temperature = Some(ScheduleParameters { reference: 25.0, offset: profile([-0.01, 0.01, 0.02]) });
    }),
    ("warm_up", |all| {
        all.warm_up = Some(WarmUpParameters { travel: 300.0, offset: profile([0.3, 0.2, 0.1]) })
    }),
    ("viscous_lag", |all| all.viscous_lag = Some(profile([0.002, 0.003, 0.006]))),
    ("inertia", |all| all.inertia = Some(profile([2e-5, 3e-5, 2e-5]))),
    ("rate_dependent_width", |all| {
        all.rate_dependent_width = Some(RateDependentWidthParameters {
            radius: 0.1,
            exponent: 0.5,
            filter_s: 0.01,
            width: profile([0.05, 0.1, 0.2]),
        });
    }),
    ("rate_dependent_thresholds", |all| {
        all.rate_dependent_thresholds = Some(RateDependentThresholdsParameters {
            exponent: 0.5,
            filter_s: 0.01,
            gain: profile([0.02, 0.03, 0.04]),
            pressure: None,
        });
    }),
    ("creep", |all| {
        all.creep = Some(CreepParameters {
            time_constants_s: [0.1, 1.0, 10.0, 100.0].into_iter().collect(),
            fractions: [0.02, 0.03, 0.03, 0.02].into_iter().collect(),
        });
    }),
    ("drift", |all| all.drift = Some(DriftParameters { rate_per_s: 0.05, compensated: true })),
    ("periodic_disturbance", |all| {
        all.periodic_disturbance = Some(PeriodicDisturbanceParameters {
            amplitude: 0.5,
            frequency_hz: 3.0,
            phase_rad: 1.0,
            compensated: true,
        });
    }),
];

/// Those that act behind the hysteresis instead of before it, and creep the other way round. Exact
/// too.
pub const ELSEWHERE: [Effect; 6] = [
    ("load behind", |all| {
        all.load = Some(ScheduleParameters { reference: 20.0, offset: profile([0.1, 0.2, 0.3]) });
        all.sites.load = Site::Contraction;
    }),
    ("temperature behind", |all| {
        all.temperature = Some(ScheduleParameters { reference: 25.0, offset: profile([-0.1, 0.1, 0.4]) });
        all.sites.temperature = Site::Contraction;
    }),
    ("warm_up behind", |all| {
        all.warm_up = Some(WarmUpParameters { travel: 300.0, offset: profile([0.5, 4.0, 8.0]) });
        all.sites.warm_up = Site::Contraction;
    }),
    ("viscous_lag behind", |all| {
        all.viscous_lag = Some(profile([0.03, 0.05, 0.06]));
        all.sites.viscous_lag = Site::Contraction;
    }),
    ("inertia behind", |all| {
        all.inertia = Some(profile([5e-4, 4e-4, 4e-4]));
        all.sites.inertia = Site::Contraction;
    }),
    ("creep before", |all| {
        all.creep = Some(CreepParameters {
            time_constants_s: [0.1, 1.0, 10.0, 100.0].into_iter().collect(),
            fractions: [0.02, 0.03, 0.03, 0.02].into_iter().collect(),
        });
        all.sites.creep = Site::Pressure;
    }),
];

/// Those that lose something of the command: several commands have one answer.
pub const LOSSY: [Effect; 3] = [
    ("backlash", |all| all.valve_deadband = deadband(DeadbandForm::Backlash)),
    ("hold", |all| all.valve_deadband = deadband(DeadbandForm::Hold)),
    ("supply_saturation", |all| all.supply_saturation = Some(SupplySaturationParameters { supply: 5.5 })),
];

/// Thresholds by the rate of the pressure, which the inverse does not know.
pub const BY_PRESSURE: Effect = ("thresholds by the pressure", |all| {
    all.rate_dependent_thresholds = Some(RateDependentThresholdsParameters {
        exponent: 0.5,
        filter_s: 0.01,
        gain: profile([0.06, 0.06, 0.06]),
        pressure: Some(PressureRateParameters { gain: 0.3, resolution: 0.002 }),
    });
});

/// These effects together.
pub fn together<'a>(effects: impl IntoIterator<Item = &'a Effect>) -> Extensions {
    let mut all = Extensions::default();
    effects.into_iter().for_each(|(_, put_in)| put_in(&mut all));
    all
}

/// Their names.
pub fn names<'a>(effects: impl IntoIterator<Item = &'a Effect>) -> String {
    effects.into_iter().map(|(name, _)| *name).collect::<Vec<_>>().join(" + ")
}

/// The sets of either list, and those of [`ELSEWHERE`] with delay and drift. A kink (the tone's
/// begin) or a root of the rate (the width's) is left out: behind an inertia the lead of a valve
/// would follow it beyond all limits.
pub fn exact_sets() -> Vec<Vec<Effect>> {
    let sideless = ["transport_delay", "drift"];
    let mixed = EXACT.into_iter().filter(|(name, _)| sideless.contains(name)).chain(ELSEWHERE);
    let mut all = sets(&EXACT);
    all.extend(sets(&ELSEWHERE));
    all.push(mixed.collect());
    all
}

/// Every single effect of a list, every pair, and all.
pub fn sets(effects: &[Effect]) -> Vec<Vec<Effect>> {
    let mut sets: Vec<Vec<Effect>> = effects.iter().map(|one| vec![*one]).collect();
    for (i, one) in effects.iter().enumerate() {
        sets.extend(effects[i + 1..].iter().map(|other| vec![*one, *other]));
    }
    sets.push(effects.to_vec());
    sets
}
