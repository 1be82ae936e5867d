//! The extensions that a diagnosis has found, with the parameters that were hidden in their place.

use std::f64::consts::TAU;

use diagnosis::extend::Extension;
use diagnosis::turn::Loop;
use model_core::ExtensionParameters;
use model_core::extension::profile::Profile;
use model_core::extension::{CreepParameters, DeadbandForm, PressureRateParameters, ProfileParameters, Site};
use rig::dynamics::RATE_UNIT_MM_PER_S;
use rig::plant::Kind;
use serde_json::{Map, Value};

/// The least slope that is divided by. Unit: mm/bar.
const LEAST_SLOPE: f64 = 1.0;

/// What the input of a found operator does to the contraction.
struct Turn(Loop);

impl Turn {
    fn of(found: &Extension) -> Option<Self> {
        Loop::of_operator(&found.parameters).map(Self)
    }

    /// Unit: mm/bar.
    fn slope(&self, at: f64) -> f64 {
        self.0.slope(at).max(LEAST_SLOPE)
    }

    /// How much contraction an amount at a site is, mm.
    fn contraction(&self, site: Site, at: f64) -> f64 {
        match site {
            Site::Pressure => self.slope(at),
            Site::Contraction => 1.0,
        }
    }

    /// Scales a profile to what it comes to in the contraction at mid stroke.
    fn scale(&self, profile: &mut ProfileParameters<f64>, site: Site, hidden: f64) -> Option<()> {
        let middle = 0.5 * (profile.knots.first()? + profile.knots.last()?);
        let found = Profile::try_new(profile, "profile", "").ok()?.value(middle);
        let times = hidden / (found * self.contraction(site, middle));
        profile.values.iter_mut().for_each(|value| *value *= times);
        times.is_finite().then_some(())
    }

    /// Scales a profile to what comes to such a share of the stroke at most.
    fn scale_to_most(&self, profile: &mut ProfileParameters<f64>, site: Site, share: f64) -> Option<()> {
        let moved =
            profile.knots.iter().zip(&profile.values).map(|(&at, value)| value * self.contraction(site, at));
        let most = moved.map(f64::abs).fold(0.0, f64::max);
        let times = share * (profile.knots.last()? - profile.knots.first()?) / most;
        profile.values.iter_mut().for_each(|value| *value *= times);
        times.is_finite().then_some(())
    }

    /// Sets a profile to what moves the contraction by so much at every contraction.
    fn set(&self, profile: &mut ProfileParameters<f64>, site: Site, moved: impl Fn(f64) -> f64) {
        for (&at, value) in profile.knots.iter().zip(&mut profile.values) {
            *value = -moved(at) / self.contraction(site, at);
        }
    }
}

/// The extensions of `found` with the parameters of `cause` as they are hidden in a plant; the rest stays. None where the
/// extension is not there, or has none of them.
///
/// On the plant that is forces a width goes by the speed relative to [`RATE_UNIT_MM_PER_S`], and a warm-up's form is that of a force, so
/// that the found one stays; on the operator plant a width goes by the rate of the pressure.
pub fn with_hidden(
    found: &Extension,
    kind: Kind,
    cause: &str,
    hidden: &Map<String, Value>,
) -> Option<ExtensionParameters<f64>> {
    let turn = Turn::of(found)?;
    let get = |name: &str| hidden.get(name)?.as_f64();
    let mut all = found.extensions.clone();
    let sites = all.sites;
    match cause {
        "valve_lag" => all.valve_lag.as_mut()?.time_constant_s = get("time_constant_s")?,
        "valve_deadband" => {
            let deadband = all.valve_deadband.as_mut()?;
            let band = get("band_bar")?;
            deadband.band = if deadband.form == DeadbandForm::Hold { band } else { 0.5 * band };
        }
        "supply_saturation" => all.supply_saturation.as_mut()?.supply = get("supply_bar")?,
        "transport_delay" => all.transport_delay.as_mut()?.delay_s = get("delay_s")?,
        "viscous_lag" => {
            turn.scale(all.viscous_lag.as_mut()?, sites.viscous_lag, get("time_constant_s")?)?;
        }
        "inertia" => {
            let natural_per_s = TAU * get("natural_frequency_hz")?;
            turn.scale(all.inertia.as_mut()?, sites.inertia, natural_per_s.powi(-2))?;
            let damping_s = 2.0 * get("damping_ratio")? / natural_per_s;
            turn.scale(all.viscous_lag.as_mut()?, sites.viscous_lag, damping_s)?;
        }
        "rate_dependent_width" => {
            let thresholds = all.rate_dependent_thresholds.as_mut()?;
            let (gain, exponent) = (get("width_gain")?, get("rate_exponent")?);
            thresholds.exponent = exponent;
            let resolution = thresholds.pressure.map_or(0.0, |pressure| pressure.resolution);
            let by_pressure = PressureRateParameters { gain, resolution };
            thresholds.pressure = (kind == Kind::Mgpi).then_some(by_pressure);
            for (&at, value) in thresholds.gain.knots.iter().zip(&mut thresholds.gain.values) {
                let one_mm_per_s = match kind {
                    Kind::Rig => RATE_UNIT_MM_PER_S,
                    Kind::Mgpi => turn.slope(at),
                };
                *value = gain / one_mm_per_s.powf(exponent);
            }
        }
        "creep" => {
            let fraction = get("fraction_per_decade")?;
            let time_constants_s = hidden.get("time_constants_s")?.as_array()?.iter().map(Value::as_f64);
            let time_constants_s = time_constants_s.collect::<Option<model_core::List<f64, _>>>()?;
            let fractions = time_constants_s.iter().map(|_| fraction).collect();
            all.creep.as_ref()?;
            all.creep = Some(CreepParameters { time_constants_s, fractions });
            all.sites.creep = match kind {
                Kind::Rig => Site::Contraction,
                Kind::Mgpi => Site::Pressure,
            };
        }
        "load" => {
            let (offset, gain) = (get("offset_mm_per_n")?, get("gain_per_n")?);
            turn.set(&mut all.load.as_mut()?.offset, sites.load, |y| offset + gain * y);
        }
        "temperature" => {
            let (offset, gain) = (get("offset_mm_per_k")?, get("gain_per_k")?);
            turn.set(&mut all.temperature.as_mut()?.offset, sites.temperature, |y| offset + gain * y);
        }
        "warm_up" => {
            let warm_up = all.warm_up.as_mut()?;
            warm_up.travel = get("travel_mm")?;
            let fraction = get("fraction")?;
            let lacking = fraction / (1.0 - fraction);
            match kind {
                Kind::Rig => turn.scale_to_most(&mut warm_up.offset, sites.warm_up, lacking)?,
                Kind::Mgpi => turn.set(&mut warm_up.offset, sites.warm_up, |y| -y * lacking),
            }
        }
        "drift" => all.drift.as_mut()?.rate_per_s = get("mm_per_s")?,
        "periodic_disturbance" => {
            let tone = all.periodic_disturbance.as_mut()?;
            (tone.amplitude, tone.frequency_hz) = (get("amplitude_mm")?, get("frequency_hz")?);
        }
        _ => return None,
    }
    Some(all)
}
