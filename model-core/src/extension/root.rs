//! The root of a rising function of one variable, each evaluation of which is dear.
//!
//! Secants, kept within the bracket of the signs so far; where they do not get on, halving. The
//! number of rounds is bounded, whatever the function. Two tries that are next to each other differ
//! by little but roundings, and by those of a search inside: no slope is taken from them, since one
//! that is much too steep would end this search, and the next one, where it is.

use crate::real::Real;

/// So many rounds by secants; then the bracket is halved.
const SECANTS: u8 = 10;
/// And so many rounds in all: in double precision nothing is left to halve after 53.
const ROUNDS: u8 = 70;
/// Slopes are taken from tries that are farther apart than this, in tolerances.
const APART: f64 = 100.0;
/// How much farther a secant may lead, out of what is bracketed, than the way so far.
const FARTHER: f64 = 8.0;

/// An argument and the function there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Point<T> {
    pub(crate) u: T,
    pub(crate) f: T,
}

/// Searches from a point, whose `f` is not 0, with a guess of the function's slope (above 0).
/// Answers the last argument that was evaluated, within `tolerance` of the root or thereabouts, and
/// the last slope that was found, above 0.
pub(crate) fn root<T: Real>(
    from: Point<T>,
    mut slope: T,
    tolerance: T,
    mut evaluate: impl FnMut(T) -> T,
) -> (T, T) {
    let (mut near, mut far) = (from, None);
    let mut before = from;
    let mut u = from.u - from.f / slope;
    let mut round = 0;
    loop {
        let here = Point { u, f: evaluate(u) };
        if (here.f < T::ZERO) == (from.f < T::ZERO) {
            near = here;
        } else {
            far = Some(here.u);
        }
        let way = here.u - before.u;
        let found =
            if way.abs() > T::from_f64(APART) * tolerance { (here.f - before.f) / way } else { slope };
        let secant = here.u - here.f / found;
        if found > T::ZERO && found.is_finite() {
            slope = found;
        }
        let next = match far {
            Some(far) if round < SECANTS && is_between(secant, near.u, far) => secant,
            Some(far) => near.u + (far - near.u) * T::from_f64(0.5),
            None => {
                let farthest = from.u + (here.u - from.u) * T::from_f64(FARTHER);
                if is_between(secant, here.u, farthest) { secant } else { farthest }
            }
        };
        round += 1;
        if here.f == T::ZERO || (next - here.u).abs() <= tolerance || round == ROUNDS {
            return (here.u, slope);
        }
        before = here;
        u = next;
    }
}

fn is_between<T: Real>(value: T, one: T, other: T) -> bool {
    if one < other { value > one && value < other } else { value > other && value < one }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A line of slope 2 with errors of size `noise` that look random, from a point before its root
    /// at 1.
    fn searched(from: f64, slope: f64, noise: f64) -> (f64, f64) {
        let line = |u: f64| 2.0 * (u - 1.0) + noise * (u * 1e15).sin();
        root(Point { u: from, f: line(from) }, slope, 1e-11, line)
    }

    #[test]
    fn errors_of_the_function_move_the_root_by_no_more_than_themselves() {
        for from in [0.0, 0.9, 1.0 - 1e-8, 1.0 - 1e-10, 1.0 + 3e-10, 4.0] {
            for first in [0.1, 1.0, 30.0, 1e3] {
                let (u, slope) = searched(from, first, 1e-9);
                assert!((u - 1.0).abs() < 1e-6, "{u} from {from}");
                // What is left with the next search is the line's slope, or what was given.
                assert!(slope == first || (slope - 2.0).abs() < 2.1, "{slope} from {from}");
            }
        }
    }

    #[test]
    fn without_errors_it_is_found_to_the_tolerance() {
        for first in [0.1, 1.0, 30.0] {
            let (u, _) = searched(0.0, first, 0.0);
            assert!((u - 1.0).abs() <= 1e-11, "{u}");
        }
    }
}
