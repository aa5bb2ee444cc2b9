//! Units and enumerations of the interface.

use crate::fmi::table::{Enumeration, Item, UnitDefinition};
use crate::variator::settings::{Axial, Drive, Mode, RingModel, StartState};

const fn unit(name: &'static str, exponents: &'static [(&'static str, i32)]) -> UnitDefinition {
    UnitDefinition {
        name,
        exponents,
        display: &[],
    }
}

/// Every unit that a variable uses.
pub(super) const UNITS: &[UnitDefinition] = &[
    UnitDefinition {
        name: "1",
        exponents: &[],
        display: &[("%", 100.0)],
    },
    UnitDefinition {
        name: "rad",
        exponents: &[("rad", 1)],
        display: &[("deg", 180.0 / std::f64::consts::PI)],
    },
    UnitDefinition {
        name: "rad/s",
        exponents: &[("s", -1), ("rad", 1)],
        display: &[("rpm", 30.0 / std::f64::consts::PI)],
    },
    unit("s", &[("s", 1)]),
    UnitDefinition {
        name: "m",
        exponents: &[("m", 1)],
        display: &[("mm", 1000.0)],
    },
    unit("m/s", &[("m", 1), ("s", -1)]),
    unit("kg", &[("kg", 1)]),
    unit("kg/m", &[("kg", 1), ("m", -1)]),
    unit("kg.m2", &[("kg", 1), ("m", 2)]),
    UnitDefinition {
        name: "N",
        exponents: &[("kg", 1), ("m", 1), ("s", -2)],
        display: &[("kN", 1e-3)],
    },
    unit("N/m", &[("kg", 1), ("s", -2)]),
    unit("N/m2", &[("kg", 1), ("m", -1), ("s", -2)]),
    unit("N.m", &[("kg", 1), ("m", 2), ("s", -2)]),
    unit("N.m2", &[("kg", 1), ("m", 3), ("s", -2)]),
    unit("N.m.s/rad", &[("kg", 1), ("m", 2), ("s", -1), ("rad", -1)]),
    unit("N.m/rad", &[("kg", 1), ("m", 2), ("s", -2), ("rad", -1)]),
    unit("N.s", &[("kg", 1), ("m", 1), ("s", -1)]),
    unit("N.s/m", &[("kg", 1), ("s", -1)]),
    unit("J", &[("kg", 1), ("m", 2), ("s", -2)]),
    unit("W", &[("kg", 1), ("m", 2), ("s", -3)]),
];

const fn item(name: &'static str, value: i32, description: &'static str) -> Item {
    Item {
        name,
        value,
        description,
    }
}

/// `ring.model`.
pub(super) static RING_MODEL: Enumeration = Enumeration {
    name: "RingModel",
    description: "Level of detail of the ring",
    items: &[
        item(
            "ALE0",
            RingModel::Ale0 as i32,
            "Reference motion only: drift, ratio and a ring tension carried along by friction",
        ),
        item(
            "ALE",
            RingModel::Ale as i32,
            "Reference motion with overlaid deflection: bending, stretch, spiral running",
        ),
    ],
};

/// `primary.drive`, `secondary.drive`.
pub(super) static DRIVE: Enumeration = Enumeration {
    name: "Drive",
    description: "What drives the shaft of a pulley",
    items: &[
        item("Torque", Drive::Torque as i32, "The shaft torque is the input"),
        item(
            "Speed",
            Drive::Speed as i32,
            "The speed follows its set point with a lag of 1 ms; the torque this takes is an output",
        ),
    ],
};

/// `primary.axial`, `secondary.axial`.
pub(super) static AXIAL: Enumeration = Enumeration {
    name: "Axial",
    description: "What holds the movable sheave of a pulley",
    items: &[
        item("Force", Axial::Force as i32, "The clamping force is the input"),
        item(
            "Held",
            Axial::Held as i32,
            "The sheave is held where the geometric ratio is initial.ratio; the clamping force input is ignored",
        ),
    ],
};

/// `solver.mode`.
pub(super) static MODE: Enumeration = Enumeration {
    name: "Mode",
    description: "How a run is integrated",
    items: &[
        item(
            "Accurate",
            Mode::Accurate as i32,
            "Steps as the error control requires, each solved",
        ),
        item(
            "RealTime",
            Mode::RealTime as i32,
            "The same work in each millisecond, solver.effort, whatever happens, with laws rounded where that is too little; ring.model ALE0 or ALE",
        ),
    ],
};

/// `initial.found`.
pub(super) static START_STATE: Enumeration = Enumeration {
    name: "StartState",
    description: "What a run started from",
    items: &[
        item(
            "Unloaded",
            StartState::Unloaded as i32,
            "The unloaded kinematic state that was asked for, or a standstill without clamping forces",
        ),
        item(
            "Steady",
            StartState::Steady as i32,
            "The steady state that was asked for; with initial.equilibrium the ratio too, or an end stop",
        ),
        item(
            "ReducedTorque",
            StartState::ReducedTorque as i32,
            "A steady state at part of the torques, because the belt doesn't carry them",
        ),
        item(
            "NoEquilibrium",
            StartState::NoEquilibrium as i32,
            "A steady state at initial.ratio, because no equilibrium of the clamping forces was found",
        ),
        item(
            "NotFound",
            StartState::NotFound as i32,
            "The unloaded kinematic state, because no steady state was found",
        ),
        item(
            "Clamped",
            StartState::Clamped as i32,
            "The clamped belt at a standstill, before torques act",
        ),
    ],
};
