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

    /// Width, height, and the share of opaque pixels of a PNG with four channels of eight bits.
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
        let stride = 4 * width;
        assert_eq!(rows.len(), height * (1 + stride));
        let mut above = vec![0_u8; stride];
        let mut count = 0_u32;
        for row in rows.chunks_exact(1 + stride) {
            let mut pixels = row[1..].to_vec();
            for i in 0..stride {
                let left = if i < 4 { 0 } else { pixels[i - 4] };
                let corner = if i < 4 { 0 } else { above[i - 4] };
                let predicted = predict(row[0], left, above[i], corner);
                pixels[i] = pixels[i].wrapping_add(predicted);
            }
            count += u32::try_from(pixels.iter().skip(3).step_by(4).filter(|alpha| **alpha > 0).count()).unwrap();
            above = pixels;
        }
        (width, height, f64::from(count) / (width * height) as f64)
    }

    /// The filters of PNG (section 9.2 of the standard).
    fn predict(filter: u8, left: u8, above: u8, corner: u8) -> u8 {
        let (a, b, c) = (i16::from(left), i16::from(above), i16::from(corner));
        match filter {
            0 => 0,
            1 => left,
            2 => above,
            3 => u8::try_from((a + b) / 2).unwrap(),
            4 => {
                let estimate = a + b - c;
                let nearest = [left, above, corner]
                    .into_iter()
                    .min_by_key(|value| (estimate - i16::from(*value)).abs());
                nearest.unwrap()
            }
            other => panic!("filter {other}"),
        }
    }

    #[test]
    fn each_png_has_the_size_of_its_svg_and_is_not_empty() {
        for icon in std::iter::once(ICON).chain(TERMINALS) {
            let svg = roxmltree::Document::parse(icon.svg).unwrap();
            let size = |name: &str| svg.root_element().attribute(name).unwrap().parse::<usize>().unwrap();
            let (width, height, share) = painted(icon.png);
            assert_eq!((width, height), (size("width"), size("height")), "{}", icon.name);
            assert!(width >= 100 && height >= 100, "{}", icon.name);
            assert!(
                (0.25..0.95).contains(&share),
                "{} is painted on {share} of its area",
                icon.name
            );
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
