//! The length gauge: what stands between the muscle's contraction and the reading, noise aside.
//!
//! Tone and drift are causes a diagnosis can name. The rest is not on its list: a step of the zero,
//! a bend of the curve that comes and goes, a rod that sticks and jumps, bursts of a foreign
//! signal, outliers.

use std::f64::consts::TAU;

use crate::draw::Draw;
use crate::effect::Effect;
use crate::effects::{Drift, Effects, PeriodicDisturbance};
use crate::scale::Scale;
use crate::wander::{Staircase, Wave};

/// Step of the zero at strength 1, mm.
const ZERO_STEP_MM: f64 = 4.5;
/// Largest bend at strength 1, mm, between 0 mm and [`BEND_RANGE_MM`].
const BEND_MM: f64 = 5.0;
/// Range of the gauge, mm.
const BEND_RANGE_MM: f64 = 125.0;
/// Largest distance at which the rod still sticks at strength 1, mm.
const STICK_MM: f64 = 6.0;
/// Amplitude of the foreign signal at strength 1, mm.
const CROSS_TALK_MM: f64 = 3.0;
/// Largest outlier at strength 1, mm, and the share of samples that are.
const OUTLIER_MM: f64 = 25.0;
const OUTLIER_SHARE: f64 = 0.01;

/// A gauge with its faults.
#[derive(Debug, Clone)]
pub(crate) struct Gauge {
    drift: Option<Drift>,
    tone: Option<PeriodicDisturbance>,
    /// Time, s, and height, mm.
    zero_step: Option<(f64, f64)>,
    /// Height, mm, and its course.
    bend: Option<(f64, Wave)>,
    range_mm: f64,
    rod: Option<Rod>,
    /// Bursts, and the signal in them.
    cross_talk: Option<(f64, Staircase, Wave)>,
    outliers: Option<(f64, Draw)>,
}

/// A rod that sticks until the muscle is some random distance away, then jumps to it.
#[derive(Debug, Clone)]
struct Rod {
    draw: Draw,
    largest_mm: f64,
    distance_mm: f64,
    stuck_mm: f64,
}

impl Gauge {
    pub(crate) fn new(effects: &Effects, scale: &Scale, seed: u64) -> Self {
        let fault = |effect: Effect| {
            let strength = effects.outsider(effect);
            (strength > 0.0).then(|| (strength, effect.course(seed)))
        };
        Self {
            drift: effects.drift.clone(),
            tone: effects.periodic_disturbance.clone(),
            zero_step: fault(Effect::ZeroStep).map(|(strength, mut draw)| {
                let step_s = scale.duration * draw.uniform(35.0, 85.0);
                (step_s, scale.length * strength * draw.around(ZERO_STEP_MM) * draw.sign())
            }),
            bend: fault(Effect::SensorNonlinearity).map(|(strength, mut draw)| {
                (scale.length * strength * BEND_MM, Wave::new(&mut draw, 15.0, 60.0))
            }),
            range_mm: scale.length * BEND_RANGE_MM,
            rod: fault(Effect::StickSlip).map(|(strength, draw)| Rod {
                draw,
                largest_mm: scale.length * strength * STICK_MM,
                distance_mm: 0.0,
                stuck_mm: 0.0,
            }),
            cross_talk: fault(Effect::CrossTalk).map(|(strength, mut draw)| {
                let signal = Wave::new(&mut draw, 0.1, 3.0);
                (scale.length * strength * CROSS_TALK_MM, Staircase::new(draw, 0.5, 5.0), signal)
            }),
            outliers: fault(Effect::Outliers)
                .map(|(strength, draw)| (scale.length * strength * OUTLIER_MM, draw)),
        }
    }

    /// The reading of `contraction_mm` at `time_s`, which never goes back, mm.
    pub(crate) fn read(&mut self, contraction_mm: f64, time_s: f64) -> f64 {
        let mut reading_mm = contraction_mm;
        if let Some(rod) = &mut self.rod {
            reading_mm = rod.at(reading_mm);
        }
        if let Some((bend_mm, wave)) = &self.bend {
            let share = reading_mm / self.range_mm;
            reading_mm += 4.0 * bend_mm * wave.at(time_s) * share * (1.0 - share);
        }
        if let Some(drift) = &self.drift {
            reading_mm += drift.mm_per_s * time_s;
        }
        if let Some(PeriodicDisturbance { frequency_hz, amplitude_mm, phase_rad }) = &self.tone {
            reading_mm += amplitude_mm * (TAU * frequency_hz * time_s + phase_rad).sin();
        }
        if let Some((step_s, step_mm)) = self.zero_step
            && time_s >= step_s
        {
            reading_mm += step_mm;
        }
        if let Some((amplitude_mm, bursts, signal)) = &mut self.cross_talk {
            // Squared, so that most of the time is nearly quiet.
            reading_mm += *amplitude_mm * bursts.at(time_s).powi(2) * signal.at(time_s);
        }
        if let Some((largest_mm, draw)) = &mut self.outliers
            && draw.uniform(0.0, 1.0) < OUTLIER_SHARE
        {
            reading_mm += *largest_mm * draw.uniform(-1.0, 1.0);
        }
        reading_mm
    }
}

impl Rod {
    fn at(&mut self, contraction_mm: f64) -> f64 {
        if (contraction_mm - self.stuck_mm).abs() >= self.distance_mm {
            self.stuck_mm = contraction_mm;
            self.distance_mm = self.draw.uniform(0.2, 1.0) * self.largest_mm;
        }
        self.stuck_mm
    }
}
