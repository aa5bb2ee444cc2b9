//! Units and enumerations of the interface.

use crate::fmi::table::{Enumeration, Item, UnitDefinition};
use crate::variator::settings::{Axial, BeltKind, Drive, Mode, RingModel, StartState};

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
    UnitDefinition {
        name: "Pa",
        exponents: &[("kg", 1), ("m", -1), ("s", -2)],
        display: &[("MPa", 1e-6)],
    },
    unit("1/m", &[("m", -1)]),
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
            "Reference motion only: drift, ratio, free centres of the arcs, and a ring tension changed by friction",
        ),
        item(
            "ALE",
            RingModel::Ale as i32,
            "Reference motion with overlaid deflection: bending, stretch, spiral running",
        ),
    ],
};

/// `belt.kind`.
pub(super) static BELT_KIND: Enumeration = Enumeration {
    name: "BeltKind",
    description: "Kind of the belt",
    items: &[
        item("PushBelt", BeltKind::PushBelt as i32, "Push elements on two ring sets"),
        item(
            "PullChain",
            BeltKind::PullChain as i32,
            "Links and rocker pins, which are part of the chain",
        ),
    ],
};

/// `primary.drive`, `secondary.drive`.
pub(super) static DRIVE: Enumeration = Enumeration {
    name: "Drive",
    description: "Boundary condition of the shaft of a pulley",
    items: &[
        item("Torque", Drive::Torque as i32, "The shaft torque is the input"),
        item(
            "Speed",
            Drive::Speed as i32,
            "The speed follows its set point with a lag of 1 ms; the required torque is an output",
        ),
    ],
};

/// `primary.axial`, `secondary.axial`.
pub(super) static AXIAL: Enumeration = Enumeration {
    name: "Axial",
    description: "Boundary condition of the movable sheave of a pulley",
    items: &[
        item("Force", Axial::Force as i32, "The clamping force is the input"),
        item(
            "Held",
            Axial::Held as i32,
            "The sheave is held at the position where the geometric ratio is initial.ratio; the clamping force input is ignored",
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
            "Step-size control by the error estimate; every stage is solved",
        ),
        item(
            "RealTime",
            Mode::RealTime as i32,
            "Bounded work in each millisecond, given by solver.effort; where that is not enough, outputs have a delay",
        ),
    ],
};

/// `initial.found`.
pub(super) static START_STATE: Enumeration = Enumeration {
    name: "StartState",
    description: "State from which a run started",
    items: &[
        item(
            "Unloaded",
            StartState::Unloaded as i32,
            "The unloaded kinematic state, as requested, or a standstill without clamping forces",
        ),
        item(
            "Steady",
            StartState::Steady as i32,
            "The steady state, as requested; with initial.equilibrium at the ratio of equilibrium or at an end stop",
        ),
        item(
            "ReducedTorque",
            StartState::ReducedTorque as i32,
            "A steady state at reduced torques, because the belt does not carry the requested ones",
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
            "The belt at a standstill under its clamping forces",
        ),
    ],
};
