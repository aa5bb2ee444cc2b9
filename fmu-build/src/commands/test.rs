//! `cargo fmu test`: the Rust tests, then the Python tests that drive the FMU, in two tiers.
//!
//! The first tier is for every edit: each part of the code, the packed FMU, one report of each
//! kind. Its Rust tests link the library that the FMU has, so that the model is compiled once for
//! both. The second tier, with `--all`, is everything: the programs under valgrind, the paper's
//! belts, documentation and the slow Python tests; and of the crates beside the belt, which are
//! compiled in seconds, the dev profile with debug assertions and checks of overflow.

use std::num::NonZero;
use std::thread;

use anyhow::{Context, ensure};
use clap::Args;
use serde_json::Value;

use crate::cargo;
use crate::commands::{build, side_by_side};
use crate::platform::Version;
use crate::progress;
use crate::python::{BUILDING, Environment, RUNNING};
use crate::workspace::{PAPER_PACKAGE, Workspace};

/// This tool. Its tests are compiled with the profile of the tool.
const TOOL: &str = env!("CARGO_PKG_NAME");

/// Packages whose Rust tests are in the second tier only.
const SECOND_TIER_PACKAGES: [&str; 1] = [PAPER_PACKAGE];

/// Files of Rust tests of other packages that are in the second tier only: they take long, or need
/// valgrind.
const SECOND_TIER: [&str; 2] = ["bounded_work", "sequences"];

/// Options of the tests.
#[derive(Args)]
pub struct Arguments {
    /// Run all tests, including those of the second tier
    #[arg(long, conflicts_with_all = ["windows", "passed_on"])]
    all: bool,
    /// Run only the Rust tests
    #[arg(long, conflicts_with = "python")]
    rust: bool,
    /// Run only the Python tests
    #[arg(long)]
    python: bool,
    /// Build the portable FMU and run its win64 library in wine; builds exchange stored states
    #[arg(long, conflicts_with_all = ["rust", "python"])]
    windows: bool,
    #[command(flatten)]
    build: build::Arguments,
    /// Passed on to `cargo test` (with --rust) or to pytest (with --python), which then choose from
    /// all tests
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
    // Beside each other, since packages wait for downloads, and the model takes one core: it is one
    // unit of compilation. Cargo compiles for one of them at a time.
    let (environment, ()) = side_by_side(
        || {
            if arguments.rust {
                return Ok(None);
            }
            let packages = || Environment::prepare(workspace, &RUNNING);
            side_by_side(packages, || build_fmus(workspace, arguments))
                .map(|(environment, ())| Some(environment))
        },
        || {
            if arguments.python {
                return Ok(());
            }
            rust_tests(workspace, arguments)
        },
    )?;
    environment.map_or(Ok(()), |environment| python_tests(&environment, arguments))
}

/// All that the Python tests read.
fn build_fmus(workspace: &Workspace, arguments: &Arguments) -> anyhow::Result<()> {
    build::run_both(workspace, &arguments.build)?;
    let here = build::Arguments::default();
    build::run_map(workspace, here, Version::Two)?;
    build::run_map(workspace, here, Version::Three)?;
    // Tests selected by the user may need it.
    if arguments.all || !arguments.passed_on.is_empty() {
        build::run_paper(workspace)?;
    }
    Ok(())
}

fn python_tests(environment: &Environment, arguments: &Arguments) -> anyhow::Result<()> {
    progress::headline("Python tests");
    let mut tests = environment.command();
    tests.args(["-m", "pytest", "-p", "no:cacheprovider", "--durations=5"]);
    // One more than the number of cores, since some tests wait for a browser or another program.
    let processes = thread::available_parallelism().map_or(1, NonZero::get).min(3) + 1;
    tests.args([
        "--dist=loadfile",
        "--no-loadscope-reorder",
        &format!("--numprocesses={processes}"),
    ]);
    if !arguments.all && arguments.passed_on.is_empty() {
        tests.arg("--first-tier");
    }
    let names_a_file = |word: &String| word.ends_with(".py") || word.contains(".py::");
    if !arguments.passed_on.iter().any(names_a_file) {
        tests.arg("tests/python");
    }
    cargo::run(tests.args(&arguments.passed_on))
}

