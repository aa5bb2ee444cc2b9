//! `cargo fmu test`: the Rust tests, then the Python tests that drive the FMU.

use std::thread;

use anyhow::{anyhow, ensure};
use clap::Args;

use crate::cargo;
use crate::commands::build;
use crate::progress;
use crate::python::{Environment, RUNNING};
use crate::workspace::Workspace;

/// Options of the tests.
#[derive(Args)]
pub struct Arguments {
    /// Run only the Rust tests
    #[arg(long, conflicts_with = "python")]
    rust: bool,
    /// Run only the Python tests
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
        "`{}` needs --rust or --python beside it: cargo test or pytest gets it",
        arguments.passed_on.join(" ")
    );
    // The FMU and the packages are ready by the time the Rust tests are through: these compile one crate after the
    // other for minutes.
    let environment = thread::scope(|scope| {
        let ready = scope.spawn(|| -> anyhow::Result<Option<Environment>> {
            build::run_both(workspace, &arguments.build)?;
            let needed = !arguments.rust;
            needed.then(|| Environment::prepare(workspace, &RUNNING)).transpose()
        });
        let tested = if arguments.python {
            Ok(())
        } else {
            rust_tests(workspace, &arguments.passed_on)
        };
        let environment = ready.join().map_err(|_| anyhow!("the build panicked"))?;
        tested.and(environment)
    })?;
    if let Some(environment) = environment {
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

fn rust_tests(workspace: &Workspace, passed_on: &[String]) -> anyhow::Result<()> {
    progress::headline("Rust tests");
    let test = |what: &[&str]| {
        let mut tests = cargo::command(workspace);
        tests.args(["test", "--workspace"]).args(what).args(passed_on);
        cargo::run(&mut tests)
    };
    if passed_on.is_empty() {
        // All but the examples, which compile for a minute and hold no tests.
        test(&["--lib", "--bins", "--tests"])?;
        test(&["--doc"])
    } else {
        test(&[])
    }
}
