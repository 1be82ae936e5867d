//! The extensions of a model in its file: a table `[extensions.<cause>]` for each.
//!
//! Each cause's keys are written down once, with what a change of units multiplies them by:
//! [`Fields`] takes a value out of the file, puts it there, or brings it to other units. A profile
//! is two lists, its knots and the values there; the unit of these tells, like `acts_on`, whether
//! the effect acts before the hysteresis or behind it.

use model_core::ExtensionParameters;
use model_core::extension::creep::CREEP_ELEMENTS;
use model_core::extension::profile::PROFILE_KNOTS;
use model_core::extension::valve_lag::LEAD_LIMIT;
use model_core::extension::{
    CreepParameters, DeadbandForm, DriftParameters, PeriodicDisturbanceParameters, PressureRateParameters,
    ProfileParameters, RateDependentThresholdsParameters, RateDependentWidthParameters, ScheduleParameters,
    Site, SupplySaturationParameters, TransportDelayParameters, ValveDeadbandParameters, ValveLagForm,
    ValveLagParameters, WarmUpParameters,
};
use toml::{Table, Value};

use super::names::Names;
use super::parameters::numbers;
use super::scale::{Scale, bar};
use super::section::{KeyError, Section};
use super::values::list;

const EXTENSIONS: &str = "extensions";
/// The forms of a valve's dead band.
const FORMS: [(DeadbandForm, &str); 2] = [(DeadbandForm::Hold, "hold"), (DeadbandForm::Backlash, "backlash")];

/// Where an effect acts. A file that does not say so has it where most are.
const ACTS_ON: &str = "acts_on";
const SITES: [(Site, &str); 2] = [(Site::Pressure, "pressure"), (Site::Contraction, "contraction")];

/// Takes the extensions out of the file's top level; a file without any has none.
pub fn read(top: &mut Section, names: &Names) -> Result<ExtensionParameters<f64>, KeyError> {
    let mut extensions = ExtensionParameters::default();
    if let Some(section) = top.optional_section(EXTENSIONS)? {
        let mut fields = Fields::Read(section);
        causes(&mut fields, names, Scale::NONE, &mut extensions)?;
        fields.finish()?;
    }
    Ok(extensions)
}

/// The extensions with parameters in other units than those of `names`.
pub fn scaled(
    extensions: &ExtensionParameters<f64>,
    names: &Names,
    scale: Scale,
) -> ExtensionParameters<f64> {
    let mut scaled = extensions.clone();
    // A change of units has no errors.
    let _ = causes(&mut Fields::Scale, names, scale, &mut scaled);
    scaled
}

/// The names of the causes.
pub fn causes_of(extensions: &ExtensionParameters<f64>, names: &Names) -> Vec<String> {
    let mut top = Table::new();
    write(extensions, names, &mut top);
    let causes = top.get(EXTENSIONS).and_then(Value::as_table);
    causes.map_or_else(Vec::new, |causes| causes.keys().cloned().collect())
}

/// Puts the extensions into the file's top level; none leave nothing.
pub fn write(extensions: &ExtensionParameters<f64>, names: &Names, top: &mut Table) {
    let mut fields = Fields::Write(Table::new());
    // Writing has no errors.
    let _ = causes(&mut fields, names, Scale::NONE, &mut extensions.clone());
    if let Fields::Write(table) = fields
        && !table.is_empty()
    {
        top.insert(EXTENSIONS.to_owned(), Value::Table(table));
    }
}

/// How far the compensation of a valve's lag leads where nobody says so: the usual limit is a
/// pressure, and of another input nothing is known. Input unit.
pub fn lead_limit(names: &Names) -> f64 {
    LEAD_LIMIT / bar(names.input).unwrap_or(1.0)
}

