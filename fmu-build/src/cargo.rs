//! Running cargo.

use std::ffi::OsStr;
use std::io::BufReader;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use anyhow::{Context, bail, ensure};
use cargo_metadata::{Artifact, CrateType, Message};

use crate::workspace::{MODEL_PACKAGE, Workspace};

/// The example that prints the model description.
pub const DESCRIPTION_EXAMPLE: &str = "model_description";

/// A cargo command at the top level of the workspace, with the cargo that started this tool.
pub fn command(workspace: &Workspace) -> Command {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    command_of(workspace, cargo)
}

/// The same for a program that takes cargo's place.
pub fn command_of(workspace: &Workspace, program: impl AsRef<OsStr>) -> Command {
    let mut command = Command::new(program);
    command.current_dir(workspace.root());
    clear_own(&mut command);
    command
}

/// Removes from a program's environment what `cargo run` sets for the tool itself: build scripts of others would see it, and cargo
/// would compile anew.
pub fn clear_own(command: &mut Command) {
    for (name, _) in std::env::vars_os() {
        let text = name.to_string_lossy();
        if text.starts_with("CARGO_PKG_") || text.starts_with("CARGO_MANIFEST_") {
            command.env_remove(name);
        }
    }
}

/// Runs a command to its end.
///
/// # Errors
/// It can't be started, or reports a failure.
pub fn run(command: &mut Command) -> anyhow::Result<()> {
    let line = shown(command);
    let status = command.status().with_context(|| format!("can't start `{line}`"))?;
    if !status.success() {
        bail!("`{line}` failed ({status})");
    }
    Ok(())
}

/// A program that comes with the model's library.
#[derive(Clone, Copy)]
pub enum Program {
    /// In `examples/`.
    Example(&'static str),
    /// In `benches/`.
    Bench(&'static str),
}

/// Compiles the model's shared library, optimised for this machine, and returns its path.
///
/// # Errors
/// The compilation fails.
pub fn build_library(workspace: &Workspace) -> anyhow::Result<PathBuf> {
    shared_library(release(workspace, Program::Example(DESCRIPTION_EXAMPLE)).arg("--lib"))
}

/// Compiles the model's shared library with a command that takes the place of `cargo build`, and returns its path.
///
/// # Errors
/// The compilation fails.
pub fn build_library_with(command: &mut Command) -> anyhow::Result<PathBuf> {
    shared_library(command.args(["--release", "--lib", "--package", MODEL_PACKAGE]))
}

/// Compiles a program, optimised for this machine, and returns its path.
///
/// # Errors
/// The compilation fails.
pub fn build_program(workspace: &Workspace, program: Program) -> anyhow::Result<PathBuf> {
    let (Program::Example(name) | Program::Bench(name)) = program;
    let mut executable = None;
    compile(&mut release(workspace, program), |artifact| {
        if artifact.target.name == name {
            executable = artifact.executable;
        }
    })?;
    executable
        .map(Into::into)
        .with_context(|| format!("cargo built no program `{name}`"))
}

/// Compiles and starts an example, optimised for this machine; its messages go to the terminal. Returns what it prints.
///
/// # Errors
/// The compilation fails, the example fails, or it prints something else than text.
pub fn example_output(workspace: &Workspace, name: &'static str, arguments: &[String]) -> anyhow::Result<String> {
    let mut example = Command::new(build_program(workspace, Program::Example(name))?);
    let output = example
        .current_dir(workspace.root())
        .args(arguments)
        .stderr(Stdio::inherit())
        .output()
        .with_context(|| format!("can't start `{name}`"))?;
    ensure!(output.status.success(), "`{name}` failed ({})", output.status);
    String::from_utf8(output.stdout).with_context(|| format!("`{name}` prints no UTF-8"))
}

/// The build command of everything that is optimised for this machine. It always asks for a program, for the library alone
/// too: cargo then counts the features that development dependencies want, so that one compiled library serves all.
fn release(workspace: &Workspace, program: Program) -> Command {
    let mut build = command(workspace);
    build.args(["build", "--release", "--package", MODEL_PACKAGE]);
    match program {
        Program::Example(name) => build.args(["--example", name]),
        Program::Bench(name) => build.args(["--bench", name]),
    };
    build
}

fn shared_library(build: &mut Command) -> anyhow::Result<PathBuf> {
    let mut library = None;
    compile(build, |artifact| {
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

/// Runs a build command to its end and passes on every artifact, also those that need no compilation.
fn compile(build: &mut Command, mut built: impl FnMut(Artifact)) -> anyhow::Result<()> {
    let mut child = build
        .arg("--message-format=json-render-diagnostics")
        .stdout(Stdio::piped())
        .spawn()
        .context("can't start cargo")?;
    let output = child.stdout.take().context("cargo has no output")?;
    for message in Message::parse_stream(BufReader::new(output)) {
        if let Message::CompilerArtifact(artifact) = message? {
            built(artifact);
        }
    }
    if !child.wait()?.success() {
        bail!("`{}` failed", shown(build));
    }
    Ok(())
}

fn shown(command: &Command) -> String {
    std::iter::once(command.get_program())
        .chain(command.get_args())
        .map(|word| word.to_string_lossy())
        .collect::<Vec<_>>()
        .join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a build command compiles, by name.
    fn compiled(mut build: Command) -> Vec<String> {
        let mut names = Vec::new();
        compile(&mut build, |artifact| {
            if !artifact.fresh {
                names.push(artifact.target.name);
            }
        })
        .expect("a build");
        names
    }

    #[test]
    fn commands_share_one_optimised_library() {
        let workspace = Workspace::find().expect("the workspace");
        let library = || {
            let mut build = release(&workspace, Program::Example(DESCRIPTION_EXAMPLE));
            build.arg("--lib");
            build
        };
        let other = || release(&workspace, Program::Example("default_run"));
        compiled(library());
        let for_other = compiled(other());
        let expected = for_other.iter().all(|name| name == "default_run");
        assert!(expected, "the second command compiles {for_other:?}");
        assert_eq!(
            compiled(library()),
            Vec::<String>::new(),
            "compiled again for the first command"
        );
        assert_eq!(
            compiled(other()),
            Vec::<String>::new(),
            "compiled again for the second command"
        );
    }
}
