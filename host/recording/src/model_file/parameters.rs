//! The stages of a model in its file, both directions.
//!
//! | model | sections |
//! |---|---|
//! | cpi | plays, line |
//! | sgpi | envelope, plays, line |
//! | mpi | plays, dead_zones |
//! | mgpi | envelope, plays, dead_zones |
//! | agpi | envelope.rising, envelope.falling, plays, line |
//! | egpi | as agpi, and memoryless |

use model_core::Kind;
use model_core::agpi::AgpiParameters;
use model_core::cascade::CascadeParameters;
use model_core::dead_zone::DeadZoneParameters;
use model_core::egpi::EgpiParameters;
use model_core::envelope::{EnvelopeParameters, KNOTS, PiecewiseLinearParameters, TanhParameters};
use model_core::memoryless::{DEGREE, MemorylessParameters};
use model_core::play::PlayParameters;
use toml::{Table, Value};

use super::Problem;
use super::names::Names;
use super::section::{KeyError, Section};
use super::values::{count, list, table};
use crate::model::named::Dimension;
use crate::model::{DEAD_ZONES, Density, HostParameters, PLAYS};

const TANH: &str = "tanh";
const PIECEWISE_LINEAR: &str = "piecewise_linear";
const EXPONENTIAL: &str = "exponential";
const FREE: &str = "free";
/// Thresholds and weights themselves: all that a board knows.
const LISTED: &str = "listed";

/// The dimensions of the inner coordinate: those of the input, where there is no envelope.
struct Inner {
    threshold: Dimension,
    reciprocal: Dimension,
    weight: Dimension,
}

const WITH_ENVELOPE: Inner =
    Inner { threshold: Dimension::One, reciprocal: Dimension::One, weight: Dimension::Output };
const WITHOUT_ENVELOPE: Inner =
    Inner { threshold: Dimension::Input, reciprocal: Dimension::PerInput, weight: Dimension::OutputPerInput };

/// Takes the stages of a model out of the file's top level; a board's plays come from no density.
pub fn read(
    kind: Kind,
    top: &mut Section,
    names: &Names,
    input: (f64, f64),
) -> Result<(HostParameters, Option<Density>), Problem> {
    let mut reader = Reader { top, names };
    Ok(match kind {
        Kind::Cpi | Kind::Mpi => {
            let (plays, density) = reader.plays(&WITHOUT_ENVELOPE)?;
            let stage = reader.stage(kind == Kind::Mpi, &WITHOUT_ENVELOPE)?;
            (cascade(EnvelopeParameters::Identity, plays, stage, input), density)
        }
        Kind::Sgpi | Kind::Mgpi => {
            let section = reader.top.section("envelope")?;
            let envelope = reader.envelope(section)?;
            let (plays, density) = reader.plays(&WITH_ENVELOPE)?;
            let stage = reader.stage(kind == Kind::Mgpi, &WITH_ENVELOPE)?;
            (cascade(envelope, plays, stage, input), density)
        }
        Kind::Agpi => {
            let (agpi, density) = reader.agpi(input)?;
            (HostParameters::Agpi(agpi), density)
        }
        Kind::Egpi => {
            let (agpi, density) = reader.agpi(input)?;
            let memoryless = reader.memoryless()?;
            (HostParameters::Egpi(EgpiParameters { agpi, memoryless }), density)
        }
    })
}

fn cascade(
    envelope: EnvelopeParameters<f64>,
    plays: PlayParameters<f64, PLAYS>,
    dead_zones: DeadZoneParameters<f64, DEAD_ZONES>,
    (input_min, input_max): (f64, f64),
) -> HostParameters {
    HostParameters::Cascade(CascadeParameters {
        envelope,
        plays,
        dead_zones,
        input_min,
        input_max,
        preconditioned: false,
    })
}

struct Reader<'a> {
    top: &'a mut Section,
    names: &'a Names,
}

