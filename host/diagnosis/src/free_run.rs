//! The fitted baseline with its effects, running free: from the input and the recorded columns alone.
//!
//! The search puts the measured contraction into the effects, which lets the output explain a part of itself. Here the
//! rate, the acceleration, the travel and the creep are those of the simulated contraction.
//!
//! At every row the operators' input is the root of a balance that rises with it, or the contraction is where thresholds
//! follow its speed; acceleration and rate by Newmark's rule of average acceleration, rate alone by backward differences: both
//! stable at any step. What follows the operators on the output does so exactly (`follower`).

use super::basis::{Basis, Curved, Walk, Weights};
use super::effect::{Driver, Effect, Form, Parameter, Rate};
use super::equivalent::{Arrived, Friction, bend, faster, through, wider};
use super::fit::Fit;
use super::follower::Follower;
use super::output;
use super::series::series;
use super::signals::{Signals, TENTS};
use recording::simulation::SAME_STEP_S;

/// Evaluations of the balance a row, at most.
const EVALUATIONS: usize = 40;
/// A balance is met within this share of the input's span, or of the stroke; also the width of an interval that its root is
/// known to lie in.
const CLOSE: f64 = 3e-6;

/// A free run.
pub struct FreeRun {
    /// The simulated contraction of the scored rows. Output unit.
    pub scored: Vec<f64>,
    /// The same of all rows, without what is added to the output. Output unit.
    pub all: Vec<f64>,
}

/// Runs a fit from the input and the recorded columns alone.
pub fn free_run(signals: &Signals, basis: &Basis, fit: &Fit) -> FreeRun {
    let Arrived { input, speed } = Arrived::new(signals, &fit.effects);
    let (mut added, mut creep) = (vec![0.0; signals.rows.len()], Vec::new());
    // Weights of acceleration and rate on the output, one a tent.
    let mut filter = [[0.0; TENTS]; 2];
    let lag = series(fit, signals).map(|all| {
        filter = [all.map(|series| series.mass_s2), all.map(|series| series.damping_s)];
        all.map(|series| series.lag_s)
    });
    for (effect, place) in fit.effects.iter().zip(fit.output_places(signals)) {
        let (columns, _) = output::columns(effect, signals);
        let weights = &fit.weights[place];
        match effect.form {
            Form::Creep => {
                creep = weights.iter().copied().zip(signals.creep_s.iter().copied()).collect();
                continue;
            }
            Form::LagBefore | Form::OutputInertia if lag.is_some() => continue,
            Form::OutputLag | Form::OutputInertia => {
                // Of a lag there is the rate alone.
                let parts = filter.iter_mut().rev().zip(weights.rchunks(TENTS));
                parts.for_each(|(sums, weights)| sums.iter_mut().zip(weights).for_each(|(s, w)| *s += w));
                continue;
            }
            _ => {}
        }
        for (column, weight) in columns.iter().zip(weights) {
            added.iter_mut().zip(column).for_each(|(sum, value)| *sum += weight * value);
        }
    }
    let weights = Weights::new(&fit.weights);
    let first = input.first().copied().unwrap_or(0.0);
    let mut state = State::new(signals, basis.curved(bend(&fit.effects)), (&fit.effects, &weights), first);
    let [mut late, mut behind] = [Follower::resting(signals.output[0]); 2];
    let mut slow = vec![signals.output[0]; creep.len()];
    let (mut shares, mut shares_s) = (vec![0.0; creep.len()], 0.0);
    let mut run =
        FreeRun { scored: Vec::with_capacity(signals.rows.len()), all: Vec::with_capacity(input.len()) };
    for (at, (&pressure, &speed)) in input.iter().zip(&speed).enumerate() {
        let step_s = if at == 0 { 0.0 } else { signals.time_s[at] - signals.time_s[at - 1] };
        let muscle = state.step(at, pressure, speed, step_s);
        let muscle = match &lag {
            Some(lag) => late.follow(muscle, step_s, [0.0, through(&signals.tents[at], lag)]),
            None => muscle,
        };
        let muscle =
            behind.follow(muscle, step_s, filter.map(|weights| through(&signals.tents[at], &weights)));
        // y (1 + sum c (1 - b)) = muscle + sum c (1 - b) slow, b the share that a low-pass takes up in this step.
        if (step_s - shares_s).abs() > SAME_STEP_S {
            shares_s = step_s;
            shares = creep.iter().map(|(_, tau_s)| -(-step_s / tau_s).exp_m1()).collect();
        }
        let (mut over, mut under) = (muscle, 1.0);
        for (((weight, _), share), slow) in creep.iter().zip(&shares).zip(&slow) {
            over += weight * (1.0 - share) * slow;
            under += weight * (1.0 - share);
        }
        let contraction = over / under;
        for (slow, share) in slow.iter_mut().zip(&shares) {
            *slow += (contraction - *slow) * share;
        }
        run.all.push(contraction);
        let next = run.scored.len();
        if signals.rows.get(next).is_some_and(|row| row.at == at) {
            run.scored.push(contraction + added[next]);
        }
    }
    run
}

