//! `cargo fmu test`: the Rust tests, then the Python tests that drive the FMU.

use std::num::NonZero;
use std::thread;

use anyhow::{anyhow, ensure};
use clap::Args;

use crate::cargo;
use crate::commands::build;
use crate::progress;
use crate::python::{BUILDING, Environment, RUNNING};
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
    /// Build the portable FMU and run its win64 library in wine; builds exchange stored states (10 minutes)
    #[arg(long, conflicts_with_all = ["rust", "python"])]
    windows: bool,
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
        arguments.passed_on.is_empty() || arguments.rust || arguments.python || arguments.windows,
        "`{}` needs --rust, --python or --windows beside it: cargo test or pytest gets it",
        arguments.passed_on.join(" ")
    );
    if arguments.windows {
        return windows_tests(workspace, &arguments.passed_on);
    }
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
        // One more than there are cores, since some wait for a browser or another program.
        let processes = thread::available_parallelism().map_or(1, NonZero::get).min(3) + 1;
        tests.args(["--dist=loadfile", &format!("--numprocesses={processes}")]);
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

/// The win64 library in wine, beside those of Linux and of this machine.
fn windows_tests(workspace: &Workspace, passed_on: &[String]) -> anyhow::Result<()> {
    build::run(workspace, &build::Arguments { portable: true })?;
    progress::headline("Compiling the library for this machine");
    let library = cargo::build_library(workspace)?;
    let tools = Environment::prepare(workspace, &BUILDING)?;
    let environment = Environment::prepare(workspace, &RUNNING)?;
    progress::headline("Windows tests");
    let mut tests = environment.command();
    // -rs prints why something is skipped.
    tests.args([
        "-m",
        "pytest",
        "-p",
        "no:cacheprovider",
        "-rs",
        "tests/python/test_windows.py",
    ]);
    tests.env("PUSHBELT_ZIG", tools.program("python"));
    tests.env("PUSHBELT_LIBRARY", library);
    tests.args(passed_on);
    cargo::run(&mut tests)
}

fn rust_tests(workspace: &Workspace, passed_on: &[String]) -> anyhow::Result<()> {
    progress::headline("Rust tests");
    let test = |what: &[&str]| {
        let mut tests = cargo::command(workspace);
        tests.arg("test").args(what).args(passed_on);
        cargo::run(&mut tests)
    };
    // Without a name cargo takes the package at the top level, the model.
    if passed_on.is_empty() {
        // All but the examples, which compile for a minute and hold no tests.
        test(&["--lib", "--tests"])?;
        test(&["--doc"])?;
        // The tool's own, as the tool is compiled. One of them builds the model, so they are last.
        test(&["--package", env!("CARGO_PKG_NAME"), "--profile", "tool"])
    } else {
        test(&[])
    }
}
