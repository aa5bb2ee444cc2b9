//! Checks the links of the book, and of the pages in Markdown at the top level of the source tree;
//! `cargo fmu docs` runs it.
//!
//! It is a separate program, because the other commands need no parsers of HTML and Markdown and
//! compile faster without them.

mod page;
mod site;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, ensure};

use crate::site::Site;

/// Folder of the API documentation below the book. rustdoc checks its links.
const API: &str = "api";

fn main() -> ExitCode {
    match check() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn check() -> anyhow::Result<()> {
    let folders: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let [book, tree] = folders.as_slice() else {
        anyhow::bail!("usage: check-links BOOK SOURCE-TREE");
    };
    let mut problems = Site::new(book).check_all(&book.join(API))?;
    let mut site = Site::new(tree);
    for page in pages(tree)? {
        problems.extend(site.check(&page)?);
    }
    ensure!(problems.is_empty(), "broken links:\n  {}", problems.join("\n  "));
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
