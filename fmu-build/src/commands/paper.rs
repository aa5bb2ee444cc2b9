//! `cargo fmu paper`: the paper's examples with every ring model, on an FMU of its own, and a report.

use clap::Args;

use crate::cargo::{self, Program};
use crate::commands::{build, program_on};
use crate::python::RUNNING;
use crate::workspace::Workspace;

/// The example that runs the tests of rings alone.
const RINGS: &str = "paper_rings";

/// Options of the paper's examples.
#[derive(Args)]
pub struct Arguments {
    /// Run two load cases and coarse tests of rings
    #[arg(long)]
    short: bool,
    /// Passed on to the program; `-- --help` lists its options
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    passed_on: Vec<String>,
}

/// Runs the program, which prints where the report is.
///
/// # Errors
/// The FMU or the example doesn't build, or the simulation fails.
pub fn run(workspace: &Workspace, arguments: &Arguments) -> anyhow::Result<()> {
    let rings = cargo::build_program(workspace, Program::OfPaper(RINGS))?;
    let mut paper = program_on(
        workspace,
        &RUNNING,
        || build::run_paper(workspace),
        ("pushbelt.paper", "paper"),
        "Running the paper's examples",
    )?;
    paper.arg("--rings").arg(rings);
    if arguments.short {
        paper.arg("--short");
    }
    cargo::run(paper.args(&arguments.passed_on))
}
