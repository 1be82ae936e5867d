//! The raw parameters of a model by name, as they are reported and stand in model files.

use model_core::Kind;
use model_core::envelope::EnvelopeParameters;

use super::{Density, HostParameters};

/// What a parameter's unit is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    /// None.
    One,
    /// The input's.
    Input,
    /// One over the input's.
    PerInput,
    /// The output's.
    Output,
    /// The output's over the input's.
    OutputPerInput,
}

/// A raw parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Named {
    /// Its name.
    pub name: String,
    /// What its unit is made of.
    pub dimension: Dimension,
    /// Its value.
    pub value: f64,
}

/// The dimension of the slope of what follows the plays.
pub fn slope_dimension(kind: Kind) -> Dimension {
    match kind {
        Kind::Cpi | Kind::Mpi => Dimension::OutputPerInput,
        Kind::Sgpi | Kind::Agpi | Kind::Egpi | Kind::Mgpi => Dimension::Output,
    }
}

/// All raw parameters that an identification has found, in the order of the stages of the model.
pub fn named(parameters: &HostParameters, density: &Density) -> Vec<Named> {
    let mut list = List(Vec::new());
    let (plays, inner, of_u) = match parameters {
        HostParameters::Cascade(cascade) if cascade.envelope == EnvelopeParameters::Identity => {
            (&cascade.plays, Dimension::Input, Dimension::OutputPerInput)
        }
        HostParameters::Cascade(cascade) => {
            list.envelope(&cascade.envelope, "");
            (&cascade.plays, Dimension::One, Dimension::Output)
        }
        HostParameters::Agpi(agpi) => {
            list.two_envelopes(&agpi.rising, &agpi.falling);
            (&agpi.plays, Dimension::One, Dimension::Output)
        }
        HostParameters::Egpi(egpi) => {
            list.two_envelopes(&egpi.agpi.rising, &egpi.agpi.falling);
            (&egpi.agpi.plays, Dimension::One, Dimension::Output)
        }
    };
    let per_inner = if inner == Dimension::Input { Dimension::PerInput } else { Dimension::One };
    list.push("q", Dimension::One, plays.q);
    match density {
        Density::Exponential { rho, tau, alpha } => {
            list.push("rho", Dimension::One, *rho);
            list.push("tau", per_inner, *tau);
            list.push("alpha", inner, *alpha);
        }
        Density::Free { alpha } => {
            list.push("alpha", inner, *alpha);
            for (i, weight) in plays.weights.iter().enumerate() {
                list.push(&format!("p{}", i + 1), Dimension::One, *weight);
            }
        }
    }
    match parameters {
        HostParameters::Cascade(cascade) => {
            match cascade.dead_zones.weights.as_slice() {
                [gain] => list.push("gain", of_u, *gain),
                weights => {
                    for (j, weight) in weights.iter().enumerate() {
                        list.push(&format!("w{j}"), of_u, *weight);
                    }
                }
            }
            list.push("offset", Dimension::Output, cascade.dead_zones.offset);
        }
        HostParameters::Agpi(agpi) => list.line(agpi.gain, agpi.offset),
        HostParameters::Egpi(egpi) => {
            list.line(egpi.agpi.gain, egpi.agpi.offset);
            for (k, rise) in egpi.memoryless.rises.iter().enumerate() {
                list.push(&format!("rise{}", k + 1), Dimension::Output, *rise);
            }
        }
    }
    list.0
}

struct List(Vec<Named>);

impl List {
    fn push(&mut self, name: &str, dimension: Dimension, value: f64) {
        self.0.push(Named { name: name.to_owned(), dimension, value });
    }

    fn line(&mut self, gain: f64, offset: f64) {
        self.push("gain", Dimension::Output, gain);
        self.push("offset", Dimension::Output, offset);
    }

    fn two_envelopes(&mut self, rising: &EnvelopeParameters<f64>, falling: &EnvelopeParameters<f64>) {
        self.envelope(rising, "_rising");
        self.envelope(falling, "_falling");
    }

    fn envelope(&mut self, envelope: &EnvelopeParameters<f64>, which: &str) {
        match envelope {
            EnvelopeParameters::Identity => {}
            EnvelopeParameters::Tanh(tanh) => {
                self.push(&format!("c0{which}"), Dimension::One, tanh.c0);
                self.push(&format!("c1{which}"), Dimension::PerInput, tanh.c1);
                self.push(&format!("c2{which}"), Dimension::One, tanh.c2);
                self.push(&format!("c3{which}"), Dimension::One, tanh.c3);
            }
            EnvelopeParameters::PiecewiseLinear(knots) => {
                for (k, value) in knots.values.iter().enumerate() {
                    self.push(&format!("knot{k}{which}"), Dimension::One, *value);
                }
            }
        }
    }
}
