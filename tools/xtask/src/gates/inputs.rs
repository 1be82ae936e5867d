//! The samples that ask the most of the controller: full reversals, at which every play moves and
//! turns round in every sample, and nested reversals, which build the deepest memory and then wipe
//! all of it. The muscle is on the other side of its range, so that the feedback and its limits
//! work hard.

/// One sample for the control law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Unit: mm.
    pub reference_mm: f32,
    /// Unit: mm.
    pub contraction_mm: f32,
}

/// Turning points of a nest, many more than there are plays.
const NEST: u32 = 60;

/// All samples in their order, for a muscle that contracts from `low_mm` to `high_mm`. The same in
/// every run.
pub fn samples((low_mm, high_mm): (f64, f64)) -> Vec<Sample> {
    let at = |share: f64| (low_mm + share * (high_mm - low_mm)) as f32;
    let full = reversals(0.5, 100, |_| 0.5);
    full.chain((1..10).flat_map(nested_reversals))
        .map(|share| Sample { reference_mm: at(share), contraction_mm: at(1.0 - share) })
        .collect()
}

/// Turning points on alternate sides of a centre; `amplitude` takes their number. As shares of the
/// muscle's range.
fn reversals(centre: f64, count: u32, amplitude: impl Fn(u32) -> f64) -> impl Iterator<Item = f64> {
    (0..count).map(move |k| centre + if k % 2 == 0 { amplitude(k) } else { -amplitude(k) })
}

/// Ever smaller swings around a centre, and then the whole range twice.
fn nested_reversals(place: u32) -> impl Iterator<Item = f64> {
    let centre = f64::from(place) / 10.0;
    let widest = centre.min(1.0 - centre);
    let shrinking = move |k| widest * (1.0 - f64::from(k) / f64::from(NEST));
    reversals(centre, NEST, shrinking).chain([1.0, 0.0, 1.0, 0.0])
}

#[cfg(test)]
mod tests {
    use super::samples;

    #[test]
    fn the_reference_turns_round_in_nearly_every_sample() {
        let samples = samples((-10.0, 90.0));
        let rises: Vec<_> =
            samples.windows(2).map(|pair| pair[1].reference_mm > pair[0].reference_mm).collect();
        let turns = rises.windows(2).filter(|pair| pair[0] != pair[1]).count();
        // Where one nest ends and the next begins, two samples may go the same way.
        assert!(turns + 2 * 9 + 2 >= samples.len(), "{turns} of {}", samples.len());
    }
}
