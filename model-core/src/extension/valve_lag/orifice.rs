//! Air through an orifice, as ISO 6358 has it, into a chamber that does not grow: where the flow
//! is sonic the pressure goes as fast as the pressure before the orifice says, else as the ellipse
//! of the standard. The regulator opens in proportion to what is missing, so that the lag has
//! another time constant at every pressure: short where much flows, long near the supply and near
//! the atmosphere.
//!
//! The inverse leads by the time constant that the valve has where it stands, in the direction
//! that is asked for: exact within a step of time that is calculated in one part.
//!
//! # Limits
//! The valve never opens wide: with that a large step takes longer. One ratio of sonic flow is
//! taken for all valves.

use crate::real::Real;

/// The ratio of the pressures on both sides up to which the flow is sonic. ISO 6358 calls it b;
/// valves have 0.2 to 0.5. A choice in that range, for lack of the very valve's. Unit: 1.
const CRITICAL: f64 = 0.3;
/// The flow changes with the pressure inside, so it is calculated again after at most this time
/// within a step, in at most so many parts: choices. With a lag of 0.3 s, steps of 50 ms then end
/// within 0.01 bar of steps of 1 ms (a test holds them to that). Units: s, 1.
const PART_S: f64 = 0.01;
const PARTS: f64 = 8.0;

/// What a step of time makes of it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct OrificeStep<T> {
    /// Absolute pressures before the orifice and outside. Input unit.
    supply: T,
    outside: T,
    /// What a part of the step is in time constants, for each unit of flow, and how many parts
    /// there are.
    per_flow: T,
    parts: u8,
}

impl<T: Real> OrificeStep<T> {
    /// `time_constant_s`: where it fills at half of the supply. `dt`: s.
    pub(super) fn new(time_constant_s: T, (supply, outside): (T, T), dt: T) -> Self {
        let parts = (dt.to_f64() / PART_S).clamp(1.0, PARTS);
        let parts = libm::ceil(parts) as u8;
        let step = Self { supply, outside, per_flow: T::ONE, parts };
        let at_half = step.flow(T::from_f64(0.5) * supply, true).to_f64();
        let part_s = dt.to_f64() / f64::from(parts);
        Self { per_flow: T::from_f64(part_s / (time_constant_s.to_f64() * at_half)), ..step }
    }

    /// The pressure after the step.
    #[inline(always)]
    pub(super) fn pressure(&self, from: T, set_point: T) -> T {
        let mut pressure = from;
        for _ in 0..self.parts {
            let missing = set_point - pressure;
            pressure = pressure + missing * self.share(pressure, missing > T::ZERO, T::ONE);
        }
        pressure
    }

    /// The set point that leads to the wanted pressure, at most `lead_limit` from where it stands.
    #[inline(always)]
    pub(super) fn set_point(&self, from: T, wanted: T, lead_limit: T) -> T {
        let missing = wanted - from;
        let parts = T::from_f64(f64::from(self.parts));
        // Where next to nothing flows the limit is what counts.
        let share = self.share(from, missing > T::ZERO, parts).at_least(T::EPSILON);
        from + (missing / share).limit(-lead_limit, lead_limit)
    }

    /// The share of its way that the pressure goes in so many parts.
    #[inline(always)]
    fn share(&self, pressure: T, fills: bool, parts: T) -> T {
        T::ONE - (-(self.per_flow * parts * self.flow(pressure + self.outside, fills))).exp()
    }

    /// What flows in or out of the chamber with this absolute pressure, wide open. Input unit.
    #[inline(always)]
    fn flow(&self, inside: T, fills: bool) -> T {
        let inside = inside.at_least(T::EPSILON * self.supply);
        let (from, to) = if fills { (self.supply, inside) } else { (inside, self.outside) };
        let critical = T::from_f64(CRITICAL);
        let over = ((to / from - critical) / (T::ONE - critical)).limit(T::ZERO, T::ONE);
        from * (T::ONE - over * over).sqrt()
    }
}
