//! The lag of air that flows through an orifice, opened in proportion to the error (ISO 6358, isothermal).
//!
//! What flows is in proportion to the pressure on the side that it comes from, and less where the other side is near it: such a valve is
//! slow near its supply, and when it vents a low pressure; a lag of one time constant is off by tenths of a bar there.
//!
//! # Limits
//! The chamber does not grow, and the valve never opens wide: with both, a large step takes longer. One ratio of sonic flow is taken for all
//! valves; those of the rig have the same, so it fits them better than it may fit others.

/// The ratio of the pressures on both sides up to which the flow is sonic. ISO 6358 calls it b; valves have 0.2 to 0.5.
const CRITICAL: f64 = 0.3;
/// The flow changes with the pressure inside, so it is calculated anew after at most this time within a row, in at most so many parts.
/// Unit: s; parts.
const SUBSTEP_S: f64 = 0.01;
const SUBSTEPS: f64 = 8.0;

/// The absolute pressures on either side. Unit of the pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orifice {
    /// Before it.
    pub supply: f64,
    /// Where it vents to.
    pub outside: f64,
}

impl Orifice {
    /// The pressure that follows these values from the `start` on; `lag_s`: its time constant while it fills at half of the supply.
    pub fn follow(&self, start: f64, values: &[f64], time_s: &[f64], lag_s: f64) -> Vec<f64> {
        let per_s = 1.0 / (lag_s * self.flow(0.5 * self.supply, true));
        let mut state = start;
        let mut last_s = time_s.first().copied().unwrap_or(0.0);
        values
            .iter()
            .zip(time_s)
            .map(|(value, &time_s)| {
                let parts = ((time_s - last_s) / SUBSTEP_S).ceil().clamp(1.0, SUBSTEPS);
                let part_s = (time_s - last_s) / parts;
                last_s = time_s;
                for _ in 0..parts as usize {
                    let error = value - state;
                    let rate = per_s * self.flow(state + self.outside, error > 0.0);
                    state -= error * (-rate * part_s).exp_m1();
                }
                state
            })
            .collect()
    }

    /// What flows in or out, wide open.
    fn flow(&self, inside: f64, fills: bool) -> f64 {
        let (from, to) = if fills { (self.supply, inside) } else { (inside, self.outside) };
        let over = ((to / from - CRITICAL) / (1.0 - CRITICAL)).clamp(0.0, 1.0);
        from.max(0.0) * (1.0 - over * over).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ORIFICE: Orifice = Orifice { supply: 8.0, outside: 1.0 };

    /// How much of a step is left behind a time constant.
    fn left(from: f64, to: f64) -> f64 {
        let time_s: Vec<f64> = (0..=100).map(|row| 0.001 * f64::from(row)).collect();
        let values: Vec<f64> = time_s.iter().map(|time_s| if *time_s > 0.0 { to } else { from }).collect();
        let last = *ORIFICE.follow(from, &values, &time_s, 0.1).last().expect("rows");
        (last - to) / (from - to)
    }

    #[test]
    fn it_is_as_slow_as_its_lag_where_it_fills_at_half_of_the_supply_and_slower_near_either_end() {
        let e = (-1.0_f64).exp();
        assert!((left(2.9, 3.1) - e).abs() < 0.01, "{}", left(2.9, 3.1));
        // Near the supply half as much flows, and of 1.5 bar against 1 a sixth.
        assert!((left(6.1, 6.3) - (-0.55_f64).exp()).abs() < 0.03, "{}", left(6.1, 6.3));
        assert!((left(0.6, 0.4) - (-0.17_f64).exp()).abs() < 0.03, "{}", left(0.6, 0.4));
    }

    #[test]
    fn rows_far_apart_lead_to_the_same_as_near_ones() {
        let at = |step_s: f64| {
            let time_s: Vec<f64> = (0..=(1.0 / step_s) as usize).map(|row| row as f64 * step_s).collect();
            let values: Vec<f64> =
                time_s.iter().map(|time_s| if *time_s > 0.0 { 5.0 } else { 0.5 }).collect();
            ORIFICE.follow(0.5, &values, &time_s, 0.3).pop().expect("rows")
        };
        assert!((at(0.05) - at(0.001)).abs() < 0.01, "{} {}", at(0.05), at(0.001));
    }
}
