//! The physical parameters of the rig, each with its unit and where it comes from.
//!
//! The muscle is a Festo DMSP-20-500N on a proportional pressure regulator VPPM-6L, as in the
//! paper's experiment. "Data sheet" is the maker's. "Loop" means: chosen so that the major
//! pressure-contraction loop runs near the published one (rising/falling 16.8/31.1, 56.9/74.4,
//! 89.0/100.6, 105.9/113.7 and 117.1/120.6 mm at 1 to 5 bar, 123.8 mm at 6 bar), within what the
//! literature on braided muscles finds plausible. The loop leaves some freedom, mostly between the
//! threshold's width and the friction. It was used so that a well identified MGPI model (10 plays,
//! 10 dead zones) misses the Fig. 8 triangles by about 0.53 % of the stroke, somewhat less than the
//! paper's 0.69 % on the real muscle; a closer fit of the loop alone would leave 0.4 %.

use std::f64::consts::PI;

/// Length of the muscle between its fittings at rest, mm. Data sheet.
pub const NOMINAL_LENGTH_MM: f64 = 500.0;

/// Inner radius of the muscle at rest, mm. Data sheet: inner diameter 20 mm.
pub const INNER_RADIUS_MM: f64 = 10.0;

/// Force of one bar on the inner cross-section, N/bar (1 bar = 0.1 N/mm²). From the radius.
pub const BORE_FORCE_N_PER_BAR: f64 = 0.1 * PI * INNER_RADIUS_MM * INNER_RADIUS_MM;

/// Angle between fibre and muscle axis at rest, degrees. Data sheet: 1500 N at 6 bar and no
/// contraction, which an ideal braid reaches at 25.2 degrees.
pub const FIBRE_ANGLE_DEG: f64 = 25.0;

/// Factor on the contraction ratio in the braid's force, dimensionless: the ends taper to the
/// fittings instead of staying cylindrical (form: Tondu and Lopez 2000). Small, since the muscle is
/// slender. Loop.
pub const END_CORRECTION: f64 = 1.025;

/// Pressure the tube needs to press against the fibres, bar. Loop: the flat start of the rising
/// branch.
pub const THRESHOLD_PRESSURE_BAR: f64 = 1.07;

/// Width of the pressure range in which the tube comes to bear, part by part, bar. Loop: how
/// sharply the rising branch bends up.
pub const THRESHOLD_WIDTH_BAR: f64 = 0.65;

/// Axial stiffness of the elastic skin, N per unit of contraction ratio. A rubber wall of 1.5 mm
/// and 3 N/mm² has 0.3 kN lengthwise, and the growing circumference adds a multiple. Loop: the
/// stroke.
pub const SKIN_STIFFNESS_N: f64 = 940.0;

/// Fibre friction of the pressureless muscle, N. Loop: the width at 0 bar.
pub const FRICTION_N: f64 = 6.0;

/// Growth of the fibre friction with pressure, which presses the layers together, N/bar. Loop: the
/// width at 4 bar.
pub const FRICTION_N_PER_BAR: f64 = 13.0;

/// Contraction at which each bristle breaks away after a reversal at [`BREAKAWAY_PRESSURE_BAR`],
/// mm: nearly geometric, from fibre crossings next to each other to the whole length. The bristles
/// share the friction equally. Loop: the narrowing after the reversal at 6 bar.
pub const BREAKAWAY_MM: [f64; 6] = [1.0, 2.0, 5.0, 10.0, 25.0, 50.0];

/// Pressure at which [`BREAKAWAY_MM`] holds, bar: mid-range. Stiffness does not depend on pressure.
pub const BREAKAWAY_PRESSURE_BAR: f64 = 3.0;

/// Load of the free end, N. Assumed: fitting and transducer rod of 0.2 kg. It puts the rest at -1.1
/// mm, where the published curve starts.
pub const DEAD_LOAD_N: f64 = 2.0;

/// Largest load, N: near 95 N the fibres of the pressureless muscle lie along the axis and lock
/// (contraction ratio 1 - 1/cos of the fibre angle, divided by the end correction), which the skin
/// does not know.
pub const LOAD_LIMIT_N: f64 = 80.0;

/// Time constant of the regulator filling the muscle's volume, s. Assumed: the size usual for such
/// regulators.
pub const VALVE_TIME_CONSTANT_S: f64 = 0.05;

/// Upper end of the regulator's commanded range, bar. Data sheet of the muscle: 6 bar at most.
pub const VALVE_RANGE_BAR: f64 = 6.0;

/// Pressure of the supply, bar: one above the range, as the regulator's data sheet asks.
pub const SUPPLY_BAR: f64 = 7.0;

/// Standard deviation of the pressure measurement, bar. Assumed: 0.02 % of a transducer's 10 bar.
pub const PRESSURE_NOISE_BAR: f64 = 0.002;

/// Standard deviation of the contraction measurement, mm. Assumed: 0.02 % of a transducer's 150 mm.
pub const CONTRACTION_NOISE_MM: f64 = 0.03;
