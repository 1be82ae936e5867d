//! Which pressures bring about a torque and a stiffness.
//!
//! Both are linear in the drives of the muscles. The torque goes first: of the drives that have it,
//! a line, those within the bounds of both pressures are looked at, and of these the nearest to the
//! stiffness is taken. Where no drives have the torque, the answer is the corner nearest to it.

use super::pull::Pull;
use crate::real::Real;

/// constant + by[0] u_a + by[1] u_b.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Form<T> {
    pub(crate) constant: T,
    pub(crate) by: [T; 2],
}

/// What was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shared<T> {
    /// Unit: bar.
    pub(crate) pressures: [T; 2],
    /// The torque that they make less that which was asked for; 0 where the bounds allow it. Unit:
    /// N m.
    pub(crate) excess: T,
    /// Whether the bounds allow the stiffness too.
    pub(crate) is_as_stiff: bool,
}

impl<T: Real> Form<T> {
    /// The value at some drives.
    pub(crate) fn at(&self, [u_a, u_b]: [T; 2]) -> T {
        let [by_a, by_b] = self.by;
        self.constant + by_a * u_a + by_b * u_b
    }

    /// How much it grows with the first drive where another form, the torque, is kept by the second
    /// one.
    pub(crate) fn along(&self, kept: &Self) -> T {
        let ([by_a, by_b], [kept_a, kept_b]) = (self.by, kept.by);
        by_a - by_b * (kept_a / kept_b)
    }

    /// The second drive that makes this form the wanted value.
    fn second(&self, wanted: T, u_a: T) -> T {
        let [by_a, by_b] = self.by;
        (wanted - self.constant - by_a * u_a) / by_b
    }

    /// The first drive that does.
    fn first(&self, wanted: T, u_b: T) -> T {
        let [by_a, by_b] = self.by;
        (wanted - self.constant - by_b * u_b) / by_a
    }
}

/// The pressures for a torque (N m) and a stiffness (N m/rad) at an angle (rad). The torque grows
/// with the first drive and falls with the second.
pub(crate) fn share<T: Real, const N: usize>(
    muscles: &[Pull<T, N>; 2],
    angle: T,
    (torque, wanted): (&Form<T>, T),
    (stiffness, stiff): (&Form<T>, T),
) -> Shared<T> {
    let [a, b] = muscles;
    let drives = |muscle: &Pull<T, N>| {
        let (lowest, highest) = muscle.bounds(angle);
        (muscle.drive(lowest), muscle.drive(highest))
    };
    let ((low_a, high_a), (low_b, high_b)) = (drives(a), drives(b));
    let low = low_a.at_least(torque.first(wanted, low_b));
    let high = high_a.at_most(torque.first(wanted, high_b));
    let (u, is_as_stiff) = if low <= high {
        let gain = stiffness.along(torque);
        // The stiffness where the first drive is 0, the torque kept.
        let from = stiffness.at([T::ZERO, torque.second(wanted, T::ZERO)]);
        let exact = (stiff - from) / gain;
        let u_a = exact.limit(low, high);
        ([u_a, torque.second(wanted, u_a)], u_a == exact)
    } else if low > high_a {
        // Not even all of the first muscle and the least of the second turn so far.
        ([high_a, low_b], false)
    } else {
        ([low_a, high_b], false)
    };
    let reached = torque.at(u);
    let [u_a, u_b] = u;
    Shared {
        pressures: [a.pressure(u_a), b.pressure(u_b)],
        excess: if low <= high { T::ZERO } else { reached - wanted },
        is_as_stiff,
    }
}
