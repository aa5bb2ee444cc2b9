//! Icons of the FMU and of its terminals: SVG, and PNG for tools that don't read SVG.
//!
//! The PNGs are checked in. After a change of an SVG, in `fmu-build/icons`:
//!
//! ```sh
//! cargo install resvg@0.49.0
//! for svg in *.svg; do resvg "$svg" "${svg%.svg}.png"; done
//! ```

macro_rules! icon {
    ($name:literal) => {
        Icon {
            name: $name,
            svg: include_str!(concat!("../icons/", $name, ".svg")),
            png: include_bytes!(concat!("../icons/", $name, ".png")),
        }
    };
}

/// One icon.
struct Icon {
    /// Name in `terminalsAndIcons/`, without extension.
    name: &'static str,
    svg: &'static str,
    png: &'static [u8],
}

/// The icon of the FMU itself.
const ICON: Icon = icon!("icon");

/// The icons of its terminals.
const TERMINALS: [Icon; 3] = [icon!("shaft"), icon!("clamp"), icon!("port")];

/// `model.png`, the picture of the FMU in a user interface.
pub const MODEL: &[u8] = ICON.png;

/// The files of the icons, with their contents.
pub fn files() -> impl Iterator<Item = (String, Vec<u8>)> {
    let both = |icon: Icon| {
        [
            (format!("{}.svg", icon.name), icon.svg.as_bytes().to_vec()),
            (format!("{}.png", icon.name), icon.png.to_vec()),
        ]
    };
    std::iter::once(ICON).chain(TERMINALS).flat_map(both)
}

#[cfg(test)]
mod tests {
    use super::*;

    use std::io::Read as _;

    use flate2::read::ZlibDecoder;

    /// Width, height, and the share of bytes that are not 0 in the rows of a PNG with four channels
    /// of eight bits. In an empty picture all are 0, in a uniform one almost all, whatever the
    /// filter of a row (section 9.2 of the standard).
    fn painted(png: &[u8]) -> (usize, usize, f64) {
        let number = |at: usize| u32::from_be_bytes(png[at..at + 4].try_into().unwrap()) as usize;
        assert!(png.starts_with(b"\x89PNG\r\n\x1a\n"));
        let (width, height) = (number(16), number(20));
        assert_eq!(&png[24..29], [8, 6, 0, 0, 0], "eight bits, RGBA, not interlaced");
        let (mut packed, mut at) = (Vec::new(), 8);
        while at < png.len() {
            let end = at + 8 + number(at);
            if &png[at + 4..at + 8] == b"IDAT" {
                packed.extend(&png[at + 8..end]);
            }
            at = end + 4;
        }
        let mut rows = Vec::new();
        ZlibDecoder::new(&packed[..]).read_to_end(&mut rows).unwrap();
        assert_eq!(rows.len(), height * (1 + 4 * width));
        let painted = rows.iter().filter(|byte| **byte != 0).count();
        (width, height, painted as f64 / rows.len() as f64)
    }

    #[test]
    fn each_png_has_the_size_of_its_svg_and_is_not_empty() {
        for icon in std::iter::once(ICON).chain(TERMINALS) {
            let svg = roxmltree::Document::parse(icon.svg).unwrap();
            let size = |name: &str| svg.root_element().attribute(name).unwrap().parse::<usize>().unwrap();
            let (width, height, share) = painted(icon.png);
            assert_eq!((width, height), (size("width"), size("height")), "{}", icon.name);
            assert!(width >= 100 && height >= 100, "{}", icon.name);
            assert!(share > 0.01, "{} has {share} of its bytes", icon.name);
        }
    }

    #[test]
    fn every_terminal_has_its_icon() {
        let workspace = crate::workspace::Workspace::find().unwrap();
        let xml = std::fs::read_to_string(workspace.terminals()).unwrap();
        let document = roxmltree::Document::parse(&xml).unwrap();
        let mut used: Vec<&str> = document
            .descendants()
            .filter_map(|node| node.attribute("iconBaseName"))
            .collect();
        used.sort_unstable();
        used.dedup();
        let mut drawn = TERMINALS.map(|icon| icon.name);
        drawn.sort_unstable();
        assert_eq!(used, drawn);
    }
}