/// Every cause with its keys; behind each key is what `scale` multiplies its value by.
fn causes(
    file: &mut Fields,
    names: &Names,
    scale: Scale,
    extensions: &mut ExtensionParameters<f64>,
) -> Result<(), KeyError> {
    let (input, output) = (names.input.suffix(), names.output.suffix());
    let knots = format!("knots_{output}");
    let unit = |site| if site == Site::Pressure { input } else { output };
    // Behind the hysteresis per unit of the contraction itself.
    let per = |site| {
        if site == Site::Pressure {
            (format!("_{input}"), format!("_per_{output}"))
        } else {
            Default::default()
        }
    };
    let Scale { input: x, output: y } = scale;
    // Of what acts before the hysteresis, per unit of the contraction and its rates; behind it the
    // units of the contraction cancel.
    let strength = |site| if site == Site::Pressure { x } else { y };
    let ratio = |site| strength(site) / y;
    let profile = || ProfileParameters { knots: empty(), values: empty() };
    let ExtensionParameters {
        valve_deadband,
        supply_saturation,
        valve_lag,
        transport_delay,
        load,
        temperature,
        warm_up,
        viscous_lag,
        inertia,
        rate_dependent_width,
        rate_dependent_thresholds,
        creep,
        drift,
        periodic_disturbance,
        sites,
    } = extensions;

    let blank = ValveDeadbandParameters { band: 0.0, form: DeadbandForm::Hold };
    file.cause("valve_deadband", valve_deadband, blank, |fields, deadband| {
        fields.number(&format!("band_{input}"), x, &mut deadband.band)?;
        fields.choice("form", &mut deadband.form, &FORMS)
    })?;
    let blank = SupplySaturationParameters { supply: 0.0 };
    file.cause("supply_saturation", supply_saturation, blank, |fields, saturation| {
        fields.number(&format!("supply_{input}"), x, &mut saturation.supply)
    })?;
    let blank = ValveLagParameters { lead_limit: lead_limit(names), ..ValveLagParameters::new(0.0) };
    file.cause("valve_lag", valve_lag, blank, |fields, lag| {
        fields.number("time_constant_s", 1.0, &mut lag.time_constant_s)?;
        fields.optional_number(&format!("lead_limit_{input}"), x, &mut lag.lead_limit)?;
        lag_form(fields, input, x, &mut lag.form)
    })?;
    let blank = TransportDelayParameters { delay_s: 0.0 };
    file.cause("transport_delay", transport_delay, blank, |fields, delay| {
        fields.number("delay_s", 1.0, &mut delay.delay_s)
    })?;
    for (cause, reference, per, schedule, site) in [
        ("load", "reference_n", "n", load, &mut sites.load),
        ("temperature", "reference_c", "k", temperature, &mut sites.temperature),
    ] {
        let blank = ScheduleParameters { reference: 0.0, offset: profile() };
        file.cause(cause, schedule, blank, |fields, schedule| {
            fields.optional_choice(ACTS_ON, site, &SITES, Site::Pressure)?;
            fields.number(reference, 1.0, &mut schedule.reference)?;
            let key = format!("offset_{}_per_{per}", unit(*site));
            fields.profile((&knots, y), (&key, strength(*site)), &mut schedule.offset)
        })?;
    }
    let blank = WarmUpParameters { travel: 0.0, offset: profile() };
    file.cause("warm_up", warm_up, blank, |fields, warm_up| {
        fields.optional_choice(ACTS_ON, &mut sites.warm_up, &SITES, Site::Pressure)?;
        fields.number(&format!("travel_{output}"), y, &mut warm_up.travel)?;
        let key = format!("offset_{}", unit(sites.warm_up));
        fields.profile((&knots, y), (&key, strength(sites.warm_up)), &mut warm_up.offset)
    })?;
    file.cause("viscous_lag", viscous_lag, profile(), |fields, viscosity| {
        fields.optional_choice(ACTS_ON, &mut sites.viscous_lag, &SITES, Site::Pressure)?;
        let (of, per) = per(sites.viscous_lag);
        let key = format!("viscosity{of}_s{per}");
        fields.profile((&knots, y), (&key, ratio(sites.viscous_lag)), viscosity)
    })?;
    file.cause("inertia", inertia, profile(), |fields, inertia| {
        fields.optional_choice(ACTS_ON, &mut sites.inertia, &SITES, Site::Pressure)?;
        let (of, per) = per(sites.inertia);
        let key = format!("inertia{of}_s2{per}");
        fields.profile((&knots, y), (&key, ratio(sites.inertia)), inertia)
    })?;
    let blank = RateDependentWidthParameters { radius: 0.0, exponent: 0.0, filter_s: 0.0, width: profile() };
    file.cause("rate_dependent_width", rate_dependent_width, blank, |fields, width| {
        fields.number(&format!("radius_{input}"), x, &mut width.radius)?;
        fields.number("exponent", 1.0, &mut width.exponent)?;
        fields.number("filter_s", 1.0, &mut width.filter_s)?;
        // At one unit a second, to the power of the exponent.
        let factor = x * x.powf(-width.exponent);
        fields.profile((&knots, y), (&format!("width_{input}"), factor), &mut width.width)
    })?;
    let blank =
        RateDependentThresholdsParameters { exponent: 0.0, filter_s: 0.0, gain: profile(), pressure: None };
    file.cause("rate_dependent_thresholds", rate_dependent_thresholds, blank, |fields, thresholds| {
        fields.number("exponent", 1.0, &mut thresholds.exponent)?;
        fields.number("filter_s", 1.0, &mut thresholds.filter_s)?;
        let rate = |one: f64| one.powf(-thresholds.exponent);
        fields.profile((&knots, y), ("gain", rate(y)), &mut thresholds.gain)?;
        if fields.has("pressure_gain", thresholds.pressure.is_some()) {
            let blank = PressureRateParameters { gain: 0.0, resolution: 0.0 };
            let pressure = thresholds.pressure.get_or_insert(blank);
            fields.number("pressure_gain", rate(x), &mut pressure.gain)?;
            fields.number(&format!("resolution_{input}"), x, &mut pressure.resolution)?;
        }
        Ok(())
    })?;
    let blank = CreepParameters { time_constants_s: empty(), fractions: empty() };
    file.cause("creep", creep, blank, |fields, creep| {
        fields.optional_choice(ACTS_ON, &mut sites.creep, &SITES, Site::Contraction)?;
        fields.numbers("time_constants_s", 1.0, CREEP_ELEMENTS, &mut creep.time_constants_s)?;
        fields.numbers("fractions", 1.0, CREEP_ELEMENTS, &mut creep.fractions)
    })?;
    let blank = DriftParameters { rate_per_s: 0.0, compensated: false };
    file.cause("drift", drift, blank, |fields, drift| {
        fields.number(&format!("rate_{output}_per_s"), y, &mut drift.rate_per_s)?;
        fields.truth("compensated", &mut drift.compensated)
    })?;
    let blank = PeriodicDisturbanceParameters {
        amplitude: 0.0,
        frequency_hz: 0.0,
        phase_rad: 0.0,
        compensated: false,
    };
    file.cause("periodic_disturbance", periodic_disturbance, blank, |fields, tone| {
        fields.number(&format!("amplitude_{output}"), y, &mut tone.amplitude)?;
        fields.number("frequency_hz", 1.0, &mut tone.frequency_hz)?;
        fields.number("phase_rad", 1.0, &mut tone.phase_rad)?;
        fields.truth("compensated", &mut tone.compensated)
    })
}

