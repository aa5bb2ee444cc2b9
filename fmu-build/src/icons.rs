//! Icons of the FMU and of its terminals: drawn as SVG, with a PNG beside each for tools that don't read SVG.

use anyhow::Context;
use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree};

/// Name of each icon in `terminalsAndIcons/`, and its SVG.
const ICONS: [(&str, &str); 3] = [
    ("icon", include_str!("../icons/icon.svg")),
    ("shaft", include_str!("../icons/shaft.svg")),
    ("clamp", include_str!("../icons/clamp.svg")),
];

/// The files of the icons, with their contents.
///
/// # Errors
/// An icon can't be drawn.
pub fn files() -> anyhow::Result<Vec<(String, Vec<u8>)>> {
    let mut files = Vec::new();
    for (name, svg) in ICONS {
        let png = png(svg).with_context(|| format!("{name}.svg can't be drawn"))?;
        files.push((format!("{name}.svg"), svg.as_bytes().to_vec()));
        files.push((format!("{name}.png"), png));
    }
    Ok(files)
}

fn png(svg: &str) -> anyhow::Result<Vec<u8>> {
    let tree = Tree::from_str(svg, &Options::default())?;
    let size = tree.size().to_int_size();
    let mut canvas = Pixmap::new(size.width(), size.height()).context("a picture has a size")?;
    resvg::render(&tree, Transform::identity(), &mut canvas.as_mut());
    canvas.encode_png().context("the picture can't be encoded")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn icons_are_drawn_and_always_the_same() {
        let drawn = files().unwrap();
        assert_eq!(drawn, files().unwrap());
        for (name, content) in drawn {
            let pixels = name.ends_with(".png").then(|| Pixmap::decode_png(&content).unwrap());
            if let Some(pixels) = pixels {
                assert!(pixels.width() >= 100 && pixels.height() >= 100, "{name}");
                let painted = pixels.pixels().iter().filter(|pixel| pixel.alpha() > 0).count();
                assert!(4 * painted > pixels.pixels().len(), "{name} is nearly empty");
            }
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
        let mut drawn: Vec<&str> = ICONS
            .iter()
            .map(|(name, _)| *name)
            .filter(|name| *name != "icon")
            .collect();
        drawn.sort_unstable();
        assert_eq!(used, drawn);
    }
}
