//! What is hidden in a plant, for tests and for a file that is opened after the verdict.

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::{Map, Value, json};

use crate::effect::Effect;
use crate::effects::Effects;
use crate::sensitivity::Sensitivities;

/// The hidden effects with their parameters, under the names a diagnosis reports them by.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Truth {
    /// Parameters of each cause, by the cause's name.
    pub causes: BTreeMap<&'static str, Map<String, Value>>,
    /// Strength of each effect that is no cause, by its name.
    pub outsiders: BTreeMap<&'static str, f64>,
}

impl Truth {
    pub(crate) fn new(effects: &Effects, sensitivities: &Sensitivities) -> Self {
        let drawn = json!(effects);
        let mut causes: BTreeMap<_, _> = Effect::causes()
            .iter()
            .filter_map(|cause| Some((cause.name(), drawn.get(cause.name())?.as_object()?.clone())))
            .collect();
        let of_load = [("offset_mm_per_n", "gain_per_n", Effect::Load, Some(sensitivities.per_n))];
        let of_temperature = [("offset_mm_per_k", "gain_per_k", Effect::Temperature, sensitivities.per_k)];
        for (offset, gain, cause, sensitivity) in of_load.into_iter().chain(of_temperature) {
            if let (Some(parameters), Some(sensitivity)) = (causes.get_mut(cause.name()), sensitivity) {
                parameters.insert(offset.to_owned(), json!(sensitivity.offset_mm));
                parameters.insert(gain.to_owned(), json!(sensitivity.gain));
            }
        }
        // Drawn is the share of what the plant is made of, a stiffness or a stroke.
        if let (Some(parameters), Some(lacking)) =
            (causes.get_mut(Effect::WarmUp.name()), sensitivities.lacking)
        {
            parameters.insert("fraction".to_owned(), json!(lacking));
        }
        let outsiders =
            effects.outsiders.iter().map(|outsider| (outsider.effect.name(), outsider.strength)).collect();
        Self { causes, outsiders }
    }
}
