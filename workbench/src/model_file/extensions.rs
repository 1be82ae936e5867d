//! The extensions of a model in its file: a table `[extensions.<cause>]` for each.
//!
//! Each cause's keys are written down once, for both directions: [`Fields`] either takes a value out of the file or puts it
//! there. A profile is two lists, its knots and the values there.

use model_core::ExtensionParameters;
use model_core::extension::creep::CREEP_ELEMENTS;
use model_core::extension::profile::PROFILE_KNOTS;
use model_core::extension::{
    CreepParameters, DeadbandForm, DriftParameters, PeriodicDisturbanceParameters, ProfileParameters,
    RateDependentWidthParameters, ScheduleParameters, SupplySaturationParameters, TransportDelayParameters,
    ValveDeadbandParameters, ValveLagParameters, WarmUpParameters,
};
use toml::{Table, Value};

use super::names::Names;
use super::parameters::numbers;
use super::section::{KeyError, Section};
use super::write::list;

const EXTENSIONS: &str = "extensions";
/// The forms of a valve's dead band.
const FORMS: [(DeadbandForm, &str); 2] = [(DeadbandForm::Hold, "hold"), (DeadbandForm::Backlash, "backlash")];

/// Takes the extensions out of the file's top level; a file without any has none.
pub fn read(top: &mut Section, names: &Names) -> Result<ExtensionParameters<f64>, KeyError> {
    let mut extensions = ExtensionParameters::default();
    if let Some(section) = top.optional_section(EXTENSIONS)? {
        let mut fields = Fields::Read(section);
        causes(&mut fields, names, &mut extensions)?;
        fields.finish()?;
    }
    Ok(extensions)
}

/// Puts the extensions into the file's top level; none leave nothing.
pub fn write(extensions: &ExtensionParameters<f64>, names: &Names, top: &mut Table) {
    let mut fields = Fields::Write(Table::new());
    // Writing has no errors.
    let _ = causes(&mut fields, names, &mut extensions.clone());
    if let Fields::Write(table) = fields
        && !table.is_empty()
    {
        top.insert(EXTENSIONS.to_owned(), Value::Table(table));
    }
}

