//! The root of a rising function of one variable, each evaluation of which is dear.
//!
//! Secants, kept within the bracket of the signs so far; where they do not get on, halving. The number of rounds is
//! bounded, whatever the function.

use crate::real::Real;

/// So many rounds by secants; then the bracket is halved.
const SECANTS: u8 = 10;
/// And so many rounds in all: in double precision nothing is left to halve after 53.
const ROUNDS: u8 = 70;
/// How much farther a secant may lead, out of what is bracketed, than the way so far.
const FARTHER: f64 = 8.0;

/// An argument and the function there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point<T> {
    pub(super) u: T,
    pub(super) f: T,
}

/// Searches from a point, whose `f` is not 0, with a guess of the function's slope (above 0). Answers the last argument that
/// was evaluated, within `tolerance` of the root or thereabouts, and the slope there.
pub(super) fn root<T: Real>(
    from: Point<T>,
    slope: T,
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
        let slope = (here.f - before.f) / (here.u - before.u);
        let secant = here.u - here.f / slope;
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
