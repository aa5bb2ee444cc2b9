//! Terminals of the variator: the variables of each one and its place on the icon.

use crate::fmi::fmi3::{Terminal, terminals_and_icons};

/// Shaft, clamp and port of a pulley, each with its middle on the icon.
macro_rules! of_pulley {
    ($pulley:literal, $shaft:expr, $clamp:expr, $port:expr) => {
        [
            Terminal {
                name: concat!($pulley, "Shaft"),
                description: concat!("Shaft of the ", $pulley, " pulley: torque in, speed out"),
                members: &[
                    ("torque", concat!($pulley, ".torque")),
                    ("speed", concat!($pulley, ".speed")),
                ],
                icon: "shaft",
                middle: $shaft,
            },
            Terminal {
                name: concat!($pulley, "Clamp"),
                description: concat!(
                    "Clamp of the ",
                    $pulley,
                    " pulley: force in, position of the movable sheave out"
                ),
                members: &[
                    ("force", concat!($pulley, ".clampingForce")),
                    ("position", concat!($pulley, ".position")),
                ],
                icon: "clamp",
                middle: $clamp,
            },
            Terminal {
                name: concat!($pulley, "Port"),
                description: concat!("Port of the ", $pulley, " cylinder: pressure in, flow out"),
                members: &[
                    ("pressure", concat!($pulley, ".pressure")),
                    ("flow", concat!($pulley, ".cylinder.flow")),
                ],
                icon: "port",
                middle: $port,
            },
        ]
    };
}

/// The terminals of shafts, clamps and cylinders.
pub const TERMINALS: [Terminal; 6] = {
    let [shaft, clamp, port] = of_pulley!("primary", [150.0, 0.0], [77.0, 90.0], [77.0, -90.0]);
    let [shaft_s, clamp_s, port_s] = of_pulley!("secondary", [-150.0, 0.0], [-65.0, 90.0], [-65.0, -90.0]);
    [shaft, shaft_s, clamp, clamp_s, port, port_s]
};

/// The content of `terminalsAndIcons.xml`.
#[must_use]
pub fn terminals() -> String {
    terminals_and_icons(&TERMINALS)
}
