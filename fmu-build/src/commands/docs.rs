//! `cargo fmu docs`: the book of `docs/` with the API documentation, and a check of its links.

use anyhow::ensure;

use crate::cargo;
use crate::commands::describe;
use crate::mdbook::MdBook;
use crate::progress;
use crate::workspace::{self, Workspace};

/// Writes `target/book/`.
///
/// # Errors
/// A generated file is out of date, book or API documentation can't be built, or a link is broken.
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
    let mut check = cargo::command(workspace);
    check.args([
        "run",
        "--profile",
        "tool",
        "--quiet",
        "--package",
        env!("CARGO_PKG_NAME"),
    ]);
    check.args(["--features", "links", "--bin", "check-links", "--"]);
    cargo::run(check.arg(&book).arg(workspace.root()))?;
    println!("{}", book.join("index.html").display());
    Ok(())
}