/// How a valve's pressure goes: of the first order where no key says more.
fn lag_form(fields: &mut Fields, input: &str, x: f64, form: &mut ValveLagForm<f64>) -> Result<(), KeyError> {
    let [supply_key, outside_key] = ["supply", "outside"].map(|end| format!("absolute_{end}_{input}"));
    if fields.has("damping_ratio", matches!(form, ValveLagForm::SecondOrder { .. })) {
        let mut damping_ratio =
            if let ValveLagForm::SecondOrder { damping_ratio } = form { *damping_ratio } else { 0.0 };
        fields.number("damping_ratio", 1.0, &mut damping_ratio)?;
        *form = ValveLagForm::SecondOrder { damping_ratio };
    } else if fields.has(&supply_key, matches!(form, ValveLagForm::Orifice { .. })) {
        let (mut supply, mut outside) = if let ValveLagForm::Orifice { supply, outside } = form {
            (*supply, *outside)
        } else {
            (0.0, 0.0)
        };
        fields.number(&supply_key, x, &mut supply)?;
        fields.number(&outside_key, x, &mut outside)?;
        *form = ValveLagForm::Orifice { supply, outside };
    }
    Ok(())
}

/// A table whose values are taken out of the file, or put there, or values that are brought to
/// other units.
enum Fields {
    Read(Section),
    Write(Table),
    Scale,
}

impl Fields {
    /// A cause with its keys: read, it is there where the file has its table; written, the other
    /// way round.
    fn cause<P>(
        &mut self,
        name: &str,
        cause: &mut Option<P>,
        blank: P,
        keys: impl FnOnce(&mut Self, &mut P) -> Result<(), KeyError>,
    ) -> Result<(), KeyError> {
        match self {
            Self::Read(file) => {
                if let Some(section) = file.optional_section(name)? {
                    let mut fields = Self::Read(section);
                    keys(&mut fields, cause.insert(blank))?;
                    fields.finish()?;
                }
            }
            Self::Write(file) => {
                if let Some(cause) = cause {
                    let mut fields = Self::Write(Table::new());
                    keys(&mut fields, cause)?;
                    if let Self::Write(table) = fields {
                        file.insert(name.to_owned(), Value::Table(table));
                    }
                }
            }
            Self::Scale => {
                if let Some(cause) = cause {
                    keys(self, cause)?;
                }
            }
        }
        Ok(())
    }

