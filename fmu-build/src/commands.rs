//! The commands, one file for each.

use std::path::PathBuf;
use std::process::Command;
use std::thread;

use anyhow::anyhow;

use crate::progress;
use crate::python::{Environment, Packages, RUNNING};
use crate::workspace::Workspace;

pub mod belt;
pub mod bench;
pub mod build;
pub mod calibrate;
pub mod compare;
pub mod demo;
pub mod describe;
pub mod docs;
pub mod drive;
pub mod durability;
pub mod linearize;
pub mod maps;
pub mod paper;
pub mod sweep;
pub mod test;
pub mod validate;
pub mod wheel;

/// Builds the FMU, installs the Python packages, and returns the command that starts a Python program with the FMU. Its
/// results go to a folder of this name below the target directory.
///
/// # Errors
/// The FMU doesn't build, or the packages can't be installed.
fn python_program(workspace: &Workspace, module: &str, folder: &str, headline: &str) -> anyhow::Result<Command> {
    program_with(workspace, &RUNNING, module, folder, headline)
}

/// The same for a program that needs these packages. They are installed while the FMU compiles.
fn program_with(
    workspace: &Workspace,
    packages: &Packages,
    module: &str,
    folder: &str,
    headline: &str,
) -> anyhow::Result<Command> {
    let build = || build::run(workspace, &build::Arguments::default());
    program_on(workspace, packages, build, (module, folder), headline)
}

/// The same for a program that runs the FMU that `build` makes.
///
/// # Errors
/// As [`python_program`].
fn program_on(
    workspace: &Workspace,
    packages: &Packages,
    build: impl FnOnce() -> anyhow::Result<PathBuf>,
    (module, folder): (&str, &str),
    headline: &str,
) -> anyhow::Result<Command> {
    let (fmu, environment) = side_by_side(build, || Environment::prepare(workspace, packages))?;
    progress::headline(headline);
    let mut program = environment.command();
    program
        .args(["-m", module, "--fmu"])
        .arg(fmu)
        .arg("--output")
        .arg(workspace.target().join(folder))
        .env("PUSHBELT_COMMAND", command_line(std::env::args().skip(1)));
    Ok(program)
}

/// The command that started this tool, for a shell: the reports name it.
fn command_line(arguments: impl Iterator<Item = String>) -> String {
    let plain = |word: &str| !word.is_empty() && word.chars().all(|c| c.is_alphanumeric() || "-_=./:,+@%".contains(c));
    let quoted = |word: String| {
        if plain(&word) {
            word
        } else {
            format!("'{}'", word.replace('\'', "'\"'\"'"))
        }
    };
    let words: Vec<String> = ["cargo".to_owned(), "fmu".to_owned()]
        .into_iter()
        .chain(arguments.map(quoted))
        .collect();
    words.join(" ")
}

/// Runs both at once and returns what both return.
///
/// # Errors
/// One of them fails. The error of the first is returned if both do.
fn side_by_side<A, B: Send>(
    first: impl FnOnce() -> anyhow::Result<A>,
    second: impl FnOnce() -> anyhow::Result<B> + Send,
) -> anyhow::Result<(A, B)> {
    thread::scope(|scope| {
        let second = scope.spawn(second);
        let first = first();
        let second = second.join().map_err(|_| anyhow!("a thread panicked"))?;
        Ok((first?, second?))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_can_be_pasted_into_a_shell() {
        let words = ["calibrate", "my table.csv", "--", "--map", "i=ratio.geometric", "it's"].map(str::to_owned);
        assert_eq!(
            command_line(words.into_iter()),
            "cargo fmu calibrate 'my table.csv' -- --map i=ratio.geometric 'it'\"'\"'s'"
        );
    }

    #[test]
    fn both_results_or_the_first_error_come_back() {
        assert_eq!(side_by_side(|| Ok(1), || Ok("two")).unwrap(), (1, "two"));
        let fails = |what: &'static str| move || anyhow::Result::<()>::Err(anyhow!(what));
        assert_eq!(side_by_side(fails("a"), fails("b")).unwrap_err().to_string(), "a");
        assert_eq!(side_by_side(|| Ok(()), fails("b")).unwrap_err().to_string(), "b");
    }
}
