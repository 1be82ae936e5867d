//! Random models of the family and random histories, for the tests of their properties.
//!
//! A further member of the family is a function that makes its random parameters, and a line in
//! [`family`].
#![allow(dead_code, reason = "each file of tests uses a part of it")]

use model_core::agpi::AgpiParameters;
use model_core::dead_zone::DeadZoneParameters;
use model_core::egpi::EgpiParameters;
use model_core::envelope::{EnvelopeParameters, PiecewiseLinearParameters, TanhParameters};
use model_core::memoryless::MemorylessParameters;
use model_core::mgpi::MgpiParameters;
use model_core::play::PlayParameters;
use model_core::{Hysteresis, HysteresisState, List, Model, ModelParameters, Range, Real, cpi, mpi, sgpi};
use proptest::prelude::*;

/// Capacity of plays and dead zones.
pub const SIZE: usize = 12;
pub type Parameters = ModelParameters<f64, SIZE, SIZE>;
pub type State<T> = HysteresisState<T, SIZE>;
/// The input range of the models with an envelope.
const RANGE: (f64, f64) = (0.0, 6.0);

pub fn list<const L: usize>(values: impl IntoIterator<Item = f64>) -> List<f64, L> {
    values.into_iter().collect()
}

/// Plays with increasing thresholds and positive partial sums; single weights may be negative.
pub fn plays() -> impl Strategy<Value = PlayParameters<f64, SIZE>> {
    (0.1..2.0, prop::collection::vec((0.02..0.3, 0.3..2.0), 0..SIZE)).prop_map(|(q, steps)| {
        let (mut threshold, mut slope) = (0.0, q);
        let (mut thresholds, mut weights) = (vec![], vec![]);
        for (step, factor) in steps {
            threshold += step;
            thresholds.push(threshold);
            weights.push(slope * factor - slope);
            slope *= factor;
        }
        PlayParameters { q, thresholds: list(thresholds), weights: list(weights) }
    })
}

/// One side's knots, from 0 outward: distances and slopes.
fn side(most: usize) -> impl Strategy<Value = Vec<(f64, f64)>> {
    prop::collection::vec((0.05..0.3, 5.0..100.0), 0..most)
}

/// Thresholds and weights of a side, outward from the slope at 0.
fn zones(central: f64, side: &[(f64, f64)], sign: f64) -> Vec<(f64, f64)> {
    let (mut threshold, mut slope) = (0.0, central);
    let mut zone = |&(step, next): &(f64, f64)| {
        threshold += sign * step;
        let weight = next - slope;
        slope = next;
        (threshold, weight)
    };
    side.iter().map(&mut zone).collect()
}

/// Dead zones on both sides of 0, at most `negative` of them below it; all partial sums are
/// positive.
fn dead_zones_with(negative: usize) -> impl Strategy<Value = DeadZoneParameters<f64, SIZE>> {
    (5.0..100.0, side(negative + 1), side(SIZE - negative), -20.0..20.0).prop_map(
        |(central, below, above, offset)| {
            let mut all = zones(central, &below, -1.0);
            all.reverse();
            all.push((0.0, central));
            all.extend(zones(central, &above, 1.0));
            let (thresholds, weights): (Vec<f64>, Vec<f64>) = all.into_iter().unzip();
            DeadZoneParameters { thresholds: list(thresholds), weights: list(weights), offset }
        },
    )
}

/// Dead zones as in the paper, from 0 on.
pub fn dead_zones() -> impl Strategy<Value = DeadZoneParameters<f64, SIZE>> {
    dead_zones_with(0)
}

fn tanh() -> impl Strategy<Value = TanhParameters<f64>> {
    (0.5..2.0, 0.1..0.5, -1.0..1.0, -0.5..0.5).prop_map(|(c0, c1, c2, c3)| TanhParameters { c0, c1, c2, c3 })
}

