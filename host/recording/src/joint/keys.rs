//! The keys of a joint's parameters in its model file, with their units: what reads, writes and
//! names parameters takes them from here.

/// A key with the unit of its value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key {
    /// As it stands in the file.
    pub name: &'static str,
    /// For people.
    pub unit: &'static str,
}

const fn key(name: &'static str, unit: &'static str) -> Key {
    Key { name, unit }
}

/// Sections of both muscles: first of the one that turns the joint to larger angles.
pub const MUSCLES: [&str; 2] = ["muscle_a", "muscle_b"];
/// Section of what acts without pressure.
pub const REST: &str = "passive";

/// Of a muscle: the torque of a bar, over powers of the angle.
pub const ARM: [Key; 3] = [
    key("arm_nm_per_bar", "N m/bar"),
    key("arm_linear_nm_per_bar_rad", "N m/(bar rad)"),
    key("arm_square_nm_per_bar_rad2", "N m/(bar rad²)"),
];
/// Of a muscle: what its drive has more at low pressures.
pub const KNEE: Key = key("knee_bar2", "bar²");
/// Of a muscle: stiffness of each stop.
pub const FRICTION: Key = key("friction_nm_per_rad", "N m/rad");
/// Of a muscle: its slip, constant and over the drive.
pub const SLIP: [Key; 2] = [key("slip_constant", "1"), key("slip_per_bar", "1/bar")];
/// Of the rest: the torque over powers of the angle.
pub const PASSIVE: [Key; 4] = [
    key("constant_nm", "N m"),
    key("linear_nm_per_rad", "N m/rad"),
    key("square_nm_per_rad2", "N m/rad²"),
    key("cube_nm_per_rad3", "N m/rad³"),
];
/// Of the rest: torque against the speed.
pub const VISCOSITY: Key = key("viscosity_nm_s_per_rad", "N m s/rad");

/// The names alone.
pub(super) fn names<const N: usize>(keys: [Key; N]) -> [&'static str; N] {
    keys.map(|key| key.name)
}
