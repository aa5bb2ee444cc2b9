//! `cargo fmu durability`: fatigue of the ring over runs, and a report.

use std::path::PathBuf;

use anyhow::Context;
use clap::Args;

use crate::cargo;
use crate::commands::python_program;
use crate::workspace::Workspace;

/// The run.
#[derive(Args)]
pub struct Arguments {
    /// A result file of a run, or the folder of a drive
    run: PathBuf,
    /// Passed on to the program: further runs and options; `-- --help` lists them
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    passed_on: Vec<String>,
}

/// Runs the program, which prints where the report is.
///
/// # Errors
/// The FMU doesn't build, or a file has no usable run.
pub fn run(workspace: &Workspace, arguments: &Arguments) -> anyhow::Result<()> {
    // The program runs at the top level of the workspace.
    let run = std::path::absolute(&arguments.run).with_context(|| format!("can't find {}", arguments.run.display()))?;
    let mut durability = python_program(workspace, "pushbelt.durability", "durability", "Fatigue of the ring")?;
    cargo::run(durability.arg(run).args(&arguments.passed_on))
}