impl Reader<'_> {
    fn agpi(&mut self, input: (f64, f64)) -> Result<(AgpiParameters<f64, PLAYS>, Option<Density>), Problem> {
        let mut both = self.top.section("envelope")?;
        let (rising, falling) = (both.section("rising")?, both.section("falling")?);
        both.finish()?;
        let (rising, falling) = (self.envelope(rising)?, self.envelope(falling)?);
        let (plays, density) = self.plays(&WITH_ENVELOPE)?;
        let (gain, offset) = self.line(&WITH_ENVELOPE)?;
        let (input_min, input_max) = input;
        Ok((
            AgpiParameters {
                rising,
                falling,
                plays,
                gain,
                offset,
                input_min,
                input_max,
                preconditioned: false,
            },
            density,
        ))
    }

    fn envelope(&self, mut section: Section) -> Result<EnvelopeParameters<f64>, KeyError> {
        let kind = section.text("kind")?;
        let envelope = match kind.as_str() {
            TANH => EnvelopeParameters::Tanh(TanhParameters {
                c0: section.number("c0")?,
                c1: section.number(&self.names.key("c1", Dimension::PerInput))?,
                c2: section.number("c2")?,
                c3: section.number("c3")?,
            }),
            PIECEWISE_LINEAR => {
                let inputs = self.names.key("knots", Dimension::Input);
                EnvelopeParameters::PiecewiseLinear(PiecewiseLinearParameters {
                    inputs: numbers(&mut section, &inputs, KNOTS)?.into_iter().collect(),
                    values: numbers(&mut section, "values", KNOTS)?.into_iter().collect(),
                })
            }
            _ => {
                let known = format!("\"{kind}\" is not known, must be \"{TANH}\" or \"{PIECEWISE_LINEAR}\"");
                return Err(section.error("kind", &known));
            }
        };
        section.finish()?;
        Ok(envelope)
    }

    fn plays(&mut self, inner: &Inner) -> Result<(PlayParameters<f64, PLAYS>, Option<Density>), Problem> {
        let mut section = self.top.section("plays")?;
        let kind = section.text("density")?;
        let q = section.number("q")?;
        let (plays, density) = match kind.as_str() {
            EXPONENTIAL => {
                let count = section.count("count")?;
                let rho = section.number("rho")?;
                let tau = section.number(&self.names.key("tau", inner.reciprocal))?;
                let alpha = section.number(&self.names.key("alpha", inner.threshold))?;
                let plays = PlayParameters::exponential(count, q, rho, tau, alpha);
                let density = Density::Exponential { rho, tau, alpha };
                (plays.map_err(|error| self.names.problem(&error))?, Some(density))
            }
            FREE => {
                let alpha = section.number(&self.names.key("alpha", inner.threshold))?;
                let weights = numbers(&mut section, "weights", PLAYS)?;
                let thresholds = (1..=weights.len()).map(|i| alpha * i as f64).collect();
                let plays = PlayParameters { q, thresholds, weights: weights.into_iter().collect() };
                (plays, Some(Density::Free { alpha }))
            }
            LISTED => {
                let key = self.names.key("thresholds", inner.threshold);
                let thresholds = numbers(&mut section, &key, PLAYS)?.into_iter().collect();
                let weights = numbers(&mut section, "weights", PLAYS)?.into_iter().collect();
                (PlayParameters { q, thresholds, weights }, None)
            }
            _ => {
                let known = format!("\"{kind}\" is not known, must be \"{EXPONENTIAL}\" or \"{FREE}\"");
                return Err(section.error("density", &known).into());
            }
        };
        section.finish()?;
        Ok((plays, density))
    }

    /// The stage behind the plays: dead zones, or the straight line of a single one.
    fn stage(
        &mut self,
        has_dead_zones: bool,
        inner: &Inner,
    ) -> Result<DeadZoneParameters<f64, DEAD_ZONES>, Problem> {
        if !has_dead_zones {
            let (gain, offset) = self.line(inner)?;
            return DeadZoneParameters::line(gain, offset).map_err(|error| self.names.problem(&error));
        }
        let mut section = self.top.section("dead_zones")?;
        let (thresholds, weights) =
            (self.names.key("thresholds", inner.threshold), self.names.key("weights", inner.weight));
        let dead_zones = DeadZoneParameters {
            thresholds: numbers(&mut section, &thresholds, DEAD_ZONES)?.into_iter().collect(),
            weights: numbers(&mut section, &weights, DEAD_ZONES)?.into_iter().collect(),
            offset: section.number(&self.names.key("offset", Dimension::Output))?,
        };
        section.finish()?;
        Ok(dead_zones)
    }

    fn line(&mut self, inner: &Inner) -> Result<(f64, f64), KeyError> {
        let mut section = self.top.section("line")?;
        let gain = section.number(&self.names.key("gain", inner.weight))?;
        let offset = section.number(&self.names.key("offset", Dimension::Output))?;
        section.finish()?;
        Ok((gain, offset))
    }

    fn memoryless(&mut self) -> Result<MemorylessParameters<f64>, KeyError> {
        let mut section = self.top.section("memoryless")?;
        let key = self.names.key("rises", Dimension::Output);
        let rises = section.numbers(&key)?;
        let rises = rises.try_into().map_err(|list: Vec<f64>| {
            section.error(&key, &format!("{} numbers, must be {DEGREE}", list.len()))
        })?;
        section.finish()?;
        Ok(MemorylessParameters { rises })
    }
}

