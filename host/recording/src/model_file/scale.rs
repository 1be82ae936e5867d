//! What a change of units multiplies the numbers of a model by.

use model_core::agpi::AgpiParameters;
use model_core::egpi::EgpiParameters;
use model_core::envelope::EnvelopeParameters;

use super::names::Names;
use super::{HeldOut, Identification, ModelFile};
use crate::figures::Figures;
use crate::model::named::{Dimension, named};
use crate::model::{Density, HostParameters};
use crate::unit::Unit;

/// How many of the new units one of the old is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// Of the input.
    pub input: f64,
    /// Of the output.
    pub output: f64,
}

impl Scale {
    /// Nothing changes.
    pub const NONE: Self = Self { input: 1.0, output: 1.0 };

    /// From a model's units to bar and mm; None where the input is no pressure or the output no
    /// length.
    pub(super) fn to_board(names: Names) -> Option<Self> {
        Some(Self { input: bar(names.input)?, output: names.output.convert(1.0, Unit::MM)? })
    }

    /// That of a parameter.
    fn of(&self, dimension: Dimension) -> f64 {
        match dimension {
            Dimension::One => 1.0,
            Dimension::Input => self.input,
            Dimension::PerInput => self.input.recip(),
            Dimension::Output => self.output,
            Dimension::OutputPerInput => self.output / self.input,
        }
    }

    fn apply(&self, dimension: Dimension, numbers: &mut [f64]) {
        numbers.iter_mut().for_each(|number| *number *= self.of(dimension));
    }

    pub(super) fn parameters(&self, parameters: &mut HostParameters) {
        match parameters {
            HostParameters::Cascade(cascade) => {
                let (inner, of_inner) = if cascade.envelope == EnvelopeParameters::Identity {
                    (Dimension::Input, Dimension::OutputPerInput)
                } else {
                    (Dimension::One, Dimension::Output)
                };
                self.envelope(&mut cascade.envelope);
                self.apply(inner, &mut cascade.plays.thresholds);
                self.apply(inner, &mut cascade.dead_zones.thresholds);
                self.apply(of_inner, &mut cascade.dead_zones.weights);
                cascade.dead_zones.offset *= self.output;
                cascade.input_min *= self.input;
                cascade.input_max *= self.input;
            }
            HostParameters::Agpi(agpi) | HostParameters::Egpi(EgpiParameters { agpi, .. }) => {
                let AgpiParameters { rising, falling, gain, offset, input_min, input_max, .. } = agpi;
                self.envelope(rising);
                self.envelope(falling);
                [gain, offset].into_iter().for_each(|number| *number *= self.output);
                [input_min, input_max].into_iter().for_each(|number| *number *= self.input);
            }
        }
        if let HostParameters::Egpi(egpi) = parameters {
            self.apply(Dimension::Output, &mut egpi.memoryless.rises);
        }
    }

    fn envelope(&self, envelope: &mut EnvelopeParameters<f64>) {
        match envelope {
            EnvelopeParameters::Identity => {}
            EnvelopeParameters::Tanh(tanh) => tanh.c1 *= self.of(Dimension::PerInput),
            EnvelopeParameters::PiecewiseLinear(knots) => self.apply(Dimension::Input, &mut knots.inputs),
        }
    }

    pub(super) fn density(&self, density: Density, has_envelope: bool) -> Density {
        let inner = if has_envelope { 1.0 } else { self.input };
        match density {
            Density::Exponential { rho, tau, alpha } => {
                Density::Exponential { rho, tau: tau / inner, alpha: alpha * inner }
            }
            Density::Free { alpha } => Density::Free { alpha: alpha * inner },
        }
    }

    fn figures(&self, figures: Figures) -> Figures {
        let Figures { rmse, mae, max_error } = figures;
        Figures { rmse: rmse * self.output, mae: mae * self.output, max_error: max_error * self.output }
    }

    pub(super) fn identification(&self, file: &ModelFile, from: &Identification) -> Identification {
        let dimensions = named(&file.parameters, &file.density);
        let error = |(name, error): &(String, f64)| {
            let dimension = dimensions.iter().find(|named| named.name == *name).map(|named| named.dimension);
            (name.clone(), error * self.of(dimension.unwrap_or(Dimension::One)))
        };
        Identification {
            stroke: from.stroke * self.output,
            training: self.figures(from.training),
            heldout: from
                .heldout
                .clone()
                .map(|heldout| HeldOut { figures: self.figures(heldout.figures), ..heldout }),
            standard_errors: from.standard_errors.iter().map(error).collect(),
            ..from.clone()
        }
    }
}

/// One unit of an input that is a pressure. Unit: bar.
pub fn bar(unit: Unit) -> Option<f64> {
    unit.convert(1.0, Unit::BAR)
}
