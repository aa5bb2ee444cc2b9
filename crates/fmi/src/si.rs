//! SI units of mechanics for a table of variables, with display units.

use crate::table::UnitDefinition;
use std::f64::consts::PI;

/// Units by name and exponents, and units in which they may be shown, with their factors.
macro_rules! units {
    ($($name:literal [$($base:ident $exponent:literal),*] $(, shown in $($shown:expr),*)?;)*) => {
        &[$(
            UnitDefinition::new($name, &[$((stringify!($base), $exponent)),*])$(.shown_in(&[$($shown),*]))?
        ),*]
    };
}

/// The units; a table declares those that its variables use.
pub const UNITS: &[UnitDefinition] = units! {
    "1" [], shown in ("%", 100.0);
    "rad" [rad 1], shown in ("deg", 180.0 / PI);
    "rad/s" [s -1, rad 1], shown in ("rpm", 30.0 / PI);
    "s" [s 1];
    "m" [m 1], shown in ("mm", 1000.0);
    "m/s" [m 1, s -1];
    "kg" [kg 1];
    "kg/m" [kg 1, m -1];
    "kg.m2" [kg 1, m 2];
    "N" [kg 1, m 1, s -2], shown in ("kN", 1e-3);
    "N/m" [kg 1, s -2];
    "N/m2" [kg 1, m -1, s -2];
    "Pa" [kg 1, m -1, s -2], shown in ("MPa", 1e-6), ("bar", 1e-5);
    "m2" [m 2];
    "m3" [m 3];
    "m3/s" [m 3, s -1];
    "N.s2/rad2" [kg 1, m 1, rad -2];
    "1/m" [m -1];
    "N.m" [kg 1, m 2, s -2];
    "N.m2" [kg 1, m 3, s -2];
    "N.m.s/rad" [kg 1, m 2, s -1, rad -1];
    "N.m/rad" [kg 1, m 2, s -2, rad -1];
    "N.s" [kg 1, m 1, s -1];
    "N.s/m" [kg 1, s -1];
    "J" [kg 1, m 2, s -2];
    "W" [kg 1, m 2, s -3];
};
