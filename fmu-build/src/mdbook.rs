//! mdBook, which builds the book of `docs/`: one version from crates.io, installed below the target
//! directory.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, bail};

use crate::cargo;
use crate::progress;
use crate::workspace::Workspace;

/// The required version.
const VERSION: &str = "0.4.52";

/// mdBook as a program.
pub struct MdBook {
    program: PathBuf,
}

impl MdBook {
    /// Installs mdBook unless this version is there.
    ///
    /// # Errors
    /// It can't be installed.
    pub fn prepare(workspace: &Workspace) -> anyhow::Result<Self> {
        let _alone = workspace.lock("mdbook")?;
        let folder = workspace.target().join("mdbook");
        let program = folder
            .join("bin")
            .join(format!("mdbook{}", std::env::consts::EXE_SUFFIX));
        if version(&program).as_deref() != Some(VERSION) {
            progress::headline(&format!("Installing mdBook {VERSION} in target/mdbook"));
            install(workspace, &folder)?;
        }
        Ok(Self { program })
    }

    /// Builds the book of a folder. A warning of mdBook, such as a missing file, is an error.
    ///
    /// # Errors
    /// The book can't be built, an equation is not typeset, or mdBook warns.
    pub fn build(&self, workspace: &Workspace, book: &Path, output: &Path) -> anyhow::Result<()> {
        // In the source tree, where cargo finds the program that typesets the equations.
        let done = cargo::command_of(workspace, &self.program)
            .arg("build")
            .arg(book)
            .arg("--dest-dir")
            .arg(output)
            .env_remove("RUST_LOG")
            .output()
            .context("can't start mdBook")?;
        let messages = String::from_utf8_lossy(&done.stderr);
        let warned = ["[WARN]", "[ERROR]"].iter().any(|mark| messages.contains(mark));
        if warned || !done.status.success() {
            bail!("mdBook is not content with {}:\n{messages}", book.display());
        }
        Ok(())
    }
}

/// Compiles mdBook without optimisation, which suffices to build the book in two seconds. It has a
/// separate build folder, which is removed afterwards.
fn install(workspace: &Workspace, folder: &Path) -> anyhow::Result<()> {
    let build = folder.join("build");
    let mut install = cargo::command(workspace);
    install
        .args([
            "install",
            "mdbook",
            "--version",
            VERSION,
            "--locked",
            "--force",
            "--debug",
            "--quiet",
        ])
        .args(["--no-default-features", "--features", "search"])
        .arg("--root")
        .arg(folder)
        .env("CARGO_TARGET_DIR", &build)
        .env("CARGO_PROFILE_DEV_OPT_LEVEL", "0")
        .env("CARGO_PROFILE_DEV_DEBUG", "0");
    cargo::run(&mut install)?;
    fs::remove_dir_all(&build).with_context(|| format!("can't remove {}", build.display()))
}

/// The version of a program; none if it doesn't run.
fn version(program: &Path) -> Option<String> {
    let output = Command::new(program).arg("--version").output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    Some(text.trim().strip_prefix("mdbook v")?.to_owned())
}