/// What a free run goes through, and what it remembers.
struct State<'a> {
    signals: &'a Signals,
    curved: Curved<'a>,
    effects: &'a [Effect],
    weights: &'a Weights,
    /// Thresholds that are wider with a rate.
    widening: Option<(&'a Effect, Rate)>,
    widths: Vec<Width>,
    walk: Walk,
    last_input: f64,
    motion: Motion,
    travel: f64,
    /// How the balances of the input and of the contraction rose at the last root.
    rises: [f64; 2],
    /// Within what these are met. Units: those of input and output.
    close: [f64; 2],
}

/// A width, its stop, and the power of the rate that its range follows.
struct Width {
    friction: Friction,
    power: Option<f64>,
    stop: f64,
    /// At this row.
    slope: f64,
}

impl Width {
    fn of(effect: &Effect) -> Option<Self> {
        let power = matches!(effect.form, Form::Friction(_)).then(|| effect.parameters[0].value);
        Some(Self { friction: Friction::of(effect)?, power, stop: 0.0, slope: 0.0 })
    }

    /// The stop's range where the thresholds are `wider` and the contraction is so fast (output unit/s). Input unit.
    #[inline(always)]
    fn range(&self, signals: &Signals, wider: f64, rate: f64) -> f64 {
        let times = self.power.map_or(wider, |power| faster(signals, Rate::Contraction, power, rate));
        self.friction.range * times
    }

    /// The stop after a change of the input, within a range.
    #[inline(always)]
    fn moved(&self, change: f64, range: f64) -> f64 {
        (self.stop + change).min(range).max(-range)
    }
}

/// Where a step may lead.
struct Reached {
    walk: Walk,
    motion: Motion,
    wider: f64,
}

