//! `cargo fmu describe`: writes what is generated from the variable table and checked in.

use std::fs;
use std::path::Path;
use std::process::Stdio;

use anyhow::{Context, ensure};

use crate::cargo;
use crate::description::Description;
use crate::progress;
use crate::workspace::Workspace;

/// Writes `modelDescription.xml` and `docs/variables.md`.
///
/// # Errors
/// The model doesn't compile, or a file can't be written.
pub fn run(workspace: &Workspace) -> anyhow::Result<()> {
    progress::headline("Reading the variable table");
    // A program of its own, because this tool doesn't link the model. It compiles as the tests do.
    let output = cargo::command(workspace)
        .args(["run", "--quiet", "--package", env!("CARGO_PKG_NAME")])
        .args(["--features", "model", "--bin", "model-description"])
        .stderr(Stdio::inherit())
        .output()
        .context("can't start cargo")?;
    ensure!(output.status.success(), "the variable table can't be read");
    let xml = String::from_utf8(output.stdout).context("the model description is not UTF-8")?;
    let description = Description::parse(&xml)?;
    write(&workspace.model_description(), &xml)?;
    let page = workspace.root().join("docs").join("variables.md");
    write(&page, &description.to_markdown())
}

fn write(path: &Path, text: &str) -> anyhow::Result<()> {
    fs::write(path, text).with_context(|| format!("can't write {}", path.display()))?;
    println!("{}", path.display());
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_checked_in_page_is_what_the_model_description_says() {
        let workspace = Workspace::find().unwrap();
        let xml = fs::read_to_string(workspace.model_description()).unwrap();
        let page = fs::read_to_string(workspace.root().join("docs").join("variables.md")).unwrap();
        let generated = Description::parse(&xml).unwrap().to_markdown();
        assert_eq!(page, generated, "rewrite docs/variables.md by `cargo fmu describe`");
    }
}
