//! A model of each kind, made of the paper's parameters, in the sizes that comparisons of models
//! have. What a controller costs the board depends on kind and sizes, hardly on the parameters.

use model_core::agpi::AgpiParameters;
use model_core::dead_zone::DeadZoneParameters;
use model_core::egpi::EgpiParameters;
use model_core::envelope::{EnvelopeParameters, TanhParameters};
use model_core::memoryless::MemorylessParameters;
use model_core::play::PlayParameters;
use model_core::{Kind, ModelParameters, ParameterError, cpi, mgpi::MgpiParameters, mpi, paper, sgpi};
use wire::{BoardParameters, DEAD_ZONES, PLAYS};

use crate::{paper_parameters, piecewise_parameters};

/// The paper's number of plays and of dead zones.
const SIZE: usize = paper::SIZE;

type Model = ModelParameters<f32, PLAYS, DEAD_ZONES>;

/// Name, sizes and controller of each model: `mgpi 10/10`, `sgpi 10`.
///
/// # Errors
/// None in practice: the parameters are valid.
pub fn models() -> Result<Vec<(String, BoardParameters)>, ParameterError> {
    let paper = paper_parameters()?;
    let of = |model| BoardParameters { model, ..paper.clone() };
    let mut models = Vec::new();
    for kind in Kind::ALL {
        let zones = matches!(kind, Kind::Mpi | Kind::Mgpi).then_some(SIZE);
        let sizes = zones.map_or(String::new(), |zones| format!("/{zones}"));
        models.push((format!("{kind} {SIZE}{sizes}"), of(model(kind, SIZE, zones.unwrap_or(1))?)));
    }
    // The other sizes of the paper's Table 4.
    for (plays, zones) in [(20, SIZE), (SIZE, 14)] {
        models.push((format!("{} {plays}/{zones}", Kind::Mgpi), of(model(Kind::Mgpi, plays, zones)?)));
    }
    models.push(("mgpi-pl 10/10".to_owned(), piecewise_parameters()?));
    Ok(models)
}

/// The model with the paper's envelope, a density of the plays and slopes of the dead zones like
/// its.
fn model(kind: Kind, plays: usize, dead_zones: usize) -> Result<Model, ParameterError> {
    let [q, rho, tau, alpha] = paper::PLAYS.map(|number| number as f32);
    let TanhParameters { c0, c1, c2, c3 } = paper::ENVELOPE;
    let tanh = |shift: f64| {
        EnvelopeParameters::Tanh(TanhParameters {
            c0: c0 as f32,
            c1: c1 as f32,
            c2: (c2 + shift) as f32,
            c3: c3 as f32,
        })
    };
    let input = (0.0, paper::PRESSURE_MAX_BAR as f32);
    // The inner coordinate runs over about 2 under the envelope, over 6 bar without one.
    let scale = if matches!(kind, Kind::Cpi | Kind::Mpi) { 3.0 } else { 1.0 };
    let spacing = alpha * scale * 10.0 / plays as f32;
    let bank = PlayParameters::exponential(plays, q, rho * 10.0 / plays as f32, tau / scale, spacing)?;
    let zones = DeadZoneParameters {
        thresholds: (0..dead_zones).map(|j| j as f32 * 1.1 * scale / dead_zones as f32).collect(),
        weights: (0..dead_zones).map(|j| if j == 0 { 60.0 } else { 5.0 } / scale).collect(),
        offset: 0.0,
    };
    let asymmetric = |plays| AgpiParameters {
        rising: tanh(0.0),
        falling: tanh(0.02),
        plays,
        gain: 110.0,
        offset: 0.0,
        input_min: input.0,
        input_max: input.1,
        preconditioned: false,
    };
    Ok(match kind {
        Kind::Cpi => ModelParameters::Cascade(cpi::parameters(bank, 30.0, 0.0, input)?),
        Kind::Sgpi => ModelParameters::Cascade(sgpi::parameters(tanh(0.0), bank, 110.0, 0.0, input)?),
        Kind::Mpi => ModelParameters::Cascade(mpi::parameters(bank, zones, input)),
        Kind::Mgpi => ModelParameters::Cascade(MgpiParameters {
            envelope: tanh(0.0),
            plays: bank,
            dead_zones: zones,
            input_min: input.0,
            input_max: input.1,
            preconditioned: false,
        }),
        Kind::Agpi => ModelParameters::Agpi(asymmetric(bank)),
        Kind::Egpi => ModelParameters::Egpi(EgpiParameters {
            agpi: asymmetric(bank),
            memoryless: MemorylessParameters { rises: [3.0, 1.0, 2.0] },
        }),
    })
}
