//! `cargo fmu …`: one tool to build, test, demonstrate and measure the pushbelt FMU.
//!
//! | module | idea |
//! |---|---|
//! | [`commands`] | one file a command: what the user asks for |
//! | [`workspace`], [`platform`] | where things lie, and what the host's binaries are called |
//! | [`cargo`], [`python`] | the two outside programs that do the work |
//! | [`portable`], [`binary`] | binaries for other machines, and what they ask of them |
//! | [`archive`], [`licenses`], [`description`], [`image`] | what goes into the FMU beside the binary |
//! | [`mdbook`], [`links`] | the book of `docs/`, and whether its links hold |
//! | [`progress`] | what the user sees meanwhile |

mod archive;
mod binary;
mod cargo;
mod commands;
mod description;
mod image;
mod licenses;
mod links;
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
#[derive(Parser)]
#[command(name = "cargo fmu", bin_name = "cargo fmu", version)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Compile the binary and pack target/PushbeltVariator.fmu
    Build(commands::build::Arguments),
    /// Build the FMU, then run the Rust tests and the Python tests that drive it
    Test(commands::test::Arguments),
    /// Build the FMU, simulate it on published data and write target/demo/report.html
    Demo(commands::demo::Arguments),
    /// Build the FMU, drive a car with it on the WLTC and write target/drive/report.html
    Drive(commands::drive::Arguments),
    /// Build the FMU, run the paper's examples with every ring model and write target/paper/report.html
    Paper(commands::paper::Arguments),
    /// Build the FMU, solve for its steady states over a grid, on a cluster if need be, and write
    /// target/sweep/report.html
    Sweep(commands::sweep::Arguments),
    /// Measure the speed of the model
    Bench(commands::bench::Arguments),
    /// Write A, B, C, D at a steady working point as JSON
    Linearize(commands::linearize::Arguments),
    /// Write modelDescription.xml, docs/variables.md and python/pushbelt/_version.py from the variable table
    Describe,
    /// Write the documentation as a book, target/book/index.html, and check its links
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
        Command::Build(arguments) => commands::build::run(&workspace, arguments).map(drop),
        Command::Test(arguments) => commands::test::run(&workspace, arguments),
        Command::Demo(arguments) => commands::demo::run(&workspace, arguments),
        Command::Drive(arguments) => commands::drive::run(&workspace, arguments),
        Command::Paper(arguments) => commands::paper::run(&workspace, arguments),
        Command::Sweep(arguments) => commands::sweep::run(&workspace, arguments),
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
