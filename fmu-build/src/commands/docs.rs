//! `cargo fmu docs`: the book of `docs/` with the API documentation, and whether its links hold.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, ensure};

use crate::cargo;
use crate::commands::describe;
use crate::links::Site;
use crate::mdbook::MdBook;
use crate::progress;
use crate::workspace::{self, Workspace};

/// Writes `target/book/`.
///
/// # Errors
/// A generated file is out of date, book or API documentation can't be made, or a link is broken.
pub fn run(workspace: &Workspace) -> anyhow::Result<()> {
    let outdated = describe::outdated(workspace)?;
    ensure!(
        outdated.is_empty(),
        "{} is out of date: `cargo fmu describe` writes it anew",
        outdated.join(", ")
    );
    let mdbook = MdBook::prepare(workspace)?;
    let _alone = workspace.lock("docs")?;
    let book = workspace.target().join("book");
    progress::headline("Making the book");
    mdbook.build(&workspace.root().join("docs"), &book)?;

    progress::headline("Documenting the Rust API");
    cargo::run(cargo::command(workspace).args(["doc", "--workspace", "--no-deps", "--locked"]))?;
    let api = book.join("api");
    workspace::copy_tree(&workspace.target().join("doc"), &api)?;

    progress::headline("Checking the links");
    let mut problems = Site::new(&book).check_all(&api)?;
    let mut tree = Site::new(workspace.root());
    for page in pages(workspace.root())? {
        problems.extend(tree.check(&page)?);
    }
    ensure!(
        problems.is_empty(),
        "the links don't hold:\n  {}",
        problems.join("\n  ")
    );
    println!("{}", book.join("index.html").display());
    Ok(())
}

/// Pages in Markdown at the top level, such as README.md.
fn pages(root: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let mut pages = Vec::new();
    for entry in fs::read_dir(root).with_context(|| format!("can't read {}", root.display()))? {
        let path = entry?.path();
        if path.extension().is_some_and(|extension| extension == "md") {
            pages.push(path);
        }
    }
    pages.sort();
    Ok(pages)
}
