//! `terminalsAndIcons.xml`: variables that belong together at one connection, and where it is
//! drawn. FMI 2.0.4 took the file over as it is, so it serves both versions.

use crate::xml::{Element, Number};

/// A connection: variables that are connected together, and its place on the icon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Terminal {
    /// Name.
    pub name: &'static str,
    /// What is connected here, in one phrase.
    pub description: &'static str,
    /// Name of each member within the terminal, and its variable.
    pub members: &'static [(&'static str, &'static str)],
    /// File name of its icon, without extension.
    pub icon: &'static str,
    /// Its middle, in the coordinates of the icon.
    pub middle: [f64; 2],
}

/// Half the size of the icon's coordinate system, which has its origin in the middle.
const HALF_SIZE: [f64; 2] = [160.0, 100.0];

/// Half the size of a terminal on the icon.
const HALF_TERMINAL: f64 = 10.0;

/// Millimetres for each unit of the coordinates.
const SCALE: f64 = 0.1;

/// The content of the file.
pub fn terminals_and_icons(terminals: &[Terminal]) -> String {
    let system =
        extent("CoordinateSystem", [0.0, 0.0], HALF_SIZE).with("suggestedScalingFactorTo_mm", Number(SCALE));
    let drawn = [system, extent("Icon", [0.0, 0.0], HALF_SIZE)];
    Element::new("fmiTerminalsAndIcons")
        .with("fmiVersion", "3.0")
        .list("GraphicalRepresentation", drawn)
        .list("Terminals", terminals.iter().map(terminal))
        .document()
}

fn terminal(terminal: &Terminal) -> Element {
    let members = terminal.members.iter().map(|(member, variable)| {
        Element::new("TerminalMemberVariable")
            .with("variableName", variable)
            .with("memberName", member)
            .with("variableKind", "signal")
    });
    let drawn = extent("TerminalGraphicalRepresentation", terminal.middle, [HALF_TERMINAL; 2]);
    Element::new("Terminal")
        .with("name", terminal.name)
        // Members are matched by their names.
        .with("matchingRule", "plug")
        .with("description", terminal.description)
        .children(members)
        .child(drawn.with("iconBaseName", terminal.icon))
}

fn extent(tag: &'static str, [x, y]: [f64; 2], [half_width, half_height]: [f64; 2]) -> Element {
    Element::new(tag)
        .with("x1", Number(x - half_width))
        .with("y1", Number(y - half_height))
        .with("x2", Number(x + half_width))
        .with("y2", Number(y + half_height))
}
