//! The parts of an identified model as plots: envelopes, weights of the plays, what follows them.

use model_core::dead_zone::{DeadZoneParameters, DeadZones};
use model_core::envelope::{AnyEnvelope, Envelope, EnvelopeParameters};
use model_core::memoryless::{Memoryless, MemorylessParameters};
use model_core::play::PlayParameters;
use model_core::{ParameterError, Range};

use super::plot::{Line, Plot, Style};
use identification::{DEAD_ZONES, HostParameters, PLAYS};
use recording::model_file::ModelFile;

/// Samples of a curve.
const SAMPLES: u32 = 400;

/// A part of a model.
pub struct Part {
    title: &'static str,
    x: String,
    y: String,
    lines: Vec<Curve>,
    /// What it means.
    pub words: &'static str,
}

struct Curve {
    name: &'static str,
    style: Style,
    x: Vec<f64>,
    y: Vec<f64>,
}

impl Part {
    /// The part as a plot.
    pub fn plot(&self) -> Plot<'_> {
        Plot {
            title: self.title.to_owned(),
            x: self.x.clone(),
            y: self.y.clone(),
            lines: self
                .lines
                .iter()
                .map(|Curve { name, style, x, y }| Line { name, style: *style, x, y })
                .collect(),
            ..Plot::default()
        }
    }
}

/// The parts of a model that have a shape; straight lines are left out.
///
/// # Errors
/// The parameters are not those of a model.
pub fn parts(model: &ModelFile) -> Result<Vec<Part>, ParameterError> {
    let (low, high) = model.parameters.input();
    let inputs = samples(low, high);
    Ok(match &model.parameters {
        HostParameters::Cascade(cascade) => {
            let is_bent = cascade.dead_zones.weights.len() > 1;
            let ends = [low, high].map(|input| value(&cascade.envelope, input));
            let ends = [ends[0]?, ends[1]?].map(|v| loading(&cascade.plays, v));
            [
                envelopes(model, &inputs, &[("", &cascade.envelope)])?,
                Some(weights(model, &cascade.plays, &cascade.envelope)),
                if is_bent { Some(dead_zones(model, &cascade.dead_zones, ends)?) } else { None },
            ]
            .into_iter()
            .flatten()
            .collect()
        }
        HostParameters::Agpi(agpi) => {
            let pair = [("rising", &agpi.rising), ("falling", &agpi.falling)];
            let weights = weights(model, &agpi.plays, &agpi.rising);
            envelopes(model, &inputs, &pair)?.into_iter().chain([weights]).collect()
        }
        HostParameters::Egpi(egpi) => {
            let pair = [("rising", &egpi.agpi.rising), ("falling", &egpi.agpi.falling)];
            let weights = weights(model, &egpi.agpi.plays, &egpi.agpi.rising);
            let added = added(model, &egpi.memoryless, inputs.clone())?;
            envelopes(model, &inputs, &pair)?.into_iter().chain([weights, added]).collect()
        }
    })
}

fn samples(low: f64, high: f64) -> Vec<f64> {
    (0..=SAMPLES).map(|k| low + (high - low) * f64::from(k) / f64::from(SAMPLES)).collect()
}

fn value(envelope: &EnvelopeParameters<f64>, input: f64) -> Result<f64, ParameterError> {
    Ok(AnyEnvelope::try_new(envelope)?.value(input))
}

/// The envelopes over the input; None where the plays act on the input itself.
fn envelopes(
    model: &ModelFile,
    inputs: &[f64],
    envelopes: &[(&'static str, &EnvelopeParameters<f64>)],
) -> Result<Option<Part>, ParameterError> {
    let mut lines = Vec::new();
    for ((name, parameters), style) in envelopes.iter().zip([Style::Measured, Style::Model]) {
        if **parameters == EnvelopeParameters::Identity {
            return Ok(None);
        }
        let envelope = AnyEnvelope::try_new(parameters)?;
        let y = inputs.iter().map(|&input| envelope.value(input)).collect();
        lines.push(Curve { name, style, x: inputs.to_vec(), y });
    }
    Ok(Some(Part {
        title: if lines.len() > 1 { "Envelopes of the plays" } else { "Envelope of the plays" },
        x: model.input.to_string(),
        y: "inner coordinate (1)".to_owned(),
        lines,
        words: "How the input is bent before the plays see it. Where the curve is flat, the muscle hardly answers, and \
                the inverse has to move the input far.",
    }))
}

/// A stroke from 0 for each weight, that of the direct term at threshold 0.
fn weights(
    model: &ModelFile,
    plays: &PlayParameters<f64, PLAYS>,
    envelope: &EnvelopeParameters<f64>,
) -> Part {
    let all = || {
        std::iter::once((0.0, plays.q))
            .chain(plays.thresholds.iter().copied().zip(plays.weights.iter().copied()))
    };
    let unit =
        if *envelope == EnvelopeParameters::Identity { model.input.unit.to_string() } else { "1".to_owned() };
    Part {
        title: "Weights of the plays",
        x: format!("threshold ({unit})"),
        y: "weight (1)".to_owned(),
        lines: vec![Curve {
            name: "",
            style: Style::Measured,
            x: all().flat_map(|(threshold, _)| [threshold; 3]).collect(),
            y: all().flat_map(|(_, weight)| [0.0, weight, f64::NAN]).collect(),
        }],
        words: "The stroke at threshold 0 is the direct term, which has no hysteresis. The more weight lies to the right, \
                the wider the loop, and the longer the way after a reversal until the muscle follows in full.",
    }
}

/// The plays' output u after a first loading from 0 to `v`.
fn loading(plays: &PlayParameters<f64, PLAYS>, v: f64) -> f64 {
    let play = |(r, p): (&f64, &f64)| p * v.signum() * (v.abs() - r).max(0.0);
    plays.q * v + plays.thresholds.iter().zip(&plays.weights).map(play).sum::<f64>()
}

fn dead_zones(
    model: &ModelFile,
    parameters: &DeadZoneParameters<f64, DEAD_ZONES>,
    [low, high]: [f64; 2],
) -> Result<Part, ParameterError> {
    let stage = DeadZones::try_new(parameters)?;
    let x = samples(low, high);
    let y = x.iter().map(|&u| stage.value(u)).collect();
    Ok(Part {
        title: "Dead-zone map",
        x: "output of the plays (1)".to_owned(),
        y: model.output.to_string(),
        lines: vec![Curve { name: "", style: Style::Measured, x, y }],
        words: "How the output of the plays becomes that of the model: a straight line would leave the loop as symmetric \
                as the plays make it, a bent one makes it lopsided. It always rises; were it flat anywhere, there would be no inverse.",
    })
}

fn added(
    model: &ModelFile,
    parameters: &MemorylessParameters<f64>,
    x: Vec<f64>,
) -> Result<Part, ParameterError> {
    let (low, high) = model.parameters.input();
    let range = Range::try_new(low, high, "input range", "input unit")?;
    let function = Memoryless::try_new(parameters, &range)?;
    let y = x.iter().map(|&input| function.value(input)).collect();
    Ok(Part {
        title: "Added function of the input",
        x: model.input.to_string(),
        y: model.output.to_string(),
        lines: vec![Curve { name: "", style: Style::Measured, x, y }],
        words: "What the input adds to the output of the plays without any hysteresis.",
    })
}
