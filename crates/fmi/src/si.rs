//! SI units of mechanics for a table of variables, with display units.

use crate::table::UnitDefinition;

/// 1, shown in %.
pub const ONE: UnitDefinition = UnitDefinition::new("1", &[]).shown_in(&[("%", 100.0)]);
/// rad, shown in degrees.
pub const RADIAN: UnitDefinition =
    UnitDefinition::new("rad", &[("rad", 1)]).shown_in(&[("deg", 180.0 / std::f64::consts::PI)]);
/// rad/s, shown in rpm.
pub const RADIAN_PER_SECOND: UnitDefinition =
    UnitDefinition::new("rad/s", &[("s", -1), ("rad", 1)]).shown_in(&[("rpm", 30.0 / std::f64::consts::PI)]);
/// s.
pub const SECOND: UnitDefinition = UnitDefinition::new("s", &[("s", 1)]);
/// m, shown in mm.
pub const METRE: UnitDefinition = UnitDefinition::new("m", &[("m", 1)]).shown_in(&[("mm", 1000.0)]);
/// m/s.
pub const METRE_PER_SECOND: UnitDefinition = UnitDefinition::new("m/s", &[("m", 1), ("s", -1)]);
/// 1/m.
pub const PER_METRE: UnitDefinition = UnitDefinition::new("1/m", &[("m", -1)]);
/// kg.
pub const KILOGRAM: UnitDefinition = UnitDefinition::new("kg", &[("kg", 1)]);
/// kg/m.
pub const KILOGRAM_PER_METRE: UnitDefinition = UnitDefinition::new("kg/m", &[("kg", 1), ("m", -1)]);
/// kg·m².
pub const KILOGRAM_SQUARE_METRE: UnitDefinition = UnitDefinition::new("kg.m2", &[("kg", 1), ("m", 2)]);
/// N, shown in kN.
pub const NEWTON: UnitDefinition =
    UnitDefinition::new("N", &[("kg", 1), ("m", 1), ("s", -2)]).shown_in(&[("kN", 1e-3)]);
/// N/m.
pub const NEWTON_PER_METRE: UnitDefinition = UnitDefinition::new("N/m", &[("kg", 1), ("s", -2)]);
/// N/m².
pub const NEWTON_PER_SQUARE_METRE: UnitDefinition = UnitDefinition::new("N/m2", &[("kg", 1), ("m", -1), ("s", -2)]);
/// Pa, shown in MPa or bar.
pub const PASCAL: UnitDefinition =
    UnitDefinition::new("Pa", &[("kg", 1), ("m", -1), ("s", -2)]).shown_in(&[("MPa", 1e-6), ("bar", 1e-5)]);
/// m².
pub const SQUARE_METRE: UnitDefinition = UnitDefinition::new("m2", &[("m", 2)]);
/// m³/s.
pub const CUBIC_METRE_PER_SECOND: UnitDefinition = UnitDefinition::new("m3/s", &[("m", 3), ("s", -1)]);
/// N·s²/rad².
pub const NEWTON_SQUARE_SECOND_PER_SQUARE_RADIAN: UnitDefinition =
    UnitDefinition::new("N.s2/rad2", &[("kg", 1), ("m", 1), ("rad", -2)]);
/// N·m.
pub const NEWTON_METRE: UnitDefinition = UnitDefinition::new("N.m", &[("kg", 1), ("m", 2), ("s", -2)]);
/// N·m².
pub const NEWTON_SQUARE_METRE: UnitDefinition = UnitDefinition::new("N.m2", &[("kg", 1), ("m", 3), ("s", -2)]);
/// N·m·s/rad.
pub const NEWTON_METRE_SECOND_PER_RADIAN: UnitDefinition =
    UnitDefinition::new("N.m.s/rad", &[("kg", 1), ("m", 2), ("s", -1), ("rad", -1)]);
/// N·m/rad.
pub const NEWTON_METRE_PER_RADIAN: UnitDefinition =
    UnitDefinition::new("N.m/rad", &[("kg", 1), ("m", 2), ("s", -2), ("rad", -1)]);
/// N·s.
pub const NEWTON_SECOND: UnitDefinition = UnitDefinition::new("N.s", &[("kg", 1), ("m", 1), ("s", -1)]);
/// N·s/m.
pub const NEWTON_SECOND_PER_METRE: UnitDefinition = UnitDefinition::new("N.s/m", &[("kg", 1), ("s", -1)]);
/// J.
pub const JOULE: UnitDefinition = UnitDefinition::new("J", &[("kg", 1), ("m", 2), ("s", -2)]);
/// W.
pub const WATT: UnitDefinition = UnitDefinition::new("W", &[("kg", 1), ("m", 2), ("s", -3)]);
