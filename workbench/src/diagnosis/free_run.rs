//! The fitted baseline with its effects, running free: from the input and the recorded columns alone.
//!
//! The search puts the measured contraction into the effects, which lets the output explain a part of itself. Here the
//! rate, the acceleration, the travel and the creep are those of the simulated contraction.
//!
//! At every row the operators' input is the root of a balance that rises with it; acceleration and rate by Newmark's
//! rule of average acceleration, rate alone by backward differences: both stable at any step.

use super::basis::{Basis, COLUMNS};
use super::effect::{Driver, Effect, Form, Rate};
use super::equivalent::{Arrived, Friction, bend, strength, wider};
use super::fit::Fit;
use super::output;
use super::signals::{Signals, TENTS};

/// Evaluations of the balance a row, at most.
const EVALUATIONS: usize = 40;

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
    // Weights of acceleration and rate on the output.
    let mut filter = (0.0, 0.0);
    let mut place = COLUMNS;
    for effect in &fit.effects {
        let (columns, _) = output::columns(effect, signals);
        let weights = &fit.weights[place..place + columns.len()];
        place += columns.len();
        match effect.form {
            Form::Creep => {
                creep = weights.iter().copied().zip(signals.creep_s.iter().copied()).collect();
                continue;
            }
            Form::OutputLag => {
                filter.1 += weights[0];
                continue;
            }
            Form::OutputInertia => {
                (filter.0, filter.1) = (filter.0 + weights[0], filter.1 + weights[1]);
                continue;
            }
            _ => {}
        }
        for (column, weight) in columns.iter().zip(weights) {
            added.iter_mut().zip(column).for_each(|(sum, value)| *sum += weight * value);
        }
    }
    let mut state = State::new(basis, &fit.effects, input.first().copied().unwrap_or(0.0), signals.output[0]);
    let mut behind = Motion { place: signals.output[0], rate: 0.0, acceleration: 0.0 };
    let mut slow = vec![signals.output[0]; creep.len()];
    let mut run =
        FreeRun { scored: Vec::with_capacity(signals.rows.len()), all: Vec::with_capacity(input.len()) };
    for (at, (&pressure, &speed)) in input.iter().zip(&speed).enumerate() {
        let step_s = if at == 0 { 0.0 } else { signals.time_s[at] - signals.time_s[at - 1] };
        let muscle = state.step(signals, basis, &fit.effects, &fit.weights, (at, pressure, speed, step_s));
        let muscle = behind.follow(muscle, step_s, filter);
        // y (1 + sum c (1 - b)) = muscle + sum c (1 - b) slow, b the share that a low-pass takes up in this step.
        let (mut over, mut under) = (muscle, 1.0);
        let shares: Vec<f64> = creep.iter().map(|(_, tau_s)| -(-step_s / tau_s).exp_m1()).collect();
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

/// What a free run remembers.
struct State {
    walk: super::basis::Walk,
    /// Stops of the widths, one an effect, and the input they last saw.
    stops: Vec<f64>,
    last_input: f64,
    motion: Motion,
    travel: f64,
}

impl State {
    fn new(basis: &Basis, effects: &[Effect], input: f64, contraction: f64) -> Self {
        Self {
            walk: basis.walk(input, bend(effects)),
            stops: vec![0.0; effects.len()],
            last_input: input,
            motion: Motion { place: contraction, rate: 0.0, acceleration: 0.0 },
            travel: 0.0,
        }
    }

    /// One row: its place, the pressure, its speed and the time since the row before. Returns the muscle's contraction.
    fn step(
        &mut self,
        signals: &Signals,
        basis: &Basis,
        effects: &[Effect],
        weights: &[f64],
        (at, pressure, input_speed, step_s): (usize, f64, f64, f64),
    ) -> f64 {
        let (mut wanted, mut viscosity, mut mass) = (pressure, 0.0, 0.0);
        for effect in effects {
            let parameters = &effect.parameters;
            match effect.form {
                Form::Driven(Driver::Rate) => viscosity += strength(signals, parameters, at),
                Form::Driven(Driver::WarmUp) => {
                    let settled = (-self.travel / parameters[0].value.exp()).exp();
                    wanted -= strength(signals, &parameters[1..], at) * settled;
                }
                Form::Driven(driver) => {
                    wanted -= strength(signals, parameters, at) * output::driven(signals, driver, 1.0, at);
                }
                Form::Inertia => {
                    mass += strength(signals, &parameters[..TENTS], at);
                    viscosity += strength(signals, &parameters[TENTS..], at);
                }
                _ => {}
            }
        }
        let widening = effects.iter().find_map(|effect| match effect.form {
            Form::Thresholds(rate) => Some((effect, rate)),
            _ => None,
        });
        let follows = widening.is_some_and(|(_, rate)| rate == Rate::Contraction);
        let wider_at = |speed: f64| {
            let speed = if follows { speed } else { input_speed };
            widening.map_or(1.0, |(effect, rate)| wider(signals, effect, rate, speed))
        };
        // Thresholds that follow the speed of the contraction: the more it moves the less it moves, one root.
        let answer = |u: f64| {
            let of_wider = |wider: f64| basis.step(&mut self.walk.clone(), u, wider).sum(weights);
            if !follows || step_s <= 0.0 {
                return of_wider(wider_at(0.0));
            }
            root(self.motion.place, |y| y - of_wider(wider_at((y - self.motion.place) / step_s)))
        };
        let balance = |u: f64| {
            let y = answer(u);
            let Motion { rate, acceleration, .. } = self.motion.to(y, step_s, mass > 0.0);
            let wider = wider_at(rate);
            let width: f64 = effects
                .iter()
                .zip(&self.stops)
                .filter_map(|(effect, stop)| {
                    let friction = Friction::of(signals, effect, at, wider, rate)?;
                    let range = friction.range;
                    Some(friction.slope * (stop + u - self.last_input).clamp(-range, range))
                })
                .sum();
            (u + width + viscosity * rate + mass * acceleration - wanted, y)
        };
        let u = root(self.last_input, |u| balance(u).0);
        let (_, y) = balance(u);
        let rate = self.motion.to(y, step_s, mass > 0.0).rate;
        let wider = wider_at(rate);
        basis.step(&mut self.walk, u, wider);
        for (effect, stop) in effects.iter().zip(&mut self.stops) {
            if let Some(friction) = Friction::of(signals, effect, at, wider, rate) {
                *stop = (*stop + u - self.last_input).clamp(-friction.range, friction.range);
            }
        }
        self.travel += if at == 0 { 0.0 } else { (y - self.motion.place).abs() };
        self.last_input = u;
        self.motion = self.motion.to(y, step_s, mass > 0.0);
        y
    }
}

/// A place, and how it moves.
#[derive(Clone, Copy)]
struct Motion {
    place: f64,
    rate: f64,
    acceleration: f64,
}

impl Motion {
    /// The motion that ends at `place` after a step: by Newmark's rule where there is a mass, else by the difference.
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

    /// Goes on to where place + damping rate + mass acceleration = goal; returns the place.
    fn follow(&mut self, goal: f64, step_s: f64, (mass, damping): (f64, f64)) -> f64 {
        if (mass, damping) == (0.0, 0.0) || step_s <= 0.0 {
            *self = Self { place: goal, rate: 0.0, acceleration: 0.0 };
            return goal;
        }
        // Both are linear in the place: two points of it give the root.
        let miss = |place: f64| {
            let moved = self.to(place, step_s, mass > 0.0);
            place + damping * moved.rate + mass * moved.acceleration - goal
        };
        let (at_zero, at_one) = (miss(0.0), miss(1.0));
        *self = self.to(-at_zero / (at_one - at_zero), step_s, mass > 0.0);
        self.place
    }
}

/// The root of a function that rises, near `start`: a bracket by doubling, then the Illinois method.
fn root(start: f64, f: impl Fn(f64) -> f64) -> f64 {
    let mut left = (start, f(start));
    if left.1 == 0.0 {
        return start;
    }
    let toward = -left.1.signum();
    let mut width = left.1.abs().clamp(1e-9, 1.0);
    let mut right = left;
    let mut evaluations = 0;
    while right.1.signum() == left.1.signum() && evaluations < EVALUATIONS {
        left = right;
        right = (left.0 + toward * width, 0.0);
        right.1 = f(right.0);
        width *= 2.0;
        evaluations += 1;
    }
    while evaluations < EVALUATIONS && (right.0 - left.0).abs() > 1e-7 {
        let next = (left.0 * right.1 - right.0 * left.1) / (right.1 - left.1);
        let value = f(next);
        evaluations += 1;
        if value.abs() < 1e-7 {
            return next;
        }
        if value.signum() == right.1.signum() {
            left.1 *= 0.5;
        } else {
            left = right;
        }
        right = (next, value);
    }
    right.0
}
