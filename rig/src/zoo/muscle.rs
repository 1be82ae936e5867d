//! A muscle of the zoo: a force law, a friction, a passive spring and a load in balance.
//!
//! ```text
//! full force * law(p, e) - spring * e - friction(e) - load - damper * e' - mass * e'' = 0
//! ```
//!
//! Every term falls with the contraction ratio `e`, so there is one root at every step. Time
//! constants and frequencies of effects hold at mid stroke of the frictionless muscle. Mass and
//! damper are stepped as in the rig's own muscle.

use std::f64::consts::TAU;

use super::friction::{Friction, Resist};
use super::law::{FULL_BAR, Law, Pull};
use super::site::{Retarded, Sites, Stiffness, Viscous};
use crate::body::Body;
use crate::creep::Creep;
use crate::draw::Draw;
use crate::dynamics::{Dynamics, Motion, Step};
use crate::effects::{Effects, Temperature, ViscousLag, WarmUp};
use crate::sensitivity::{Sensitivities, Sensitivity};
use crate::surroundings::{REFERENCE_TEMPERATURE_C, Surroundings};

/// Passive stiffness that temperature and warm-up act on, as a share of the full force.
const PASSIVE: f64 = 0.6;

/// Time constant of the speed that widens a play, s.
const SPEED_TIME_CONSTANT_S: f64 = 0.01;

/// What pulls at the muscle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Load {
    /// A weight.
    Weight,
    /// A spring.
    Spring,
    /// Both.
    Both,
}

impl Load {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Weight, Self::Spring, Self::Both];

    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Weight => "weight",
            Self::Spring => "spring",
            Self::Both => "weight and spring",
        }
    }
}

/// Size of a muscle and what it hangs between.
#[derive(Debug, Clone, Copy)]
pub struct Size {
    /// Length at rest, mm.
    pub length_mm: f64,
    /// Force at 6 bar and no contraction, N.
    pub full_n: f64,
    /// Stiffness of skin and load, N per unit of contraction ratio.
    pub spring_n: f64,
    /// Weight, N.
    pub weight_n: f64,
    /// Friction as a share of the full force.
    pub friction: f64,
}

impl Size {
    pub(crate) fn drawn(draw: &mut Draw, load: Load) -> Self {
        let (length_mm, full_n) = (draw.log_uniform(80.0, 800.0), draw.log_uniform(300.0, 4000.0));
        let (skin, spring, weight) =
            (draw.uniform(0.35, 0.7), draw.uniform(0.1, 0.8), draw.uniform(0.003, 0.025));
        let (spring, weight) = match load {
            Load::Weight => (0.0, weight),
            Load::Spring => (spring, 0.0),
            Load::Both => (spring, weight),
        };
        Self {
            length_mm,
            full_n,
            spring_n: full_n * (skin + spring),
            weight_n: full_n * weight,
            friction: draw.log_uniform(0.012, 0.05),
        }
    }
}

/// A muscle with its memory.
pub struct Muscle {
    law: Box<dyn Pull>,
    friction: Box<dyn Resist>,
    size: Size,
    sites: Sites,
    stiffness_n: f64,
    stroke: f64,
    dynamics: Dynamics,
    motion: Motion,
    temperature: Option<Temperature>,
    warm_up: Option<WarmUp>,
    creep: Option<Creep>,
    late: f64,
    lagging: Option<(ViscousLag, f64)>,
    travel_mm: f64,
    /// Of the contraction ratio, as friction knows it: a moment late.
    speed_per_s: f64,
}

impl Muscle {
    /// A muscle at rest without pressure.
    pub(crate) fn at_rest(
        (law, friction): (Law, Friction),
        size: Size,
        sites: Sites,
        draw: &mut Draw,
        of: impl FnOnce(f64) -> Effects,
    ) -> Self {
        let law = law.drawn(draw);
        let [rest, end] = [0.0, FULL_BAR].map(|bar| static_ratio(law.as_ref(), &size, bar, 0.0));
        let effects = of((end - rest) * size.length_mm);
        let friction = friction.drawn(draw, rest, size.friction, size.full_n);
        let stiffness_n = mid_stiffness_n(law.as_ref(), &size, 0.5 * (rest + end));
        let at_length = effects.viscous_lag.clone().filter(|_| sites.viscous == Viscous::Length);
        let start = if sites.creep == Retarded::Pressure { 0.0 } else { rest };
        Self {
            law,
            friction,
            size,
            sites,
            stiffness_n,
            stroke: end - rest,
            dynamics: dynamics(stiffness_n, &effects, sites.viscous),
            motion: Motion::resting(rest),
            temperature: effects.temperature.clone(),
            warm_up: effects.warm_up.clone(),
            creep: effects.creep.as_ref().map(|creep| Creep::new(creep, start)),
            late: 0.0,
            lagging: at_length.map(|lag| (lag, rest)),
            travel_mm: 0.0,
            speed_per_s: 0.0,
        }
    }