impl<'a> State<'a> {
    fn new(
        signals: &'a Signals,
        curved: Curved<'a>,
        (effects, weights): (&'a [Effect], &'a Weights),
        input: f64,
    ) -> Self {
        let widening = |effect: &'a Effect| match effect.form {
            Form::Thresholds(rate) => Some((effect, rate)),
            _ => None,
        };
        Self {
            signals,
            curved,
            effects,
            weights,
            widening: effects.iter().find_map(widening),
            widths: effects.iter().filter_map(Width::of).collect(),
            walk: curved.start(input),
            last_input: input,
            motion: Motion { place: signals.output[0], rate: 0.0, acceleration: 0.0 },
            travel: 0.0,
            rises: [1.0; 2],
            close: [signals.input_span, signals.stroke()].map(|span| CLOSE * span),
        }
    }

    /// What is wanted of the operators' input at a row, and what resists.
    fn forces(&self, at: usize, pressure: f64, step_s: f64) -> Forces {
        let (mut wanted, mut viscosity, mut mass) = (pressure, 0.0, 0.0);
        let through = |tents: &[f64; TENTS], parameters: &[Parameter]| {
            through(tents, &std::array::from_fn(|tent| parameters[tent].value))
        };
        let strength = |parameters: &[Parameter]| through(&self.signals.tents[at], parameters);
        for effect in self.effects {
            let parameters = &effect.parameters;
            match effect.form {
                Form::Driven(Driver::Rate) => viscosity += strength(parameters),
                Form::Driven(Driver::WarmUp) => {
                    let settled = (-self.travel / parameters[0].value.exp()).exp();
                    wanted -= strength(&parameters[1..]) * settled;
                }
                Form::Driven(driver) => {
                    wanted -= strength(parameters) * output::driven(self.signals, driver, 1.0, at);
                }
                Form::Inertia => {
                    // Where the muscle will be about.
                    let ahead = self.signals.moving_tents_at(self.motion.place + self.motion.rate * step_s);
                    mass += through(&ahead, parameters);
                    viscosity += through(&ahead, &parameters[TENTS..]);
                }
                _ => {}
            }
        }
        (wanted, viscosity, mass)
    }

    /// One row: its place, the pressure, its speed and the time since the row before. Returns the muscle's contraction.
    fn step(&mut self, at: usize, pressure: f64, input_speed: f64, step_s: f64) -> f64 {
        let signals = self.signals;
        let forces = self.forces(at, pressure, step_s);
        self.widths.iter_mut().for_each(|width| width.slope = width.friction.slope(signals, at));
        let (u, Reached { walk, motion, wider }) = match self.widening {
            Some((effect, Rate::Contraction)) if step_s > 0.0 => self.follow(effect, forces, step_s),
            Some((effect, Rate::Contraction)) => {
                self.balance(forces, step_s, wider(signals, effect, Rate::Contraction, 0.0))
            }
            Some((effect, rate)) => self.balance(forces, step_s, wider(signals, effect, rate, input_speed)),
            None => self.balance(forces, step_s, 1.0),
        };
        let change = u - self.last_input;
        for width in &mut self.widths {
            width.stop = width.moved(change, width.range(signals, wider, motion.rate));
        }
        self.travel += if at == 0 { 0.0 } else { (motion.place - self.motion.place).abs() };
        (self.walk, self.last_input, self.motion) = (walk, u, motion);
        motion.place
    }

    /// The operators' input, and where it leads, with thresholds that are so much wider: the root of the balance over it.
    fn balance(&mut self, (wanted, viscosity, mass): Forces, step_s: f64, wider: f64) -> (f64, Reached) {
        let (before, last_input) = (self.motion, self.last_input);
        let over = |u: f64, motion: &Motion| {
            let taken = self.taken_by_widths(u - last_input, wider, motion.rate);
            u + taken + viscosity * motion.rate + mass * motion.acceleration - wanted
        };
        let [mut rise, _] = self.rises;
        let resting = before.to(before.place, step_s, mass > 0.0);
        let mut reached = Reached { walk: self.walk, motion: resting, wider };
        // Where nothing moves the balance is known without a step of the operators, about.
        let start = last_input - over(last_input, &reached.motion) / rise;
        let u = root(start, &mut rise, self.close[0], |u| {
            reached.walk = self.walk;
            self.curved.advance(&mut reached.walk, u, wider);
            reached.motion = before.to(self.weights.sum(&reached.walk), step_s, mass > 0.0);
            over(u, &reached.motion)
        });
        self.rises[0] = rise;
        (u, reached)
    }

    /// The same with thresholds that follow the speed of the contraction. With that both these and the balance are known:
    /// one root, over the contraction, since the faster it moves the less the operators let it, and the less the balance
    /// leaves them.
    fn follow(
        &mut self,
        thresholds: &Effect,
        (wanted, viscosity, mass): Forces,
        step_s: f64,
    ) -> (f64, Reached) {
        let (before, last_input) = (self.motion, self.last_input);
        let [_, mut rise] = self.rises;
        let (mut u, mut reached) = (last_input, Reached { walk: self.walk, motion: before, wider: 1.0 });
        root(before.place + before.rate * step_s, &mut rise, self.close[1], |y| {
            let motion = before.to(y, step_s, mass > 0.0);
            let wider = wider(self.signals, thresholds, Rate::Contraction, motion.rate);
            let left = wanted - viscosity * motion.rate - mass * motion.acceleration;
            u = self.left_by_widths(left, wider, motion.rate);
            reached = Reached { walk: self.walk, motion, wider };
            self.curved.advance(&mut reached.walk, u, wider);
            y - self.weights.sum(&reached.walk)
        });
        self.rises[1] = rise;
        (u, reached)
    }

    /// The operators' input that the widths leave of what there is for both, where the thresholds are `wider` and the
    /// contraction is so fast (output unit/s). Input unit.
    fn left_by_widths(&self, both: f64, wider: f64, rate: f64) -> f64 {
        let [close, _] = self.close;
        root(both, &mut 1.0, close, |u| u + self.taken_by_widths(u - self.last_input, wider, rate) - both)
    }

    /// What the widths take after a change of the operators' input. Input unit.
    #[inline(always)]
    fn taken_by_widths(&self, change: f64, wider: f64, rate: f64) -> f64 {
        let of = |width: &Width| width.slope * width.moved(change, width.range(self.signals, wider, rate));
        self.widths.iter().map(of).sum()
    }
}

