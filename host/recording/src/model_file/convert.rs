//! A model in other units: the same model, its parameters multiplied by what their dimensions say.
//!
//! Weights of plays and shares have no dimension, thresholds of plays only where there is no
//! envelope. What is given at a rate of one unit a second is the same at another unit's rate once
//! the rate's power is taken along (see the extensions' table).
//!
//! # Limits
//! Only rates below 1e-9 units a second, which extensions count as none, are told apart by the
//! unit.

use model_core::ParameterError;
use model_core::envelope::EnvelopeParameters;

use super::scale::Scale;
use super::{ModelFile, extensions};
use crate::model::{HostModel, HostParameters};
use crate::unit::{Channel, Unit};

impl ModelFile {
    /// The model in the units of a board, bar and mm; None where the input is no pressure or the
    /// output no length.
    ///
    /// # Errors
    /// A parameter that leaves the range of numbers.
    pub fn for_board(&self) -> Option<Result<Self, ParameterError>> {
        Scale::to_board(self.names()).map(|scale| self.scaled(scale, [Unit::BAR, Unit::MM]))
    }

    fn scaled(&self, scale: Scale, [input, output]: [Unit; 2]) -> Result<Self, ParameterError> {
        if scale == Scale::NONE {
            return Ok(self.clone());
        }
        let mut parameters = self.parameters.clone();
        scale.parameters(&mut parameters);
        let has_envelope = !matches!(
            &parameters,
            HostParameters::Cascade(cascade) if cascade.envelope == EnvelopeParameters::Identity
        );
        Ok(Self {
            input: renamed(&self.input, input),
            output: renamed(&self.output, output),
            density: scale.density(self.density, has_envelope),
            model: HostModel::try_new(&parameters)?,
            parameters,
            extensions: extensions::scaled(&self.extensions, &self.names(), scale),
            identification: self.identification.as_ref().map(|from| scale.identification(self, from)),
            recorded: self.recorded.map(|recorded| recorded.scaled(scale)),
            tuning: self.tuning.as_ref().map(|tuning| tuning.scaled(scale)),
        })
    }
}

fn renamed(channel: &Channel, unit: Unit) -> Channel {
    Channel { name: format!("{}_{}", channel.stem(), unit.suffix()), unit }
}
