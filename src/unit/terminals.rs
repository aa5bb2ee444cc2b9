//! Terminals of the variator: the variables of each one and its place on the icon.

use crate::fmi::fmi3::{Terminal, terminals_and_icons};

/// The terminals of shafts, clamps and cylinders.
#[rustfmt::skip]
pub const TERMINALS: [Terminal; 6] = [
    Terminal { name: "primaryShaft", description: "Shaft of the primary pulley: torque in, speed out",
        members: &[("torque", "primary.torque"), ("speed", "primary.speed")], icon: "shaft", middle: [150.0, 0.0] },
    Terminal { name: "secondaryShaft", description: "Shaft of the secondary pulley: torque in, speed out",
        members: &[("torque", "secondary.torque"), ("speed", "secondary.speed")], icon: "shaft", middle: [-150.0, 0.0] },
    Terminal { name: "primaryClamp", description: "Clamp of the primary pulley: force in, position of the movable sheave out",
        members: &[("force", "primary.clampingForce"), ("position", "primary.position")], icon: "clamp", middle: [77.0, 90.0] },
    Terminal { name: "secondaryClamp", description: "Clamp of the secondary pulley: force in, position of the movable sheave out",
        members: &[("force", "secondary.clampingForce"), ("position", "secondary.position")], icon: "clamp", middle: [-65.0, 90.0] },
    Terminal { name: "primaryPort", description: "Port of the primary cylinder: pressure in, flow out",
        members: &[("pressure", "primary.pressure"), ("flow", "primary.cylinder.flow")], icon: "port", middle: [77.0, -90.0] },
    Terminal { name: "secondaryPort", description: "Port of the secondary cylinder: pressure in, flow out",
        members: &[("pressure", "secondary.pressure"), ("flow", "secondary.cylinder.flow")], icon: "port", middle: [-65.0, -90.0] },
];

/// The content of `terminalsAndIcons.xml`.
#[must_use]
pub fn terminals() -> String {
    terminals_and_icons(&TERMINALS)
}
