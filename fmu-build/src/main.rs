//! `cargo fmu …`: one tool to build, test, demonstrate and measure the pushbelt FMU.
//!
//! | module | content |
//! |---|---|
//! | [`commands`] | one file for each command |
//! | [`workspace`], [`platform`] | paths of the workspace, and names of binaries by platform |
//! | [`cargo`], [`python`], [`mdbook`] | external programs |
//! | [`portable`], [`binary`] | binaries for other machines, and their requirements |
//! | [`archive`], [`licenses`], [`description`], [`icons`] | the other files of the FMU |
//! | [`progress`] | headlines on the terminal |

mod archive;
mod binary;
mod cargo;
mod commands;
mod date;
mod description;
mod exports;
#[allow(dead_code, reason = "the file is that of the FMU, which has other uses too")]
#[path = "../../crates/fmi/src/hash.rs"]
mod hash;
mod icons;
mod licenses;
mod mdbook;
mod platform;
mod portable;
mod progress;
mod python;
mod workspace;
mod wrapper;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::workspace::Workspace;

/// Builds, tests, demonstrates and measures PushbeltVariator.fmu.
#[derive(Parser)]
#[command(name = "cargo fmu", bin_name = "cargo fmu", version, after_help = TIMES)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

/// Durations of the commands, measured by `time cargo fmu …`. This is the only list of such times.
const TIMES: &str = "\
Times on two processor cores, once the model is compiled and the Python packages are installed:
  seconds      belt, build, demo, compare, describe, durability, linearize
  a minute     drive, sweep, calibrate (60 points), bench
  two minutes  maps
  minutes      test (3), validate (3), paper, docs
  15 minutes   test --all
wheel takes 7.7 minutes of processor time in an empty clone (two cores of an AMD EPYC), build --portable as much.
The first command of a new clone compiles and installs for two minutes more.";

#[derive(Subcommand)]
enum Command {
    /// Compile the binary and pack target/PushbeltVariator.fmu, or with --fmi3 target/PushbeltVariator3.fmu
    Build(commands::build::Options),
    /// Run the first tier of the Rust and Python tests, or with --all every test
    Test(commands::test::Arguments),
    /// Simulate published load cases with the FMU and write target/demo/report.html
    Demo(commands::demo::Arguments),
    /// Drive a car with the FMU on the WLTC and write target/drive/report.html
    Drive(commands::drive::Arguments),
    /// Compute the fatigue of the ring over a run and write target/durability/report.html
    Durability(commands::durability::Arguments),
    /// Run the paper's examples with every ring model and write target/paper/report.html
    Paper(commands::paper::Arguments),
    /// Solve for 2288 steady states with the FMU and write target/sweep/report.html
    Sweep(commands::sweep::Arguments),
    /// Write a parameter set for a belt of given dimensions to target/belt/
    Belt(commands::belt::Arguments),
    /// Solve for maps of the variator and write them as NetCDF, MATLAB, Modelica and CSV files and target/maps/report.html
    Maps(commands::maps::Arguments),
    /// Fit parameters to a table of measured steady points and write target/calibrate/report.html
    Calibrate(commands::calibrate::Arguments),
    /// Compare the FMU with theory and measurements and write target/validate/report.html
    Validate(commands::validate::Arguments),
    /// Write target/wheels/pushbelt-…-py3-none-any.whl, the Python package with the portable FMU inside
    Wheel(commands::wheel::Arguments),
    /// Compare two runs and write target/compare/report.html
    Compare(commands::compare::Arguments),
    /// Measure the speed of the model
    Bench(commands::bench::Arguments),
    /// Write linear models A, B, C, D about steady working points and target/linearize/report.html
    Linearize(commands::linearize::Arguments),
    /// Write modelDescription.xml, modelDescription3.xml, terminalsAndIcons.xml, docs/variables.md and python/pushbelt/_version.py from the variable table
    Describe,
    /// Write the documentation as a book, target/book/index.html, and check its links
    Docs,
}

fn main() -> ExitCode {
    if let Some(code) = wrapper::act() {
        return code;
    }
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
        Command::Durability(arguments) => commands::durability::run(&workspace, arguments),
        Command::Paper(arguments) => commands::paper::run(&workspace, arguments),
        Command::Sweep(arguments) => commands::sweep::run(&workspace, arguments),
        Command::Belt(arguments) => commands::belt::run(&workspace, arguments),
        Command::Maps(arguments) => commands::maps::run(&workspace, arguments),
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
