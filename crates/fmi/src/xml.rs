//! Elements and numbers of a description, whatever its version.

use std::fmt::Write as _;
use std::io::{self, Write};

use quick_xml::writer::Writer;

use super::hash::Fnv;

/// Names and values of an element's attributes.
pub(super) type Attributes = Vec<(&'static str, String)>;

/// A hash in the form of a GUID.
pub(super) fn token(hash: &Fnv) -> String {
    let digits = format!("{:032x}", hash.value());
    format!(
        "{{{}-{}-{}-{}-{}}}",
        &digits[..8],
        &digits[8..12],
        &digits[12..16],
        &digits[16..20],
        &digits[20..]
    )
}

/// An element without content.
pub(super) fn empty<W: Write>(xml: &mut Writer<W>, tag: &str, attributes: Attributes) -> io::Result<()> {
    let mut element = xml.create_element(tag);
    for (name, value) in &attributes {
        element = element.with_attribute((*name, value.as_str()));
    }
    element.write_empty().map(|_| ())
}

/// An element with content.
pub(super) fn parent<W: Write>(
    xml: &mut Writer<W>,
    tag: &str,
    attributes: Attributes,
    content: impl FnOnce(&mut Writer<W>) -> io::Result<()>,
) -> io::Result<()> {
    let mut element = xml.create_element(tag);
    for (name, value) in &attributes {
        element = element.with_attribute((*name, value.as_str()));
    }
    element.write_inner_content(content).map(|_| ())
}

/// The shortest decimal text that reads back as the same number.
pub(super) fn number(value: f64) -> String {
    let mut text = String::new();
    let size = value.abs();
    let written = if size == 0.0 || (1e-4..1e6).contains(&size) {
        write!(text, "{value}")
    } else {
        write!(text, "{value:e}")
    };
    written.expect("memory takes all text");
    text
}
