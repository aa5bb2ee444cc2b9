//! `cargo fmu describe`: writes the checked-in files that are generated from the variable table,
//! the tables of C functions and the version.

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use anyhow::Context;

use crate::cargo;
use crate::description::Description;
use crate::platform::Version;
use crate::progress;
use crate::python::{Environment, RUNNING};
use crate::workspace::Workspace;

/// Version of crate, FMU and Python package, from the workspace's manifest.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Writes `modelDescription.xml`, `modelDescription3.xml`, `terminalsAndIcons.xml`, `exports.def`,
/// the files generated from the first, and the book's pages about commands and Python. Whether
/// these pages are up to date is a test of the Python package.
///
/// # Errors
/// The model doesn't compile, a file can't be written, or Python's packages can't be installed.
pub fn run(workspace: &Workspace) -> anyhow::Result<()> {
    progress::headline("Reading the variable table");
    let program = cargo::build_program(workspace, cargo::DESCRIPTION)?;
    let mut written = Vec::new();
    for path in [
        workspace.model_description(Version::Two),
        workspace.model_description(Version::Three),
        workspace.terminals(),
        workspace.exports(),
    ] {
        let name = path.file_name().context("a file has a name")?;
        let xml = cargo::printed(Command::new(&program).arg(name))?;
        written.push((path, xml));
    }
    let derived = derived(workspace, &written[0].1)?;
    for (path, text) in written.into_iter().chain(derived) {
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder).with_context(|| format!("can't make {}", folder.display()))?;
        }
        fs::write(&path, text).with_context(|| format!("can't write {}", path.display()))?;
        println!("{}", path.display());
    }
    progress::headline("Reading the Python package");
    let mut reference = Environment::prepare(workspace, &RUNNING)?.command();
    cargo::run(reference.arg(workspace.root().join("fmu-build/python/book.py")))
}

/// Files that are out of date with respect to `modelDescription.xml` and the version. Whether
/// `modelDescription.xml` is that of the variable table is a test of the model, which this tool
/// doesn't link.
///
/// # Errors
/// `modelDescription.xml` can't be read.
pub fn outdated(workspace: &Workspace) -> anyhow::Result<Vec<String>> {
    let path = workspace.model_description(Version::Two);
    let xml = fs::read_to_string(&path).with_context(|| format!("can't read {}", path.display()))?;
    let mut outdated = Vec::new();
    if Description::parse(&xml)?.version != VERSION {
        outdated.push(path);
    }
    for (path, text) in derived(workspace, &xml)? {
        if fs::read_to_string(&path).ok() != Some(text) {
            outdated.push(path);
        }
    }
    Ok(outdated.iter().map(|path| path.display().to_string()).collect())
}

/// The other files with their contents.
fn derived(workspace: &Workspace, xml: &str) -> anyhow::Result<[(PathBuf, String); 2]> {
    let page = workspace.root().join("docs").join("variables.md");
    let python = workspace.root().join("python").join("pushbelt").join("_version.py");
    Ok([
        (page, Description::parse(xml)?.to_markdown()),
        (python, version_module(VERSION)),
    ])
}

fn version_module(version: &str) -> String {
    format!("\"\"\"Written by cargo fmu describe.\"\"\"\n\n__version__ = \"{version}\"\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checked_in_files_are_up_to_date() {
        let outdated = outdated(&Workspace::find().unwrap()).unwrap();
        assert!(outdated.is_empty(), "write {outdated:?} anew by `cargo fmu describe`");
    }

    #[test]
    fn the_version_is_a_python_module() {
        let expected = "\"\"\"Written by cargo fmu describe.\"\"\"\n\n__version__ = \"1.2.3\"\n";
        assert_eq!(version_module("1.2.3"), expected);
    }
}
