//! `cargo fmu paper`: the paper's examples again with every ring model, and a report.

use clap::Args;

use crate::cargo;
use crate::commands::program;
use crate::workspace::Workspace;

/// The example that runs the tests of rings alone.
const RINGS: &str = "paper_rings";

/// How much of it.
#[derive(Args)]
pub struct Arguments {
    /// Two load cases and coarse tests of rings, in less than a minute
    #[arg(long)]
    short: bool,
    /// Passed on to the program; `-- --help` lists what it takes
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    passed_on: Vec<String>,
}

/// Runs the program, which prints where the report is.
///
/// # Errors
/// The FMU or the example doesn't build, or the simulation fails.
pub fn run(workspace: &Workspace, arguments: &Arguments) -> anyhow::Result<()> {
    let rings = cargo::example(workspace, RINGS)?;
    let mut paper = program(workspace, "pushbelt.paper", "paper", "Running the paper's examples")?;
    paper.arg("--rings").arg(rings);
    if arguments.short {
        paper.arg("--short");
    }
    cargo::run(paper.args(&arguments.passed_on))
}
