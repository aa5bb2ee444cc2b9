//! `cargo fmu docs`: the book of `docs/` with the API documentation and the live page, and a check of
//! its links.

use std::fs;
use std::path::Path;

use anyhow::{Context, ensure};

use crate::cargo;
use crate::commands::{describe, live_page};
use crate::mdbook::MdBook;
use crate::progress;
use crate::workspace::{self, Workspace};

/// In the place of the live page, which pages link to.
const NO_LIVE_PAGE: &str = "<!DOCTYPE html>\n<html lang=\"en\"><meta charset=\"utf-8\"><title>pushbelt, live</title>\
    <p>This book was built without its live page. Run <code>cargo fmu live</code>, then <code>cargo fmu docs</code>.</p></html>\n";

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
    mdbook.build(workspace, &workspace.root().join("docs"), &book)?;

    progress::headline("Documenting the Rust API");
    cargo::run(cargo::command(workspace).args(["doc", "--workspace", "--no-deps", "--locked"]))?;
    let api = book.join("api");
    workspace::copy_tree(&workspace.target().join("doc"), &api)?;

    copy_live(&live_page::path(workspace), &book.join("live.html"))?;

    progress::headline("Checking the links");
    let mut check = cargo::book_program(workspace, "check-links");
    cargo::run(check.arg(&book).arg(workspace.root()))?;
    println!("{}", book.join("index.html").display());
    Ok(())
}

/// Copies the live page into the book, or writes how to make it.
fn copy_live(page: &Path, to: &Path) -> anyhow::Result<()> {
    if page.is_file() {
        fs::copy(page, to).map(drop)
    } else {
        fs::write(to, NO_LIVE_PAGE)
    }
    .with_context(|| format!("can't write {}", to.display()))
}