/// What is wanted of the operators' input, viscosity, and mass. Units: those of the input, over the rate and over the acceleration of the
/// output.
type Forces = (f64, f64, f64);

/// A place, and how it moves.
#[derive(Clone, Copy)]
struct Motion {
    place: f64,
    rate: f64,
    acceleration: f64,
}

impl Motion {
    /// The motion that ends at `place` after a step: by Newmark's rule where there is a mass, else by the difference.
    #[inline(always)]
    fn to(&self, place: f64, step_s: f64, with_mass: bool) -> Self {
        if step_s <= 0.0 {
            return Self { place, rate: 0.0, acceleration: 0.0 };
        }
        let moved = place - self.place;
        if !with_mass {
            return Self { place, rate: moved / step_s, acceleration: 0.0 };
        }
        let acceleration = 4.0 * (moved - step_s * self.rate) / (step_s * step_s) - self.acceleration;
        Self { place, rate: self.rate + 0.5 * step_s * (self.acceleration + acceleration), acceleration }
    }
}

/// The root of a function that rises by at least as much as what it is of, near `start`: by secants, the first one with the
/// rise of the last root, inside of what is known to enclose it. It is the last argument that the function was asked for.
#[inline(always)]
fn root(start: f64, rise: &mut f64, close: f64, mut f: impl FnMut(f64) -> f64) -> f64 {
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    let (mut at, mut value) = (start, f(start));
    for _ in 1..EVALUATIONS {
        if value > 0.0 {
            high = at;
        } else {
            low = at;
        }
        // A run that has gone out of all bounds stays there.
        if value.abs() < close || high - low < close || !value.is_finite() {
            break;
        }
        let secant = at - value / *rise;
        let next = if low < secant && secant < high { secant } else { 0.5 * (low + high) };
        let next_value = f(next);
        *rise = ((next_value - value) / (next - at)).max(1.0);
        (at, value) = (next, next_value);
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Kinks, and slopes from 1 to 1000.
    fn kinked(u: f64) -> f64 {
        u - 0.3 + 999.0 * (u - 0.29).max(0.0) + 5.0 * (u + 1.0).clamp(-0.1, 0.1)
    }

    #[test]
    fn a_root_is_found_across_kinks_whatever_the_last_rise() {
        for start in [-3.0, 0.0, 0.4, 7.0] {
            for last in [1.0, 30.0, 5e4] {
                let mut rise = last;
                let u = root(start, &mut rise, CLOSE, kinked);
                let value = kinked(u);
                assert!(value.abs() < 1e3 * CLOSE, "from {start}, rise {last}: {value} at {u}");
            }
        }
    }

    #[test]
    fn a_root_of_a_straight_line_whose_rise_is_known_takes_two_evaluations() {
        let mut evaluations = 0;
        let line = |u: f64| {
            evaluations += 1;
            40.0 * (u - 0.7)
        };
        let u = root(0.0, &mut 40.0, CLOSE, line);
        assert!((u - 0.7).abs() < CLOSE);
        assert_eq!(evaluations, 2);
    }

    #[test]
    fn what_is_out_of_all_bounds_is_not_searched_on() {
        let mut evaluations = 0;
        let nowhere = |_: f64| {
            evaluations += 1;
            f64::NAN
        };
        root(0.0, &mut 1.0, CLOSE, nowhere);
        assert_eq!(evaluations, 1);
    }
}
