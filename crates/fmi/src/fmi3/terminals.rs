//! `terminalsAndIcons.xml`: variables that belong together at one connection, and where it is drawn. FMI 2.0.4 took the file over as
//! it is, so it serves both versions.

use std::io::{self, Write};

use quick_xml::events::{BytesDecl, Event};
use quick_xml::writer::Writer;

use crate::xml::{Attributes, empty, number, parent};

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
pub const HALF_SIZE: [f64; 2] = [160.0, 100.0];

/// Half the size of a terminal on the icon.
const HALF_TERMINAL: f64 = 10.0;

/// Millimetres for each unit of the coordinates.
const SCALE: f64 = 0.1;

/// The content of the file.
///
/// # Panics
/// It does not panic: writing to memory does not fail.
#[must_use]
pub fn terminals_and_icons(terminals: &[Terminal]) -> String {
    let mut bytes = Vec::new();
    write(&mut bytes, terminals).expect("memory takes all bytes");
    String::from_utf8(bytes).expect("the writer is given text only")
}

fn write<W: Write>(to: W, terminals: &[Terminal]) -> io::Result<()> {
    let mut xml = Writer::new_with_indent(to, b' ', 2);
    xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    let head: Attributes = vec![("fmiVersion", "3.0".into())];
    parent(&mut xml, "fmiTerminalsAndIcons", head, |xml| {
        parent(xml, "GraphicalRepresentation", vec![], |xml| {
            let mut system = extent([0.0, 0.0], HALF_SIZE);
            system.push(("suggestedScalingFactorTo_mm", number(SCALE)));
            empty(xml, "CoordinateSystem", system)?;
            empty(xml, "Icon", extent([0.0, 0.0], HALF_SIZE))
        })?;
        parent(xml, "Terminals", vec![], |xml| {
            terminals.iter().try_for_each(|terminal| write_terminal(xml, terminal))
        })
    })?;
    xml.get_mut().write_all(b"\n")
}

fn write_terminal<W: Write>(xml: &mut Writer<W>, terminal: &Terminal) -> io::Result<()> {
    let head: Attributes = vec![
        ("name", terminal.name.into()),
        // Members are matched by their names.
        ("matchingRule", "plug".into()),
        ("description", terminal.description.into()),
    ];
    parent(xml, "Terminal", head, |xml| {
        terminal.members.iter().try_for_each(|(member, variable)| {
            let member: Attributes = vec![
                ("variableName", (*variable).into()),
                ("memberName", (*member).into()),
                ("variableKind", "signal".into()),
            ];
            empty(xml, "TerminalMemberVariable", member)
        })?;
        let mut drawn = extent(terminal.middle, [HALF_TERMINAL; 2]);
        drawn.push(("iconBaseName", terminal.icon.into()));
        empty(xml, "TerminalGraphicalRepresentation", drawn)
    })
}

/// The corners of a rectangle.
fn extent([x, y]: [f64; 2], [half_width, half_height]: [f64; 2]) -> Attributes {
    vec![
        ("x1", number(x - half_width)),
        ("y1", number(y - half_height)),
        ("x2", number(x + half_width)),
        ("y2", number(y + half_height)),
    ]
}