    /// Contraction at 6 bar without friction, beyond that at 0 bar, mm.
    pub fn stroke_mm(&self) -> f64 {
        self.stroke * self.size.length_mm
    }

    /// What drives the muscle at `ratio` less what resists, N.
    fn surplus_n(&self, ratio: f64, at: &At, step: &Step) -> f64 {
        let limits_n = step.limits_n(at.slow_n, ratio);
        at.pull * self.size.full_n * self.law.pull(at.felt_bar, ratio)
            - (self.size.spring_n + at.spring_n) * ratio
            - at.load_n
            - step.stiffness_n * (ratio - step.free_ratio)
            - self.friction.resistance_n(ratio, &limits_n)
    }
}

/// What acts during a step.
struct At {
    felt_bar: f64,
    pull: f64,
    spring_n: f64,
    load_n: f64,
    slow_n: f64,
}

impl Body for Muscle {
    fn step(&mut self, pressure_bar: f64, surroundings: &Surroundings, dt_s: f64) -> f64 {
        let Sites { creep: retarded, temperature: warm, warm_up: worked, .. } = self.sites;
        let mut inside_bar = pressure_bar;
        if let Some(creep) = self.creep.as_mut().filter(|_| retarded == Retarded::Pressure) {
            inside_bar = creep.step(inside_bar, dt_s);
        }
        let step = self.dynamics.step(&self.motion, dt_s);
        let widened =
            surroundings.friction * step.limits_n(1.0, self.motion.ratio + self.speed_per_s * dt_s).widest();
        let nominal_n = self.size.friction * self.size.full_n * surroundings.friction;
        let warmer_k = surroundings.temperature_c - REFERENCE_TEMPERATURE_C;
        let softer = self.temperature.as_ref().map_or(0.0, |hidden| hidden.softening_per_k * warmer_k);
        let stiffer = self
            .warm_up
            .as_ref()
            .map_or(0.0, |hidden| hidden.fraction * (-self.travel_mm / hidden.travel_mm).exp());
        let of = |site: Stiffness| {
            let share = |acts: Stiffness, amount: f64| if acts == site { amount } else { 0.0 };
            share(worked, stiffer) - share(warm, softer)
        };
        let relaxing_n = if retarded == Retarded::Force { self.stiffness_n * self.late } else { 0.0 };
        let at = At {
            felt_bar: self.friction.felt_bar(inside_bar, widened),
            // A pull does at mid stroke what the spring does.
            pull: 1.0 - 0.5 * PASSIVE * of(Stiffness::Pull),
            spring_n: PASSIVE * self.size.full_n * of(Stiffness::Spring),
            load_n: surroundings.load_n + relaxing_n,
            slow_n: nominal_n * self.friction.level(pressure_bar),
        };
        let before = self.motion.ratio;
        let ratio = root(before, |ratio| self.surplus_n(ratio, &at, &step));
        self.friction.settle(ratio, &step.limits_n(at.slow_n, ratio));
        self.motion = step.arrive(ratio);
        let speed_per_s = (ratio - before) / dt_s;
        self.speed_per_s += (speed_per_s - self.speed_per_s) * -(-dt_s / SPEED_TIME_CONSTANT_S).exp_m1();
        self.travel_mm += (ratio - before).abs() * self.size.length_mm;
        let mut out = ratio;
        if let Some(creep) = self.creep.as_mut().filter(|_| retarded != Retarded::Pressure) {
            let there = creep.step(ratio, dt_s);
            self.late = ratio - there;
            if retarded == Retarded::Length {
                out = there;
            }
        }
        if let Some((lag, behind)) = &mut self.lagging {
            *behind += (out - *behind) * -(-dt_s / lag.time_constant_s).exp_m1();
            out = *behind;
        }
        let expansion_mm =
            self.temperature.as_ref().map_or(0.0, |hidden| hidden.expansion_mm_per_k * warmer_k);
        out * self.size.length_mm + expansion_mm
    }