fn envelope() -> impl Strategy<Value = EnvelopeParameters<f64>> {
    let knots = prop::collection::vec((0.2..2.0, 0.05..0.5), 2..8).prop_map(|steps| {
        let sums = |part: fn(&(f64, f64)) -> f64| {
            steps.iter().scan(-0.5, move |sum, step| {
                *sum += part(step);
                Some(*sum)
            })
        };
        EnvelopeParameters::PiecewiseLinear(PiecewiseLinearParameters {
            inputs: sums(|step| step.0).collect(),
            values: sums(|step| step.1).collect(),
        })
    });
    prop_oneof![tanh().prop_map(EnvelopeParameters::Tanh), knots]
}

pub fn cpi() -> impl Strategy<Value = Parameters> {
    (plays(), 5.0..100.0, -20.0..20.0).prop_map(|(plays, gain, offset)| {
        ModelParameters::Cascade(cpi::parameters(plays, gain, offset, (-2.0, 5.0)).expect("fits"))
    })
}

pub fn sgpi() -> impl Strategy<Value = Parameters> {
    (envelope(), plays(), 5.0..100.0, -20.0..20.0).prop_map(|(envelope, plays, gain, offset)| {
        ModelParameters::Cascade(sgpi::parameters(envelope, plays, gain, offset, RANGE).expect("fits"))
    })
}

pub fn mpi() -> impl Strategy<Value = Parameters> {
    (plays(), dead_zones_with(5))
        .prop_map(|(plays, zones)| ModelParameters::Cascade(mpi::parameters(plays, zones, (-3.0, 3.0))))
}

pub fn mgpi() -> impl Strategy<Value = Parameters> {
    (envelope(), plays(), dead_zones()).prop_map(|(envelope, plays, dead_zones)| {
        let (input_min, input_max) = RANGE;
        ModelParameters::Cascade(MgpiParameters {
            envelope,
            plays,
            dead_zones,
            input_min,
            input_max,
            preconditioned: false,
        })
    })
}

/// The falling envelope is the rising one, shifted to the left and up, so little that most of the
/// way is common.
fn two_envelopes() -> impl Strategy<Value = AgpiParameters<f64, SIZE>> {
    (tanh(), 0.0..0.1, 0.0..0.1, plays(), 5.0..100.0, -20.0..20.0).prop_map(
        |(curve, left, up, plays, gain, offset)| {
            let TanhParameters { c0, c1, c2, c3 } = curve;
            let height = c0 * ((c1 * RANGE.1 + c2).tanh() - (c1 * RANGE.0 + c2).tanh());
            let falling = TanhParameters { c2: c2 + left, c3: c3 + up * height, ..curve };
            AgpiParameters {
                rising: EnvelopeParameters::Tanh(curve),
                falling: EnvelopeParameters::Tanh(falling),
                plays,
                gain,
                offset,
                input_min: RANGE.0,
                input_max: RANGE.1,
                preconditioned: false,
            }
        },
    )
}

pub fn agpi() -> impl Strategy<Value = Parameters> {
    two_envelopes().prop_map(ModelParameters::Agpi)
}

/// With memoryless functions for which the fixed point of the inverse is near enough.
pub fn egpi() -> impl Strategy<Value = Parameters> {
    let share = -0.1..0.5;
    let rises = [share.clone(), share.clone(), share];
    (two_envelopes(), rises).prop_map(|(agpi, shares)| {
        // Shares of the least rise that the hysteretic part has over the whole range.
        let EnvelopeParameters::Tanh(TanhParameters { c0, c1, c2, .. }) = agpi.rising else { unreachable!() };
        let flattest = |x: f64| c0 * c1 / (c1 * x + c2).abs().max((c1 * x + c2 + 0.1).abs()).cosh().powi(2);
        let slope = agpi.plays.weights.iter().scan(agpi.plays.q, |sum, weight| {
            *sum += weight;
            Some(*sum)
        });
        let least = slope.fold(agpi.plays.q, f64::min) * flattest(RANGE.0).min(flattest(RANGE.1));
        let rises = shares.map(|share| share * agpi.gain * least * (RANGE.1 - RANGE.0));
        ModelParameters::Egpi(EgpiParameters { agpi, memoryless: MemorylessParameters { rises } })
    })
}

