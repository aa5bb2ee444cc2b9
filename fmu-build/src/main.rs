//! `cargo fmu …`: one tool to build, test, demonstrate and measure the pushbelt FMU.
//!
//! | module | content |
//! |---|---|
//! | [`commands`] | one file for each command |
//! | [`workspace`], [`platform`] | paths of the workspace, and the host's names for binaries |
//! | [`cargo`], [`python`], [`mdbook`] | the outside programs that do the work |
//! | [`portable`], [`binary`] | binaries for other machines, and what these need to load them |
//! | [`archive`], [`licenses`], [`description`], [`icons`] | what goes into the FMU beside the binary |
//! | [`progress`] | headlines on the terminal |

mod archive;
mod binary;
mod cargo;
mod commands;
mod date;
mod description;
mod exports;
mod icons;
mod licenses;
mod mdbook;
mod platform;
mod portable;
mod progress;
mod python;
mod workspace;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::workspace::Workspace;

/// Builds, tests, demonstrates and measures PushbeltVariator.fmu.
///
/// Times are for two processors. The first command takes three minutes more: it compiles the model and installs the Python
/// packages for all others.
#[derive(Parser)]
#[command(name = "cargo fmu", bin_name = "cargo fmu", version)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Compile the binary and pack target/PushbeltVariator.fmu, or with --fmi3 target/PushbeltVariator3.fmu (2 minutes; seconds if nothing changed)
    Build(commands::build::Options),
    /// Run the Rust tests, and the Python tests with the FMU (up to 30 minutes on two cores)
    Test(commands::test::Arguments),
    /// Simulate published load cases with the FMU and write target/demo/report.html (10 seconds)
    Demo(commands::demo::Arguments),
    /// Drive a car with the FMU on the WLTC and write target/drive/report.html (1 minute)
    Drive(commands::drive::Arguments),
    /// Run the paper's examples with every ring model and write target/paper/report.html (5 minutes)
    Paper(commands::paper::Arguments),
    /// Solve for 2288 steady states with the FMU and write target/sweep/report.html (1 minute)
    Sweep(commands::sweep::Arguments),
    /// Fit parameters to a table of measured steady points and write target/calibrate/report.html (1 minute for 60 points)
    Calibrate(commands::calibrate::Arguments),
    /// Put the FMU beside theory and measurements and write target/validate/report.html (3 minutes)
    Validate(commands::validate::Arguments),
    /// Write target/wheels/pushbelt-…-py3-none-any.whl, the Python package with the portable FMU inside (5 minutes)
    Wheel(commands::wheel::Arguments),
    /// Lay two runs over each other and write target/compare/report.html (seconds)
    Compare(commands::compare::Arguments),
    /// Measure the speed of the model (1 minute)
    Bench(commands::bench::Arguments),
    /// Write linear models A, B, C, D about steady working points and target/linearize/report.html (seconds)
    Linearize(commands::linearize::Arguments),
    /// Write modelDescription.xml, modelDescription3.xml, terminalsAndIcons.xml, docs/variables.md and python/pushbelt/_version.py from the variable table (seconds)
    Describe,
    /// Write the documentation as a book, target/book/index.html, and check its links (2 minutes; seconds if nothing
    /// changed)
    Docs,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let workspace = Workspace::find()?;
    match &arguments.command {
        Command::Build(arguments) => commands::build::run_options(&workspace, arguments),
        Command::Test(arguments) => commands::test::run(&workspace, arguments),
        Command::Demo(arguments) => commands::demo::run(&workspace, arguments),
        Command::Drive(arguments) => commands::drive::run(&workspace, arguments),
        Command::Paper(arguments) => commands::paper::run(&workspace, arguments),
        Command::Sweep(arguments) => commands::sweep::run(&workspace, arguments),
        Command::Calibrate(arguments) => commands::calibrate::run(&workspace, arguments),
        Command::Validate(arguments) => commands::validate::run(&workspace, arguments),
        Command::Wheel(arguments) => commands::wheel::run(&workspace, arguments),
        Command::Compare(arguments) => commands::compare::run(&workspace, arguments),
        Command::Bench(arguments) => commands::bench::run(&workspace, arguments),
        Command::Linearize(arguments) => commands::linearize::run(&workspace, arguments),
        Command::Describe => commands::describe::run(&workspace),
        Command::Docs => commands::docs::run(&workspace),
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory as _;

    #[test]
    fn the_command_line_is_consistent() {
        super::Arguments::command().debug_assert();
    }
}
