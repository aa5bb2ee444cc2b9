//! Units and enumerations of the interface.

use crate::fmi::si;
use crate::fmi::table::{Enumeration, Item, UnitDefinition};
use crate::variator::settings::{Axial, BeltKind, Drive, Mode, RingModel, StartState};

/// Every unit that a variable uses.
pub(super) const UNITS: &[UnitDefinition] = &[
    si::ONE,
    si::RADIAN,
    si::RADIAN_PER_SECOND,
    si::SECOND,
    si::METRE,
    si::METRE_PER_SECOND,
    si::KILOGRAM,
    si::KILOGRAM_PER_METRE,
    si::KILOGRAM_SQUARE_METRE,
    si::NEWTON,
    si::NEWTON_PER_METRE,
    si::NEWTON_PER_SQUARE_METRE,
    si::PASCAL,
    si::SQUARE_METRE,
    si::CUBIC_METRE_PER_SECOND,
    si::NEWTON_SQUARE_SECOND_PER_SQUARE_RADIAN,
    si::PER_METRE,
    si::NEWTON_METRE,
    si::NEWTON_SQUARE_METRE,
    si::NEWTON_METRE_SECOND_PER_RADIAN,
    si::NEWTON_METRE_PER_RADIAN,
    si::NEWTON_SECOND,
    si::NEWTON_SECOND_PER_METRE,
    si::JOULE,
    si::WATT,
];

/// `ring.model`.
pub(super) static RING_MODEL: Enumeration = Enumeration {
    name: "RingModel",
    description: "Level of detail of the ring",
    items: &[
        Item::new(
            "ALE0",
            RingModel::Ale0 as i32,
            "Reference motion only: drift, ratio, free centres of the arcs, and a ring tension changed by friction",
        ),
        Item::new(
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
        Item::new("PushBelt", BeltKind::PushBelt as i32, "Push elements on two ring sets"),
        Item::new(
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
        Item::new("Torque", Drive::Torque as i32, "The shaft torque is the input"),
        Item::new(
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
        Item::new(
            "Force",
            Axial::Force as i32,
            "Clamping force and pressure are the inputs",
        ),
        Item::new(
            "Held",
            Axial::Held as i32,
            "The sheave is held at the position where the geometric ratio is initial.ratio; clamping force and pressure are ignored",
        ),
    ],
};

/// `solver.mode`.
pub(super) static MODE: Enumeration = Enumeration {
    name: "Mode",
    description: "How a run is integrated",
    items: &[
        Item::new(
            "Accurate",
            Mode::Accurate as i32,
            "Step-size control by the error estimate; every stage is solved",
        ),
        Item::new(
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
        Item::new(
            "Unloaded",
            StartState::Unloaded as i32,
            "The unloaded kinematic state, as requested, or a standstill without clamping forces",
        ),
        Item::new(
            "Steady",
            StartState::Steady as i32,
            "The steady state, as requested; with initial.equilibrium at the ratio of equilibrium or at an end stop",
        ),
        Item::new(
            "ReducedTorque",
            StartState::ReducedTorque as i32,
            "A steady state at reduced torques, because the belt does not carry the requested ones",
        ),
        Item::new(
            "NoEquilibrium",
            StartState::NoEquilibrium as i32,
            "A steady state at initial.ratio, because no equilibrium of the clamping forces was found",
        ),
        Item::new(
            "NotFound",
            StartState::NotFound as i32,
            "The unloaded kinematic state, because no steady state was found",
        ),
        Item::new(
            "Clamped",
            StartState::Clamped as i32,
            "The belt at a standstill under its clamping forces",
        ),
    ],
};