/// The members in which the output is monotone from every state, also over a reversal.
pub fn cascades() -> impl Strategy<Value = Parameters> {
    prop_oneof![cpi(), sgpi(), mpi(), mgpi()]
}

/// The members with two envelopes, whose output jumps at a reversal.
pub fn jumping() -> impl Strategy<Value = Parameters> {
    prop_oneof![agpi(), egpi()]
}

/// Every member, fresh or preconditioned.
pub fn family() -> impl Strategy<Value = Parameters> {
    let member = prop_oneof![2 => cascades(), 1 => jumping()];
    (member, any::<bool>()).prop_map(|(member, said)| member.with_preconditioned(said))
}

/// A history as shares of the input range. Half of them turn around in ever narrower bounds, which
/// leaves corners in the memory: so that together they come near every admissible state.
pub fn history() -> impl Strategy<Value = Vec<f64>> {
    let narrowing = prop::collection::vec(0.0..0.5, 1..30).prop_map(|steps| {
        // Each extremum lies between the two before it.
        let (mut last, mut before) = (0.0, 1.0);
        let mut turn = |step: f64| {
            (before, last) = (last, before + step * (last - before));
            last
        };
        steps.into_iter().map(&mut turn).collect()
    });
    let anywhere = prop_oneof![6 => 0.0..=1.0, 1 => Just(0.0), 1 => Just(1.0), 1 => Just(0.5)];
    prop_oneof![prop::collection::vec(anywhere, 1..40), narrowing]
}

/// Outputs that the plays can have at the input `v`, from how far each is from the one before, -1
/// to 1.
pub fn admissible_outputs(parameters: &PlayParameters<f64, SIZE>, v: f64, distances: &[f64]) -> Vec<f64> {
    let (mut output, mut last) = (v, 0.0);
    let mut next = |(threshold, distance): (&f64, &f64)| {
        output += distance * (threshold - last);
        last = *threshold;
        output
    };
    parameters.thresholds.iter().zip(distances).map(&mut next).collect()
}

/// A validated model of the family and a state, driven by shares of its input range.
pub struct Run<T: Real> {
    pub model: Model<T, SIZE, SIZE>,
    pub state: State<T>,
}

impl<T: Real> Run<T> {
    pub fn at_rest(parameters: &Parameters) -> Self {
        let model = Model::try_new(&parameters.convert().expect("same capacity")).expect("valid");
        let state = model.rest_state();
        Self { model, state }
    }

    pub fn after(parameters: &Parameters, history: &[f64]) -> Self {
        let mut run = Self::at_rest(parameters);
        for &share in history {
            run.to(share);
        }
        run
    }

    /// The input at a share of the range.
    pub fn input(&self, share: f64) -> T {
        at(self.model.input_range(), share)
    }

    /// The output there, and the state.
    pub fn to(&mut self, share: f64) -> T {
        let x = self.input(share);
        self.model.step(&mut self.state, x).expect("finite")
    }

    /// The output there, from the present state, which stays.
    pub fn would_be(&self, share: f64) -> T {
        self.model.step(&mut self.state.clone(), self.input(share)).expect("finite")
    }

    /// Highest less lowest output over the range: what errors are compared with.
    pub fn span(&self) -> f64 {
        let (low, high) = self.model.output_range();
        (high - low).to_f64()
    }
}

/// The value at a share of a range; 0 and 1 are exactly its ends.
fn at<T: Real>(range: &Range<T>, share: f64) -> T {
    range.limit(range.min() + T::from_f64(share) * (range.max() - range.min()))
}
