//! SI units of mechanics for a table of variables, with display units.

use crate::table::UnitDefinition;
use std::f64::consts::PI;

/// The units; a table declares those that its variables use.
pub const UNITS: &[UnitDefinition] = &[
    UnitDefinition::new("1", &[]).shown_in(&[("%", 100.0)]),
    UnitDefinition::new("rad", &[("rad", 1)]).shown_in(&[("deg", 180.0 / PI)]),
    UnitDefinition::new("rad/s", &[("s", -1), ("rad", 1)]).shown_in(&[("rpm", 30.0 / PI)]),
    UnitDefinition::new("s", &[("s", 1)]),
    UnitDefinition::new("m", &[("m", 1)]).shown_in(&[("mm", 1000.0)]),
    UnitDefinition::new("m/s", &[("m", 1), ("s", -1)]),
    UnitDefinition::new("kg", &[("kg", 1)]),
    UnitDefinition::new("kg/m", &[("kg", 1), ("m", -1)]),
    UnitDefinition::new("kg.m2", &[("kg", 1), ("m", 2)]),
    UnitDefinition::new("N", &[("kg", 1), ("m", 1), ("s", -2)]).shown_in(&[("kN", 1e-3)]),
    UnitDefinition::new("N/m", &[("kg", 1), ("s", -2)]),
    UnitDefinition::new("N/m2", &[("kg", 1), ("m", -1), ("s", -2)]),
    UnitDefinition::new("Pa", &[("kg", 1), ("m", -1), ("s", -2)]).shown_in(&[("MPa", 1e-6), ("bar", 1e-5)]),
    UnitDefinition::new("m2", &[("m", 2)]),
    UnitDefinition::new("m3", &[("m", 3)]),
    UnitDefinition::new("m3/s", &[("m", 3), ("s", -1)]),
    UnitDefinition::new("N.s2/rad2", &[("kg", 1), ("m", 1), ("rad", -2)]),
    UnitDefinition::new("1/m", &[("m", -1)]),
    UnitDefinition::new("N.m", &[("kg", 1), ("m", 2), ("s", -2)]),
    UnitDefinition::new("N.m2", &[("kg", 1), ("m", 3), ("s", -2)]),
    UnitDefinition::new("N.m.s/rad", &[("kg", 1), ("m", 2), ("s", -1), ("rad", -1)]),
    UnitDefinition::new("N.m/rad", &[("kg", 1), ("m", 2), ("s", -2), ("rad", -1)]),
    UnitDefinition::new("N.s", &[("kg", 1), ("m", 1), ("s", -1)]),
    UnitDefinition::new("N.s/m", &[("kg", 1), ("s", -1)]),
    UnitDefinition::new("J", &[("kg", 1), ("m", 2), ("s", -2)]),
    UnitDefinition::new("W", &[("kg", 1), ("m", 2), ("s", -3)]),
];
