//! The effects on the balance of forces, as an equivalent input: what pressure they take from the
//! operator. And the same behind it: what contraction.
//!
//! pressure = u + Σ hᵢ(y) dᵢ, with u the operator's input, y its output, hᵢ the profile of an
//! effect and dᵢ what drives it. Before y is known a driver is constant + gain * (how far y moves):
//! one form, [`Term`], for what is measured (load, temperature), remembered (travel) and
//! differentiated (velocity, acceleration). Only the rate-dependent width depends on u itself.
//!
//! Model and inverse use the same [`Present`]: the inverse knows u and y and adds, the model
//! searches the u for which the sum is the pressure. Behind the operator its output takes the place
//! of the pressure, and the contraction y that of u.

use crate::error::ParameterError;
use crate::real::Real;

use super::derivative::{Affine, Derivative, Stencil};
use super::inertia::Inertia;
use super::rate_dependent_width::{RateDependentWidth, Width, WidthMemory};
use super::root::{Point, root};
use super::schedule::Schedule;
use super::sliding::SlidingStep;
use super::sum::Sum;
use super::term::Term;
use super::viscous_lag::ViscousLag;
use super::warm_up::WarmUp;
use super::{ExtensionParameters, Site, Sites, Surroundings, each};

/// The validated effects.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Balance<T> {
    load: Option<Schedule<T>>,
    temperature: Option<Schedule<T>>,
    warm_up: Option<WarmUp<T>>,
    viscous_lag: Option<ViscousLag<T>>,
    inertia: Option<Inertia<T>>,
    rate_dependent_width: Option<RateDependentWidth<T>>,
}

/// What a step of time makes of them.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct BalanceStep<T> {
    stencil: Stencil<T>,
    width: Option<SlidingStep<T>>,
}

/// What they remember.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct BalanceMemory<T> {
    velocity: Derivative<T>,
    acceleration: Derivative<T>,
    travel: Sum<T>,
    width: WidthMemory<T>,
}

/// The effects at a sample.
#[derive(Debug)]
pub(super) struct Present<'a, T> {
    terms: [Option<Term<'a, T>>; 5],
    width: Option<Width<'a, T>>,
    velocity: Affine<T>,
    acceleration: Affine<T>,
    step: &'a BalanceStep<T>,
    memory: &'a BalanceMemory<T>,
}

impl<T: Real> Balance<T> {
    /// Those at a site; None without effects.
    pub(super) fn try_new(
        parameters: &ExtensionParameters<T>,
        site: Site,
    ) -> Result<Option<Self>, ParameterError> {
        let Sites { load, temperature, warm_up, viscous_lag, inertia, .. } = parameters.sites;
        let schedule = |name| move |schedule: &_| Schedule::try_new(schedule, name);
        let balance = Self {
            load: here(load == site, &parameters.load, schedule("load"))?,
            temperature: here(temperature == site, &parameters.temperature, schedule("temperature"))?,
            warm_up: here(warm_up == site, &parameters.warm_up, WarmUp::try_new)?,
            viscous_lag: here(viscous_lag == site, &parameters.viscous_lag, ViscousLag::try_new)?,
            inertia: here(inertia == site, &parameters.inertia, Inertia::try_new)?,
            rate_dependent_width: here(
                site == Site::Pressure,
                &parameters.rate_dependent_width,
                RateDependentWidth::try_new,
            )?,
        };
        let none = Self {
            load: None,
            temperature: None,
            warm_up: None,
            viscous_lag: None,
            inertia: None,
            rate_dependent_width: None,
        };
        Ok((balance != none).then_some(balance))
    }

    /// Whether one of them is a width that depends on the rate.
    pub(super) fn widens(&self) -> bool {
        self.rate_dependent_width.is_some()
    }

    /// For a step of `dt` after one of `before`.
    pub(super) fn step(&self, dt: T, before: T) -> BalanceStep<T> {
        BalanceStep { stencil: Stencil::new(dt, before), ..self.step_after_rest(dt) }
    }

    /// For the first sample of a muscle that has stood still.
    pub(super) fn first(&self) -> BalanceStep<T> {
        self.step_after_rest(T::INFINITY)
    }

    fn step_after_rest(&self, dt: T) -> BalanceStep<T> {
        let width = self.rate_dependent_width.as_ref().map(|width| width.step(dt));
        BalanceStep { stencil: Stencil::resting(), width }
    }