    fn sensitivities(&self) -> Sensitivities {
        let (law, size) = (self.law.as_ref(), &self.size);
        let more_n = 1e-3 * size.full_n;
        let points = (4..=24).map(|quarters_bar| {
            let bar = 0.25 * f64::from(quarters_bar);
            let [ratio, loaded] = [0.0, more_n].map(|load_n| static_ratio(law, size, bar, load_n));
            (ratio * size.length_mm, (loaded - ratio) * size.length_mm / more_n)
        });
        Sensitivities { per_n: Sensitivity::fitted(points), per_k: None, lacking: None }
    }
}

/// The forces of motion of `effects`, at a stiffness in N per unit of contraction ratio.
fn dynamics(stiffness_n: f64, effects: &Effects, viscous: Viscous) -> Dynamics {
    let mut dynamics = Dynamics::default();
    if let Some(lag) = effects.viscous_lag.as_ref().filter(|_| viscous == Viscous::Force) {
        dynamics.viscosity_n_s += stiffness_n * lag.time_constant_s;
    }
    if let Some(inertia) = &effects.inertia {
        let natural_per_s = TAU * inertia.natural_frequency_hz;
        dynamics.mass_n_s2 = stiffness_n / (natural_per_s * natural_per_s);
        dynamics.viscosity_n_s += 2.0 * inertia.damping_ratio * stiffness_n / natural_per_s;
    }
    if let Some(width) = &effects.rate_dependent_width {
        (dynamics.width_gain, dynamics.rate_exponent) = (width.width_gain, width.rate_exponent);
    }
    dynamics
}

/// Surplus of force without friction, N.
fn static_n(law: &dyn Pull, size: &Size, bar: f64, ratio: f64) -> f64 {
    size.full_n * law.pull(bar, ratio) - size.spring_n * ratio - size.weight_n
}

/// Where the forces balance without friction under a further load.
fn static_ratio(law: &dyn Pull, size: &Size, bar: f64, load_n: f64) -> f64 {
    root(0.0, |ratio| static_n(law, size, bar, ratio) - load_n)
}

/// Stiffness without friction at a contraction ratio, at the pressure that holds it, N per unit of
/// ratio.
fn mid_stiffness_n(law: &dyn Pull, size: &Size, ratio: f64) -> f64 {
    let bar = -root(0.0, |below| static_n(law, size, (-below).max(0.0), ratio) + 1e-9 * below.min(0.0));
    let h = 1e-4;
    (static_n(law, size, bar, ratio - h) - static_n(law, size, bar, ratio + h)) / (2.0 * h)
}

/// Smallest step from a guess towards a root, and the tolerance, as contraction ratios.
const FIRST_STEP: f64 = 2e-5;
const TOLERANCE: f64 = 1e-10;

