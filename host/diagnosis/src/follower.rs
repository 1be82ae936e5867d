//! What follows a goal by a linear law of first or second order: exactly, if the goal moves evenly from row to row.
//!
//! However far rows are apart a swing keeps its frequency and its damping; by a difference rule one of 15 Hz would be one of
//! 12 Hz in rows of 20 ms.

/// Under so small an angle a step of the swing is taken as one at the border of swinging.
const SMALL: f64 = 1e-6;

/// Where it is, and how it moves.
#[derive(Clone, Copy, Debug)]
pub struct Follower {
    goal: f64,
    place: f64,
    rate: f64,
}

impl Follower {
    /// At rest.
    pub fn resting(place: f64) -> Self {
        Self { goal: place, place, rate: 0.0 }
    }

    /// Goes on to where place + damping rate + mass acceleration = goal; returns the place. Neither mass nor damping is below 0.
    /// Units: those of the goal, s, s², s.
    pub fn follow(&mut self, goal: f64, step_s: f64, [mass, damping]: [f64; 2]) -> f64 {
        let slope = if step_s > 0.0 { (goal - self.goal) / step_s } else { 0.0 };
        if [mass, damping] == [0.0; 2] || step_s <= 0.0 {
            *self = Self { goal, place: goal, rate: slope };
            return goal;
        }
        // Behind an evenly moving goal it is so far in the end; the way off that dies away.
        let behind = damping * slope;
        let (off, off_rate) = (self.place - self.goal + behind, self.rate - slope);
        let (off, off_rate) = if mass > 0.0 {
            let (square, half) = (1.0 / mass, 0.5 * damping / mass);
            let (whole, swung) = swing(square, half, step_s);
            (
                off * whole + (off_rate + half * off) * swung,
                off_rate * whole - (half * off_rate + square * off) * swung,
            )
        } else {
            let left = off * (-step_s / damping).exp();
            (left, -left / damping)
        };
        *self = Self { goal, place: goal - behind + off, rate: slope + off_rate };
        self.place
    }
}

/// exp(-h t) cos(w t) and exp(-h t) sin(w t)/w with w² = `square` - h², whatever its sign.
fn swing(square: f64, half: f64, t: f64) -> (f64, f64) {
    let below = square - half * half;
    let w = below.abs().sqrt();
    if w * t < SMALL {
        let decay = (-half * t).exp();
        return (decay, decay * t);
    }
    if below > 0.0 {
        let decay = (-half * t).exp();
        return (decay * (w * t).cos(), decay * (w * t).sin() / w);
    }
    let (slow, fast) = ((-square / (half + w) * t).exp(), (-(half + w) * t).exp());
    (0.5 * (slow + fast), 0.5 * (slow - fast) / w)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Follows triangles of 1.2 s in steps of a share of 20 ms; a place each 20 ms.
    fn followed(shares: usize, law: [f64; 2]) -> Vec<f64> {
        let goal = |step: usize| {
            let turns = (step as f64 / (60.0 * shares as f64)).fract();
            30.0 * (1.0 - (2.0 * turns - 1.0).abs())
        };
        let mut follower = Follower::resting(0.0);
        let step_s = 0.02 / shares as f64;
        let places = (1..=300 * shares).map(|step| follower.follow(goal(step), step_s, law));
        places.skip(shares - 1).step_by(shares).collect()
    }

    #[test]
    fn rows_that_are_farther_apart_follow_as_those_between() {
        // A swing of 15 Hz, one that is nearly damped, one at the border, one far beyond it, a lag, hardly a mass.
        for law in [[1.1e-4, 6e-3], [1e-3, 0.05], [1e-4, 0.02], [1e-4, 0.5], [0.0, 0.1], [1e-14, 0.1]] {
            for (coarse, fine) in followed(1, law).iter().zip(followed(8, law)) {
                assert!((coarse - fine).abs() < 1e-6, "{coarse} and {fine} by {law:?}");
            }
        }
    }

    #[test]
    fn what_it_follows_is_the_law() {
        let (law, step_s) = ([1e-3, 0.02], 1e-4);
        let mut follower = Follower::resting(0.0);
        let places: Vec<f64> = (1..5000)
            .map(|step| follower.follow((f64::from(step) * step_s * 9.0).sin(), step_s, law))
            .collect();
        for (step, three) in places.windows(3).enumerate().skip(10) {
            let rate = (three[2] - three[0]) / (2.0 * step_s);
            let acceleration = (three[2] - 2.0 * three[1] + three[0]) / (step_s * step_s);
            let goal = ((step + 2) as f64 * step_s * 9.0).sin();
            assert!((three[1] + law[1] * rate + law[0] * acceleration - goal).abs() < 2e-4, "row {step}");
        }
    }

    #[test]
    fn without_a_law_it_is_where_the_goal_is() {
        let mut follower = Follower::resting(3.0);
        assert_eq!(follower.follow(5.0, 0.01, [0.0; 2]), 5.0);
        assert_eq!(follower.follow(6.0, 0.0, [1e-3, 0.1]), 6.0);
    }
}
