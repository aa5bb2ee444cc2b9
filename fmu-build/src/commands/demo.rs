//! `cargo fmu demo`: simulates the FMU on published data and writes a report.

use clap::Args;

use crate::cargo;
use crate::commands::program_with;
use crate::python::DEMO;
use crate::workspace::Workspace;

/// Options of the demo.
#[derive(Args)]
pub struct Arguments {
    /// Passed on to the program; `-- --help` lists its options
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    passed_on: Vec<String>,
}

/// Runs the demo, which prints the path of the report.
///
/// # Errors
/// The FMU doesn't build, or the demo fails.
pub fn run(workspace: &Workspace, arguments: &Arguments) -> anyhow::Result<()> {
    let mut demo = program_with(workspace, &DEMO, "pushbelt.demo", "demo", "Simulating")?;
    cargo::run(demo.args(&arguments.passed_on))
}
