//! The enumerations of the interface.

use crate::fmi::table::{Enumeration, Item};

/// An enumeration: its description, and each item with its number, its name in the interface and
/// its meaning.
macro_rules! choice {
    ($name:ident: $description:literal; $($(#[$default:ident])? $item:ident = $number:literal $shown:literal: $meaning:literal,)+) => {
        #[doc = concat!($description, ".")]
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        #[repr(i32)]
        pub enum $name {
            $(#[doc = concat!($meaning, ".")] $(#[$default])? $item = $number,)+
        }

        impl $name {
            /// The enumeration as a type of the interface.
            pub const TYPE: &'static Enumeration = &Enumeration {
                name: stringify!($name),
                description: $description,
                items: &[$(Item::new($shown, $number, $meaning)),+],
            };

            /// The item with this number.
            pub fn from_number(number: i32) -> Option<Self> {
                match number {
                    $($number => Some(Self::$item),)+
                    _ => None,
                }
            }
        }
    };
}

choice! {
    RingModel: "Level of detail of the ring";
    Ale0 = 1 "ALE0": "Reference motion only: drift, ratio, free centres of the arcs, and a ring tension changed by friction",
    #[default] Ale = 2 "ALE": "Reference motion with overlaid deflection: bending, stretch, spiral running",
}

choice! {
    BeltKind: "Kind of the belt";
    #[default] PushBelt = 1 "PushBelt": "Push elements on two ring sets",
    PullChain = 2 "PullChain": "Links and rocker pins, which are part of the chain",
}

choice! {
    Drive: "Boundary condition of the shaft of a pulley";
    #[default] Torque = 1 "Torque": "The shaft torque is the input",
    Speed = 2 "Speed": "The speed follows its set point with a lag of 1 ms; the required torque is an output",
}

choice! {
    Axial: "Boundary condition of the movable sheave of a pulley";
    #[default] Force = 1 "Force": "Clamping force and pressure are the inputs",
    Held = 2 "Held": "The sheave is held at the position where the geometric ratio is initial.ratio; clamping force and pressure are ignored",
}

choice! {
    Mode: "How a run is integrated";
    #[default] Accurate = 1 "Accurate": "Step-size control by the error estimate; every stage is solved",
    RealTime = 2 "RealTime": "Bounded work in each millisecond, given by solver.effort; where that is not enough, outputs have a delay",
}

choice! {
    StartState: "State from which a run started";
    #[default] Unloaded = 1 "Unloaded": "The unloaded kinematic state, as requested, or a standstill without clamping forces",
    Steady = 2 "Steady": "The steady state, as requested; with initial.equilibrium at the ratio of equilibrium or at an end stop",
    ReducedTorque = 3 "ReducedTorque": "A steady state at reduced torques, because the belt does not carry the requested ones",
    NoEquilibrium = 4 "NoEquilibrium": "A steady state at initial.ratio, because no equilibrium of the clamping forces was found",
    NotFound = 5 "NotFound": "The unloaded kinematic state, because no steady state was found, or at a standstill no clamped one",
    Clamped = 6 "Clamped": "The belt at a standstill under its clamping forces",
}