/// Every cause with its keys.
fn causes(
    file: &mut Fields,
    names: &Names,
    extensions: &mut ExtensionParameters<f64>,
) -> Result<(), KeyError> {
    let (input, output) = (names.input.suffix(), names.output.suffix());
    let knots = format!("knots_{output}");
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
        creep,
        drift,
        periodic_disturbance,
    } = extensions;

    let blank = ValveDeadbandParameters { band: 0.0, form: DeadbandForm::Hold };
    file.cause("valve_deadband", valve_deadband, blank, |fields, deadband| {
        fields.number(&format!("band_{input}"), &mut deadband.band)?;
        fields.choice("form", &mut deadband.form, &FORMS)
    })?;
    let blank = SupplySaturationParameters { supply: 0.0 };
    file.cause("supply_saturation", supply_saturation, blank, |fields, saturation| {
        fields.number(&format!("supply_{input}"), &mut saturation.supply)
    })?;
    file.cause("valve_lag", valve_lag, ValveLagParameters::new(0.0), |fields, lag| {
        fields.number("time_constant_s", &mut lag.time_constant_s)?;
        fields.optional_number(&format!("lead_limit_{input}"), &mut lag.lead_limit)
    })?;
    let blank = TransportDelayParameters { delay_s: 0.0 };
    file.cause("transport_delay", transport_delay, blank, |fields, delay| {
        fields.number("delay_s", &mut delay.delay_s)
    })?;
    for (cause, reference, per, schedule) in
        [("load", "reference_n", "n", load), ("temperature", "reference_c", "k", temperature)]
    {
        let blank = ScheduleParameters { reference: 0.0, offset: profile() };
        file.cause(cause, schedule, blank, |fields, schedule| {
            fields.number(reference, &mut schedule.reference)?;
            fields.profile(&knots, &format!("offset_{input}_per_{per}"), &mut schedule.offset)
        })?;
    }
    let blank = WarmUpParameters { travel: 0.0, offset: profile() };
    file.cause("warm_up", warm_up, blank, |fields, warm_up| {
        fields.number(&format!("travel_{output}"), &mut warm_up.travel)?;
        fields.profile(&knots, &format!("offset_{input}"), &mut warm_up.offset)
    })?;
    file.cause("viscous_lag", viscous_lag, profile(), |fields, viscosity| {
        fields.profile(&knots, &format!("viscosity_{input}_s_per_{output}"), viscosity)
    })?;
    file.cause("inertia", inertia, profile(), |fields, inertia| {
        fields.profile(&knots, &format!("inertia_{input}_s2_per_{output}"), inertia)
    })?;
    let blank = RateDependentWidthParameters { radius: 0.0, exponent: 0.0, filter_s: 0.0, width: profile() };
    file.cause("rate_dependent_width", rate_dependent_width, blank, |fields, width| {
        fields.number(&format!("radius_{input}"), &mut width.radius)?;
        fields.number("exponent", &mut width.exponent)?;
        fields.number("filter_s", &mut width.filter_s)?;
        fields.profile(&knots, &format!("width_{input}"), &mut width.width)
    })?;
    let blank = CreepParameters { time_constants_s: empty(), fractions: empty() };
    file.cause("creep", creep, blank, |fields, creep| {
        fields.numbers("time_constants_s", CREEP_ELEMENTS, &mut creep.time_constants_s)?;
        fields.numbers("fractions", CREEP_ELEMENTS, &mut creep.fractions)
    })?;
    let blank = DriftParameters { rate_per_s: 0.0, compensated: false };
    file.cause("drift", drift, blank, |fields, drift| {
        fields.number(&format!("rate_{output}_per_s"), &mut drift.rate_per_s)?;
        fields.truth("compensated", &mut drift.compensated)
    })?;
    let blank = PeriodicDisturbanceParameters {
        amplitude: 0.0,
        frequency_hz: 0.0,
        phase_rad: 0.0,
        compensated: false,
    };
    file.cause("periodic_disturbance", periodic_disturbance, blank, |fields, tone| {
        fields.number(&format!("amplitude_{output}"), &mut tone.amplitude)?;
        fields.number("frequency_hz", &mut tone.frequency_hz)?;
        fields.number("phase_rad", &mut tone.phase_rad)?;
        fields.truth("compensated", &mut tone.compensated)
    })
}

/// A table whose values are taken out of the file, or put there.
enum Fields {
    Read(Section),
    Write(Table),
}

impl Fields {
    /// A cause with its keys: read, it is there where the file has its table; written, the other way round.
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
        }
        Ok(())
    }

    fn number(&mut self, key: &str, number: &mut f64) -> Result<(), KeyError> {
        match self {
            Self::Read(section) => *number = section.number(key)?,
            Self::Write(table) => put(table, key, *number),
        }
        Ok(())
    }

    /// A number that keeps its value where the file has none.
    fn optional_number(&mut self, key: &str, number: &mut f64) -> Result<(), KeyError> {
        match self {
            Self::Read(section) if !section.has(key) => Ok(()),
            _ => self.number(key, number),
        }
    }

    fn truth(&mut self, key: &str, truth: &mut bool) -> Result<(), KeyError> {
        match self {
            Self::Read(section) => *truth = section.truth(key)?,
            Self::Write(table) => put(table, key, *truth),
        }
        Ok(())
    }

    /// A list of at most so many numbers.
    fn numbers<L: FromIterator<f64> + AsRef<[f64]>>(
        &mut self,
        key: &str,
        most: usize,
        all: &mut L,
    ) -> Result<(), KeyError> {
        match self {
            Self::Read(section) => *all = numbers(section, key, most)?.into_iter().collect(),
            Self::Write(table) => put(table, key, list((*all).as_ref())),
        }
        Ok(())
    }

    fn profile(
        &mut self,
        knots: &str,
        values: &str,
        profile: &mut ProfileParameters<f64>,
    ) -> Result<(), KeyError> {
        self.numbers(knots, PROFILE_KNOTS, &mut profile.knots)?;
        self.numbers(values, PROFILE_KNOTS, &mut profile.values)
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
        }
        Ok(())
    }

    fn finish(self) -> Result<(), KeyError> {
        match self {
            Self::Read(section) => section.finish(),
            Self::Write(_) => Ok(()),
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