/// At most as many numbers as a list of the model holds.
pub fn numbers(section: &mut Section, key: &str, most: usize) -> Result<Vec<f64>, KeyError> {
    let numbers = section.numbers(key)?;
    if numbers.len() > most {
        return Err(section.error(key, &format!("{} numbers, must be at most {most}", numbers.len())));
    }
    Ok(numbers)
}

/// Puts the stages of a model into the file's top level; the plays as they are, where they come
/// from no density.
pub fn write(parameters: &HostParameters, density: Option<&Density>, names: &Names, top: &mut Table) {
    let stage = |cascade: &CascadeParameters<f64, PLAYS, DEAD_ZONES>, inner: &Inner| {
        let CascadeParameters { dead_zones, .. } = cascade;
        match dead_zones.weights.as_slice() {
            [gain] => ("line", line(names, inner, *gain, dead_zones.offset)),
            weights => {
                let stage = table([
                    (&names.key("thresholds", inner.threshold), list(&dead_zones.thresholds)),
                    (&names.key("weights", inner.weight), list(weights)),
                    (&names.key("offset", Dimension::Output), dead_zones.offset.into()),
                ]);
                ("dead_zones", stage)
            }
        }
    };
    let mut insert = |(key, value): (&str, Value)| {
        top.insert(key.to_owned(), value);
    };
    match parameters {
        HostParameters::Cascade(cascade) if cascade.envelope == EnvelopeParameters::Identity => {
            insert(("plays", plays(names, density, &cascade.plays, &WITHOUT_ENVELOPE)));
            insert(stage(cascade, &WITHOUT_ENVELOPE));
        }
        HostParameters::Cascade(cascade) => {
            insert(("envelope", envelope(names, &cascade.envelope)));
            insert(("plays", plays(names, density, &cascade.plays, &WITH_ENVELOPE)));
            insert(stage(cascade, &WITH_ENVELOPE));
        }
        HostParameters::Agpi(agpi) => two_envelopes(names, density, agpi).into_iter().for_each(insert),
        HostParameters::Egpi(egpi) => {
            two_envelopes(names, density, &egpi.agpi).into_iter().for_each(&mut insert);
            let rises = list(&egpi.memoryless.rises);
            insert(("memoryless", table([(&names.key("rises", Dimension::Output), rises)])));
        }
    }
}

fn two_envelopes(
    names: &Names,
    density: Option<&Density>,
    agpi: &AgpiParameters<f64, PLAYS>,
) -> [(&'static str, Value); 3] {
    let both = [("rising", envelope(names, &agpi.rising)), ("falling", envelope(names, &agpi.falling))];
    [
        ("envelope", table(both)),
        ("plays", plays(names, density, &agpi.plays, &WITH_ENVELOPE)),
        ("line", line(names, &WITH_ENVELOPE, agpi.gain, agpi.offset)),
    ]
}

fn envelope(names: &Names, envelope: &EnvelopeParameters<f64>) -> Value {
    match envelope {
        EnvelopeParameters::Identity => table([]),
        EnvelopeParameters::Tanh(TanhParameters { c0, c1, c2, c3 }) => table([
            ("kind", TANH.into()),
            ("c0", (*c0).into()),
            (&names.key("c1", Dimension::PerInput), (*c1).into()),
            ("c2", (*c2).into()),
            ("c3", (*c3).into()),
        ]),
        EnvelopeParameters::PiecewiseLinear(PiecewiseLinearParameters { inputs, values }) => table([
            ("kind", PIECEWISE_LINEAR.into()),
            (&names.key("knots", Dimension::Input), list(inputs)),
            ("values", list(values)),
        ]),
    }
}

fn plays(
    names: &Names,
    density: Option<&Density>,
    plays: &PlayParameters<f64, PLAYS>,
    inner: &Inner,
) -> Value {
    let alpha_key = names.key("alpha", inner.threshold);
    match density.copied() {
        Some(Density::Exponential { rho, tau, alpha }) => table([
            ("density", EXPONENTIAL.into()),
            ("count", count(plays.thresholds.len())),
            ("q", plays.q.into()),
            ("rho", rho.into()),
            (&names.key("tau", inner.reciprocal), tau.into()),
            (&alpha_key, alpha.into()),
        ]),
        Some(Density::Free { alpha }) => table([
            ("density", FREE.into()),
            ("q", plays.q.into()),
            (&alpha_key, alpha.into()),
            ("weights", list(&plays.weights)),
        ]),
        None => table([
            ("density", LISTED.into()),
            ("q", plays.q.into()),
            (&names.key("thresholds", inner.threshold), list(&plays.thresholds)),
            ("weights", list(&plays.weights)),
        ]),
    }
}

fn line(names: &Names, inner: &Inner, gain: f64, offset: f64) -> Value {
    table([
        (&names.key("gain", inner.weight), gain.into()),
        (&names.key("offset", Dimension::Output), offset.into()),
    ])
}
