//! SI units of mechanics for a table of variables, with display units.

use crate::table::UnitDefinition;

const fn unit(name: &'static str, exponents: &'static [(&'static str, i32)]) -> UnitDefinition {
    UnitDefinition::new(name, exponents)
}

/// 1, shown in %.
pub const ONE: UnitDefinition = unit("1", &[]).shown_in(&[("%", 100.0)]);
/// rad, shown in degrees.
pub const RADIAN: UnitDefinition = unit("rad", &[("rad", 1)]).shown_in(&[("deg", 180.0 / std::f64::consts::PI)]);
/// rad/s, shown in rpm.
pub const RADIAN_PER_SECOND: UnitDefinition =
    unit("rad/s", &[("s", -1), ("rad", 1)]).shown_in(&[("rpm", 30.0 / std::f64::consts::PI)]);
/// s.
pub const SECOND: UnitDefinition = unit("s", &[("s", 1)]);
/// m, shown in mm.
pub const METRE: UnitDefinition = unit("m", &[("m", 1)]).shown_in(&[("mm", 1000.0)]);
/// m/s.
pub const METRE_PER_SECOND: UnitDefinition = unit("m/s", &[("m", 1), ("s", -1)]);
/// 1/m.
pub const PER_METRE: UnitDefinition = unit("1/m", &[("m", -1)]);
/// kg.
pub const KILOGRAM: UnitDefinition = unit("kg", &[("kg", 1)]);
/// kg/m.
pub const KILOGRAM_PER_METRE: UnitDefinition = unit("kg/m", &[("kg", 1), ("m", -1)]);
/// kg·m².
pub const KILOGRAM_SQUARE_METRE: UnitDefinition = unit("kg.m2", &[("kg", 1), ("m", 2)]);
/// N, shown in kN.
pub const NEWTON: UnitDefinition = unit("N", &[("kg", 1), ("m", 1), ("s", -2)]).shown_in(&[("kN", 1e-3)]);
/// N/m.
pub const NEWTON_PER_METRE: UnitDefinition = unit("N/m", &[("kg", 1), ("s", -2)]);
/// N/m².
pub const NEWTON_PER_SQUARE_METRE: UnitDefinition = unit("N/m2", &[("kg", 1), ("m", -1), ("s", -2)]);
/// Pa, shown in MPa.
pub const PASCAL: UnitDefinition = unit("Pa", &[("kg", 1), ("m", -1), ("s", -2)]).shown_in(&[("MPa", 1e-6)]);
/// N·m.
pub const NEWTON_METRE: UnitDefinition = unit("N.m", &[("kg", 1), ("m", 2), ("s", -2)]);
/// N·m².
pub const NEWTON_SQUARE_METRE: UnitDefinition = unit("N.m2", &[("kg", 1), ("m", 3), ("s", -2)]);
/// N·m·s/rad.
pub const NEWTON_METRE_SECOND_PER_RADIAN: UnitDefinition =
    unit("N.m.s/rad", &[("kg", 1), ("m", 2), ("s", -1), ("rad", -1)]);
/// N·m/rad.
pub const NEWTON_METRE_PER_RADIAN: UnitDefinition = unit("N.m/rad", &[("kg", 1), ("m", 2), ("s", -2), ("rad", -1)]);
/// N·s.
pub const NEWTON_SECOND: UnitDefinition = unit("N.s", &[("kg", 1), ("m", 1), ("s", -1)]);
/// N·s/m.
pub const NEWTON_SECOND_PER_METRE: UnitDefinition = unit("N.s/m", &[("kg", 1), ("s", -1)]);
/// J.
pub const JOULE: UnitDefinition = unit("J", &[("kg", 1), ("m", 2), ("s", -2)]);
/// W.
pub const WATT: UnitDefinition = unit("W", &[("kg", 1), ("m", 2), ("s", -3)]);
