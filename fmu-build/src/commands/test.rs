//! `cargo fmu test`: the Rust tests, then the Python tests that drive the FMU.

use anyhow::ensure;
use clap::Args;

use crate::cargo;
use crate::commands::build;
use crate::progress;
use crate::python::{Environment, RUNNING};
use crate::workspace::Workspace;

/// What to test.
#[derive(Args)]
pub struct Arguments {
    /// Only the Rust tests
    #[arg(long, conflicts_with = "python")]
    rust: bool,
    /// Only the Python tests
    #[arg(long)]
    python: bool,
    #[command(flatten)]
    build: build::Arguments,
    /// Passed on to `cargo test` (with --rust) or to pytest (with --python)
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    passed_on: Vec<String>,
}

/// Runs the tests.
///
/// # Errors
/// The FMU doesn't build, or a test fails.
pub fn run(workspace: &Workspace, arguments: &Arguments) -> anyhow::Result<()> {
    ensure!(
        arguments.passed_on.is_empty() || arguments.rust || arguments.python,
        "say with --rust or --python where `{}` is to go",
        arguments.passed_on.join(" ")
    );
    build::run(workspace, &arguments.build)?;
    if !arguments.python {
        progress::headline("Rust tests");
        let mut tests = cargo::command(workspace);
        tests.args(["test", "--workspace"]).args(&arguments.passed_on);
        cargo::run(&mut tests)?;
    }
    if !arguments.rust {
        let environment = Environment::prepare(workspace, &RUNNING)?;
        progress::headline("Python tests");
        let mut tests = environment.command();
        tests.args(["-m", "pytest", "-p", "no:cacheprovider", "--durations=5"]);
        tests.args(["--numprocesses=auto", "--maxprocesses=4", "--dist=loadfile"]);
        if !arguments
            .passed_on
            .iter()
            .any(|word| word.ends_with(".py") || word.contains(".py::"))
        {
            tests.arg("tests/python");
        }
        tests.args(&arguments.passed_on);
        cargo::run(&mut tests)?;
    }
    Ok(())
}