    /// What they remember where the operator has long stood at the input `u`.
    pub(super) fn resting(u: T) -> BalanceMemory<T> {
        BalanceMemory {
            velocity: Derivative::resting(),
            acceleration: Derivative::resting(),
            travel: Sum::default(),
            width: WidthMemory::resting(u),
        }
    }

    /// The effects at the next sample.
    #[inline(always)]
    pub(super) fn at<'a>(
        &'a self,
        step: &'a BalanceStep<T>,
        memory: &'a BalanceMemory<T>,
        surroundings: &Surroundings<T>,
    ) -> Present<'a, T> {
        let velocity = memory.velocity.rate(&step.stencil, &Affine::identity());
        let acceleration = memory.acceleration.rate(&step.stencil, &memory.velocity.moves(&velocity));
        let terms = [
            self.load.as_ref().zip(surroundings.load).map(|(load, measured)| load.term(measured)),
            self.temperature.as_ref().zip(surroundings.temperature).map(|(schedule, at)| schedule.term(at)),
            self.warm_up.as_ref().map(|warm_up| warm_up.term(memory.travel.value())),
            self.viscous_lag.as_ref().map(|viscosity| viscosity.term(velocity)),
            self.inertia.as_ref().map(|inertia| inertia.term(acceleration)),
        ];
        let width = self.rate_dependent_width.as_ref().zip(step.width.as_ref());
        let width = width.map(|(width, step)| width.at(step, &memory.width));
        Present { terms, width, velocity, acceleration, step, memory }
    }
}

/// What becomes of the parameters of an effect, if it is there and here.
fn here<P, Q>(
    is_here: bool,
    parameters: &Option<P>,
    become_of: impl Fn(&P) -> Result<Q, ParameterError>,
) -> Result<Option<Q>, ParameterError> {
    if is_here { each(parameters, become_of) } else { Ok(None) }
}

impl<T: Real> Present<'_, T> {
    /// What they take, where the operator's input has moved by `pushed` to `u` and its output by
    /// `moved` to `y`. Input unit.
    #[inline(always)]
    pub(super) fn value(&self, (u, pushed): (T, T), (y, moved): (T, T)) -> T {
        let mut sum = self.terms((y, moved));
        if let Some(width) = &self.width {
            sum += width.value(u, pushed, y);
        }
        sum
    }

    /// As above, for the terms that do not depend on the operator's input.
    #[inline(always)]
    fn terms(&self, (y, moved): (T, T)) -> T {
        let of = |term: &Option<Term<'_, T>>| match term {
            Some(term) => term.profile.value(y) * term.driver.at(moved),
            None => T::ZERO,
        };
        // Written out: a loop would need all terms in memory.
        let [load, temperature, warm_up, viscous_lag, inertia] = &self.terms;
        of(load) + of(temperature) + of(warm_up) + of(viscous_lag) + of(inertia)
    }

    /// The operator's input that they leave of a pressure, where it was `u0` and its output has
    /// moved by `moved` to `y`: to `tolerance` where it takes a search. Input unit.
    pub(super) fn rest(&self, pressure: T, u0: T, (y, moved): (T, T), tolerance: T) -> T {
        let free = pressure - self.terms((y, moved));
        let Some(width) = &self.width else { return free };
        let over = |u| u + width.value(u, u - u0, y) - free;
        let f = over(u0);
        if f.abs() <= tolerance { u0 } else { root(Point { u: u0, f }, T::ONE, tolerance, over).0 }
    }

    /// What they remember after that move.
    #[inline(always)]
    pub(super) fn remembered(&self, (u, pushed): (T, T), moved: T) -> BalanceMemory<T> {
        let BalanceMemory { mut velocity, mut acceleration, mut travel, mut width } = *self.memory;
        let stencil = &self.step.stencil;
        let accelerated = velocity.keep(stencil, moved, self.velocity.at(moved));
        acceleration.keep(stencil, accelerated, self.acceleration.at(moved));
        if stencil.is_moving() {
            travel.add(moved.abs());
        }
        if let Some(effect) = &self.width {
            width = effect.moved(u, pushed);
        }
        BalanceMemory { velocity, acceleration, travel, width }
    }
}