/// The root of a falling function near `start`: brackets of growing width, then the Illinois
/// method.
fn root(start: f64, falling: impl Fn(f64) -> f64) -> f64 {
    let (mut a, mut value_a) = (start, falling(start));
    if value_a == 0.0 {
        return a;
    }
    let mut width = FIRST_STEP * value_a.signum();
    let (mut b, mut value_b) = (a + width, falling(a + width));
    while value_b * value_a > 0.0 {
        width *= 4.0;
        if width.abs() > 100.0 {
            return b;
        }
        (a, value_a) = (b, value_b);
        b = start + width;
        value_b = falling(b);
    }
    for _ in 0..100 {
        if (b - a).abs() <= TOLERANCE || value_b == 0.0 {
            break;
        }
        let next = b - value_b * (b - a) / (value_b - value_a);
        let value = falling(next);
        if value * value_b < 0.0 {
            (a, value_a) = (b, value_b);
        } else {
            value_a *= 0.5;
        }
        let moved = (next - b).abs();
        (b, value_b) = (next, value);
        if moved <= TOLERANCE {
            break;
        }
    }
    b
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::Stream;
    use crate::zoo::family::Family;

    /// Muscles of every family.
    fn muscles() -> impl Iterator<Item = (Family, u64, Muscle, Size)> {
        Family::all().flat_map(|family| (0..4).map(move |seed| (family, seed))).map(|(family, seed)| {
            let mut draw = Draw::new(seed, Stream::Protocol);
            let size = Size::drawn(&mut draw, Load::ALL[seed as usize % 3]);
            let sites = Sites::drawn(&mut draw);
            let none = |_| Effects::default();
            let muscle = Muscle::at_rest((family.law, family.friction), size, sites, &mut draw, none);
            (family, seed, muscle, size)
        })
    }

    fn still(size: &Size) -> Surroundings {
        Surroundings {
            load_n: size.weight_n,
            recorded_load_n: size.weight_n,
            temperature_c: REFERENCE_TEMPERATURE_C,
            friction: 1.0,
        }
    }

    #[test]
    fn muscles_contract_with_pressure_by_a_plausible_stroke_and_their_loops_are_as_wide_as_friction_makes_them()
     {
        for (family, seed, mut muscle, size) in muscles() {
            let mut cycle = |steps: std::ops::RangeInclusive<i32>, is_rising: bool| -> Vec<f64> {
                let count = *steps.end();
                let bars = steps.map(|step| if is_rising { step } else { count - step });
                bars.map(|step| {
                    muscle.step(FULL_BAR * f64::from(step) / f64::from(count), &still(&size), 0.1)
                })
                .collect()
            };
            // The first stroke is another one.
            drop((cycle(0..=200, true), cycle(0..=200, false)));
            let (up, down) = (cycle(0..=200, true), cycle(0..=200, false));
            assert!(up.is_sorted_by(|a, b| *b >= a - 1e-6), "{family:?} {seed} does not rise");
            assert!(down.is_sorted_by(|a, b| *b <= a + 1e-6), "{family:?} {seed} does not fall");
            let stroke_mm = up[200] - up[0];
            let share = stroke_mm / size.length_mm;
            assert!((0.08..0.35).contains(&share), "{family:?} {seed}: {share} of the length");
            let width: f64 =
                up.iter().rev().zip(&down).map(|(up, down)| (down - up) / stroke_mm / 200.0).sum();
            assert!((0.003..0.3).contains(&width), "{family:?} {seed}: {width} of the stroke");
        }
    }

    #[test]
    fn friction_gives_back_less_than_it_took_over_closed_paths() {
        for (family, seed) in Family::all().flat_map(|family| (0..6).map(move |seed| (family, seed))) {
            let mut draw = Draw::new(seed, Stream::Protocol);
            let mut friction = family.friction.drawn(&mut draw, 0.0, 0.03, 1000.0);
            let limits_n =
                crate::dynamics::Dynamics::default().step(&Motion::resting(0.0), 1.0).limits_n(30.0, 0.0);
            let turns: Vec<f64> = (0..6).map(|_| draw.uniform(0.0, 0.2)).chain([0.0]).collect();
            let mut work = [0.0, 0.0];
            for of_cycle in &mut work {
                let mut at = 0.0;
                for turn in &turns {
                    for _ in 0..400 {
                        let next = at + (turn - at) * 0.05;
                        *of_cycle += friction.resistance_n(next, &limits_n) * (next - at);
                        friction.settle(next, &limits_n);
                        at = next;
                    }
                }
            }
            // The second cycle begins as it ends.
            assert!(work[1] >= -1e-9, "{family:?} {seed}: {work:?}");
        }
    }

    #[test]
    fn a_mass_without_anything_that_drives_it_comes_to_rest() {
        for (family, seed, _, size) in muscles() {
            let mut draw = Draw::new(seed, Stream::Protocol);
            let inertia = Some(crate::effects::Inertia { natural_frequency_hz: 4.0, damping_ratio: 0.2 });
            let effects = Effects { inertia, ..Effects::default() };
            let sites = Sites::drawn(&mut draw);
            let mut muscle =
                Muscle::at_rest((family.law, family.friction), size, sites, &mut draw, |_| effects);
            let swing = |muscle: &mut Muscle| {
                let course: Vec<_> = (0..1000).map(|_| muscle.step(4.0, &still(&size), 1e-3)).collect();
                let (low, high) =
                    course.iter().fold((f64::MAX, f64::MIN), |(l, h), y| (l.min(*y), h.max(*y)));
                high - low
            };
            let swings = [(); 4].map(|()| swing(&mut muscle));
            assert!(swings[0] > 0.05 * size.length_mm, "{family:?} {seed}: {swings:?}");
            assert!(swings[3] < 0.01 * swings[0], "{family:?} {seed}: {swings:?}");
        }
    }
}