    fn number(&mut self, key: &str, factor: f64, number: &mut f64) -> Result<(), KeyError> {
        match self {
            Self::Read(section) => *number = section.number(key)?,
            Self::Write(table) => put(table, key, *number),
            Self::Scale => *number *= factor,
        }
        Ok(())
    }

    /// A number that keeps its value where the file has none.
    fn optional_number(&mut self, key: &str, factor: f64, number: &mut f64) -> Result<(), KeyError> {
        match self {
            Self::Read(section) if !section.has(key) => Ok(()),
            _ => self.number(key, factor, number),
        }
    }

    /// Whether there is something to read at a key, to write, or to bring to other units.
    fn has(&self, key: &str, is_there: bool) -> bool {
        match self {
            Self::Read(section) => section.has(key),
            Self::Write(_) | Self::Scale => is_there,
        }
    }

    fn truth(&mut self, key: &str, truth: &mut bool) -> Result<(), KeyError> {
        match self {
            Self::Read(section) => *truth = section.truth(key)?,
            Self::Write(table) => put(table, key, *truth),
            Self::Scale => {}
        }
        Ok(())
    }

    /// A list of at most so many numbers.
    fn numbers<L: FromIterator<f64> + AsRef<[f64]> + AsMut<[f64]>>(
        &mut self,
        key: &str,
        factor: f64,
        most: usize,
        all: &mut L,
    ) -> Result<(), KeyError> {
        match self {
            Self::Read(section) => *all = numbers(section, key, most)?.into_iter().collect(),
            Self::Write(table) => put(table, key, list((*all).as_ref())),
            Self::Scale => all.as_mut().iter_mut().for_each(|number| *number *= factor),
        }
        Ok(())
    }

    fn profile(
        &mut self,
        (knots, of_knots): (&str, f64),
        (values, of_values): (&str, f64),
        profile: &mut ProfileParameters<f64>,
    ) -> Result<(), KeyError> {
        self.numbers(knots, of_knots, PROFILE_KNOTS, &mut profile.knots)?;
        self.numbers(values, of_values, PROFILE_KNOTS, &mut profile.values)
    }

    /// One of several by its name.
    fn choice<C: Copy + PartialEq>(
        &mut self,
        key: &str,
        choice: &mut C,
        known: &[(C, &str)],
    ) -> Result<(), KeyError> {
        match self {
            Self::Read(section) => {
                let name = section.text(key)?;
                let Some((found, _)) = known.iter().find(|(_, known)| *known == name) else {
                    let names: Vec<String> = known.iter().map(|(_, name)| format!("\"{name}\"")).collect();
                    let trouble = format!("\"{name}\" is not known, must be {}", names.join(" or "));
                    return Err(section.error(key, &trouble));
                };
                *choice = *found;
            }
            Self::Write(table) => {
                known
                    .iter()
                    .filter(|(known, _)| known == choice)
                    .for_each(|(_, name)| put(table, key, *name));
            }
            Self::Scale => {}
        }
        Ok(())
    }

    /// As [`choice`](Self::choice); what is usual need not stand in the file.
    fn optional_choice<C: Copy + PartialEq>(
        &mut self,
        key: &str,
        choice: &mut C,
        known: &[(C, &str)],
        usual: C,
    ) -> Result<(), KeyError> {
        match self {
            Self::Read(section) if !section.has(key) => *choice = usual,
            Self::Write(_) if *choice == usual => {}
            Self::Scale => {}
            _ => return self.choice(key, choice, known),
        }
        Ok(())
    }

    fn finish(self) -> Result<(), KeyError> {
        match self {
            Self::Read(section) => section.finish(),
            Self::Write(_) | Self::Scale => Ok(()),
        }
    }
}

/// An empty list.
fn empty<L: FromIterator<f64>>() -> L {
    std::iter::empty().collect()
}

fn put(table: &mut Table, key: &str, value: impl Into<Value>) {
    table.insert(key.to_owned(), value.into());
}
