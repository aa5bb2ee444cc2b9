//! `cargo fmu live`: the model in a page for a browser, one file.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, ensure};
use flate2::Compression;
use flate2::write::GzEncoder;
use serde_json::{Map, Value, json};

use crate::distribution::Distribution;
use crate::workspace::Workspace;
use crate::{cargo, licenses, portable, progress};

const TARGET: &str = "wasm32-unknown-unknown";

/// Bound of the page's size, bytes.
const LARGEST: usize = 1_500_000;

/// The parts of the page, by the words that they replace in its frame.
const FRAME: &str = "live/page/index.html";
const STYLES: [&str; 2] = ["python/pushbelt/report/style.css", "live/page/live.css"];
const DRAWING: &str = "python/pushbelt/report/drawing.js.j2";
const SCRIPT: &str = "live/page/live.js";

/// Writes `target/live.html`.
///
/// # Errors
/// There is no compiler for WebAssembly, or the page can't be written.
pub fn run(workspace: &Workspace) -> anyhow::Result<()> {
    let _alone = workspace.lock("live")?;
    let module = compile(workspace)?;
    let page = page(workspace, &module)?;
    ensure!(
        page.len() <= LARGEST,
        "the page has {} bytes, more than {LARGEST}",
        page.len()
    );
    let path = path(workspace);
    // A draft is renamed, so that no browser reads an incomplete page.
    let draft = path.with_extension("part");
    fs::write(&draft, &page)
        .and_then(|()| fs::rename(&draft, &path))
        .with_context(|| format!("can't write {}", path.display()))?;
    println!("{} ({} kB)", path.display(), page.len().div_ceil(1024));
    Ok(())
}

/// The page.
pub fn path(workspace: &Workspace) -> PathBuf {
    workspace.target().join("live.html")
}

/// Compiles the model with rustup's compiler, or with the distribution's where rustup has no
/// standard library for the target, and returns the module.
fn compile(workspace: &Workspace) -> anyhow::Result<Vec<u8>> {
    let mut command = cargo::command(workspace);
    command.args(["build", "--release", "--locked", "--target", TARGET]);
    if let Err(missing) = portable::ensure_installed(TARGET) {
        eprintln!("  {missing:#}; the distribution's compiler is tried");
        let distribution =
            Distribution::prepare(workspace).context("there is no compiler for the live page")?;
        distribution.compile_with(&mut command, TARGET)?;
    }
    let mut flags = vec!["-Ctarget-feature=+simd128".to_owned()];
    flags.extend(portable::without_paths(workspace));
    command.env("CARGO_ENCODED_RUSTFLAGS", flags.join("\x1f"));
    progress::headline("Compiling the model for browsers");
    let path = cargo::build_module(&mut command)?;
    fs::read(&path).with_context(|| format!("can't read {}", path.display()))
}

/// The page with all that it needs inside.
fn page(workspace: &Workspace, module: &[u8]) -> anyhow::Result<String> {
    let read = |name: &str| {
        let path = workspace.root().join(name);
        fs::read_to_string(&path).with_context(|| format!("can't read {}", path.display()))
    };
    let mut packed = GzEncoder::new(Vec::new(), Compression::best());
    packed.write_all(module)?;
    let notices = licenses::third_party(&workspace.packages(false)?)?;
    let notices = notices.replace('&', "&amp;").replace('<', "&lt;");
    let parts = [
        (
            "style",
            STYLES.map(read).into_iter().collect::<anyhow::Result<String>>()?,
        ),
        ("version", version(workspace)),
        ("variators", variators(&workspace.root().join("resources/parameters"))?),
        ("module", base64(&packed.finish()?)),
        ("drawing", read(DRAWING)?),
        ("script", read(SCRIPT)?),
        ("notices", notices),
    ];
    let mut page = read(FRAME)?;
    for (name, content) in parts {
        let place = format!("{{{{{name}}}}}");
        ensure!(page.contains(&place), "{FRAME} has no place for {name}");
        page = page.replacen(&place, &content, 1);
    }
    Ok(page)
}

/// Name and version of the package, with the commit where there is one.
fn version(workspace: &Workspace) -> String {
    let mut git = Command::new("git");
    git.current_dir(workspace.root())
        .args(["describe", "--always", "--dirty"]);
    let output = git.output().ok().filter(|output| output.status.success());
    let commit = output.and_then(|output| String::from_utf8(output.stdout).ok());
    let commit = commit.map_or(String::new(), |commit| format!(", commit {}", commit.trim()));
    format!("pushbelt {}{commit}", env!("CARGO_PKG_VERSION"))
}

/// The published variators as JSON: what each is, and its parameters by the variables' names.
fn variators(folder: &Path) -> anyhow::Result<String> {
    let mut found = Map::new();
    for entry in fs::read_dir(folder).with_context(|| format!("can't read {}", folder.display()))? {
        let path = entry?.path();
        if path.extension().is_none_or(|extension| extension != "json") {
            continue;
        }
        let text = fs::read_to_string(&path)?;
        let set: Value = serde_json::from_str(&text).with_context(|| format!("{}", path.display()))?;
        let parameters = set["parameters"].as_object().context("a set has parameters")?;
        let values: Map<_, _> = parameters
            .iter()
            .map(|(name, one)| (name.clone(), one["value"].clone()))
            .collect();
        let id = set["id"].as_str().context("a set has a name")?;
        found.insert(id.to_owned(), json!({"about": set["about"], "parameters": values}));
    }
    Ok(Value::Object(found).to_string())
}

/// Bytes as text in base 64.
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let number = [16, 8, 0]
            .iter()
            .zip(three)
            .map(|(by, byte)| u32::from(*byte) << by)
            .sum::<u32>();
        for place in 0..4 {
            let digit = number >> (18 - 6 * place) & 63;
            text.push(if place <= three.len() {
                DIGITS[digit as usize] as char
            } else {
                '='
            });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_become_text() {
        for (bytes, expected) in [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foobar", "Zm9vYmFy")] {
            assert_eq!(base64(bytes.as_bytes()), expected);
        }
    }

    #[test]
    fn the_page_is_one_file() {
        let workspace = Workspace::find().expect("the workspace");
        let page = page(&workspace, b"module").expect("a page");
        assert!(!page.contains("{{"), "a part is missing");
        for other in [" src=", "<link", "url("] {
            assert!(!page.contains(other), "{other}");
        }
    }
}