/// The win64 library in wine, compared with those of Linux and of this machine.
fn windows_tests(workspace: &Workspace, passed_on: &[String]) -> anyhow::Result<()> {
    let portable = build::Arguments {
        portable: true,
        arm: false,
    };
    build::run(workspace, &portable)?;
    progress::headline("Compiling the library for this machine");
    let library = cargo::build_library(workspace)?;
    let tools = Environment::prepare(workspace, &BUILDING)?;
    let environment = Environment::prepare(workspace, &RUNNING)?;
    progress::headline("Windows tests");
    let mut tests = environment.command();
    // -rs prints the reasons of skipped tests.
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

fn rust_tests(workspace: &Workspace, arguments: &Arguments) -> anyhow::Result<()> {
    progress::headline("Rust tests");
    let test = |options: &[String]| {
        let mut tests = cargo::command(workspace);
        cargo::run(tests.arg("test").args(options))
    };
    let words = |text: &str| -> Vec<String> { text.split(' ').map(str::to_owned).collect() };
    if !arguments.passed_on.is_empty() {
        return test(&arguments.passed_on);
    }
    if arguments.all {
        // All targets with tests; clippy compiles the others.
        test(&words(&format!("--release --workspace --exclude {TOOL} --tests")))?;
        test(&words(&format!("--release --workspace --exclude {TOOL} --doc")))?;
        test(&words("--tests -p pushbelt-archive -p pushbelt-fmi -p pushbelt-solver"))?;
        return test(&words(&format!(
            "--package {TOOL} --profile tool --all-features -- --include-ignored"
        )));
    }
    let (chosen, left) = first_tier(&workspace.members()?)?;
    test(&chosen)?;
    test(&words(&format!("--package {TOOL} --profile tool")))?;
    println!(
        "Left to `cargo fmu test --all`: documentation tests, {}",
        left.join(", ")
    );
    Ok(())
}

/// Options of `cargo test` for the first tier, and the tests that these leave out, from the output
/// of `cargo metadata`.
fn first_tier(metadata: &Value) -> anyhow::Result<(Vec<String>, Vec<String>)> {
    let mut chosen = vec!["--release".to_owned(), "--lib".to_owned()];
    let mut left = Vec::new();
    for package in metadata["packages"].as_array().context("cargo names no packages")? {
        let name = package["name"].as_str().context("a package has a name")?;
        let targets: Vec<&Value> = package["targets"].as_array().into_iter().flatten().collect();
        let tested = |target: &&&Value| target["test"] == true;
        if name == TOOL || !targets.iter().any(|target| tested(&target)) {
            continue;
        }
        if SECOND_TIER_PACKAGES.contains(&name) {
            left.push(name.to_owned());
            continue;
        }
        chosen.extend(["--package".to_owned(), name.to_owned()]);
        for target in targets.iter().filter(tested) {
            let is_file = target["kind"]
                .as_array()
                .is_some_and(|kinds| kinds.iter().any(|kind| kind == "test"));
            let file = target["name"].as_str().context("a target has a name")?;
            if SECOND_TIER.contains(&file) {
                left.push(file.to_owned());
            } else if is_file {
                chosen.extend(["--test".to_owned(), file.to_owned()]);
            }
        }
    }
    Ok((chosen, left))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_first_tier_leaves_out_is_there() {
        let (chosen, mut left) = first_tier(&Workspace::find().unwrap().members().unwrap()).unwrap();
        left.sort_unstable();
        let mut expected: Vec<&str> = SECOND_TIER.into_iter().chain(SECOND_TIER_PACKAGES).collect();
        expected.sort_unstable();
        assert_eq!(left, expected);
        for word in ["pushbelt", "pushbelt-archive", "pushbelt-solver", "pushbelt-fmi", "fmi"] {
            assert!(chosen.iter().any(|chosen| chosen == word), "{word}: {chosen:?}");
        }
        assert!(
            !chosen.iter().any(|word| word == TOOL || left.contains(word)),
            "{chosen:?}"
        );
    }
}
