//! What is identified: the parts of a model of the family, and the coordinates that they have.

use model_core::Kind;
use model_core::memoryless::DEGREE;

use super::coordinates::Coordinate;
use super::envelope::Shape;
use super::plays;
use super::{Options, Weights};

/// Entries of a row beside derivatives of u and added functions: 1, the way gone in the segment,
/// and the measured output less the reference.
pub const FURTHER: usize = 3;

/// The parts of a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Structure {
    /// Which model.
    pub kind: Kind,
    /// Its envelope or envelopes.
    pub shape: Shape,
    /// Number of plays.
    pub plays: usize,
    /// What their weights are made of.
    pub weights: Weights,
    /// Number of segments of the memoryless stage behind the plays; 1 for a straight line.
    pub segments: usize,
}

impl Structure {
    /// The structure that the options ask for.
    pub fn new(options: &Options) -> Self {
        let envelope = options.knots.map_or(Shape::Tanh, Shape::Knots);
        let (shape, segments) = match options.model {
            Kind::Cpi => (Shape::Identity, 1),
            Kind::Sgpi => (envelope, 1),
            Kind::Agpi | Kind::Egpi => (Shape::TwoTanh, 1),
            Kind::Mpi => (Shape::Identity, options.dead_zones),
            Kind::Mgpi => (envelope, options.dead_zones),
        };
        Self { kind: options.model, shape, plays: options.plays, weights: Weights::Exponential, segments }
    }

    /// The nonlinear coordinates: those of the envelope, then those of the plays.
    pub fn coordinates(&self) -> Vec<Coordinate> {
        let mut coordinates = self.shape.coordinates();
        coordinates.extend(plays::coordinates(self.weights, self.plays));
        coordinates
    }

    /// Number of added memoryless functions of the input.
    pub fn added(&self) -> usize {
        if self.kind == Kind::Egpi { DEGREE } else { 0 }
    }

    /// Number of entries of a row in the sums of a search.
    pub fn entries(&self) -> usize {
        self.coordinates().len() + self.added() + FURTHER
    }

    /// Number of linear unknowns: offset, slopes and added functions.
    pub fn linear(&self) -> usize {
        1 + self.segments + self.added()
    }

    /// Number of all unknowns.
    pub fn unknowns(&self) -> usize {
        self.coordinates().len() + self.linear()
    }
}
