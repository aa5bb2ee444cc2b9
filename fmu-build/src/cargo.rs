//! Running cargo.

use std::io::BufReader;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use anyhow::{Context, bail};
use cargo_metadata::{Artifact, CrateType, Message};

use crate::workspace::{MODEL_PACKAGE, Workspace};

/// A cargo command at the top level of the workspace, with the cargo that started this tool.
pub fn command(workspace: &Workspace) -> Command {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command.current_dir(workspace.root());
    // `cargo run` sets these for the tool itself; build scripts of others would see them and compile anew.
    for (name, _) in std::env::vars_os() {
        if name.to_string_lossy().starts_with("CARGO_PKG_") {
            command.env_remove(name);
        }
    }
    command.env_remove("CARGO_MANIFEST_DIR");
    command.env_remove("CARGO_MANIFEST_PATH");
    command
}

/// Runs a command to its end.
///
/// # Errors
/// It can't be started, or reports a failure.
pub fn run(command: &mut Command) -> anyhow::Result<()> {
    let shown = show(command);
    let status = command.status().with_context(|| format!("can't start `{shown}`"))?;
    if !status.success() {
        bail!("`{shown}` failed ({status})");
    }
    Ok(())
}

/// Compiles the model's shared library, optimised, and returns where cargo put it.
///
/// # Errors
/// The compilation fails.
pub fn build_library(workspace: &Workspace) -> anyhow::Result<PathBuf> {
    library(command(workspace).arg("build"))
}

/// Runs a build command of cargo, or of what takes its place, for the model's shared library; returns where it lies.
///
/// # Errors
/// The compilation fails.
pub fn library(command: &mut Command) -> anyhow::Result<PathBuf> {
    let mut library = None;
    command.args(["--release", "--lib", "--package", MODEL_PACKAGE]);
    artifacts(command, |artifact| {
        if artifact.target.name == MODEL_PACKAGE && artifact.target.crate_types.contains(&CrateType::CDyLib) {
            library = artifact.filenames.into_iter().find(|file| {
                file.extension()
                    .is_some_and(|extension| ["so", "dylib", "dll"].contains(&extension))
            });
        }
    })?;
    library
        .map(Into::into)
        .context("cargo built no shared library: is `cdylib` still among the crate types?")
}

/// Compiles an example of the model, optimised, and returns where cargo put it.
///
/// # Errors
/// The compilation fails.
pub fn example(workspace: &Workspace, name: &str) -> anyhow::Result<PathBuf> {
    let mut build = command(workspace);
    build.args(["build", "--release", "--package", MODEL_PACKAGE, "--example", name]);
    let mut executable = None;
    artifacts(&mut build, |artifact| {
        if artifact.target.name == name {
            executable = artifact.executable;
        }
    })?;
    executable
        .map(Into::into)
        .with_context(|| format!("cargo built no example `{name}`"))
}

/// Runs a build command of cargo to its end and passes on what it built.
fn artifacts(command: &mut Command, mut take: impl FnMut(Artifact)) -> anyhow::Result<()> {
    let mut child = command
        .arg("--message-format=json-render-diagnostics")
        .stdout(Stdio::piped())
        .spawn()
        .context("can't start cargo")?;
    let output = child.stdout.take().context("cargo has no output")?;
    for message in Message::parse_stream(BufReader::new(output)) {
        if let Message::CompilerArtifact(artifact) = message? {
            take(artifact);
        }
    }
    if !child.wait()?.success() {
        bail!("`{}` failed", show(command));
    }
    Ok(())
}

fn show(command: &Command) -> String {
    std::iter::once(command.get_program())
        .chain(command.get_args())
        .map(|word| word.to_string_lossy())
        .collect::<Vec<_>>()
        .join(" ")
}
