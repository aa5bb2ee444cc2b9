//! `cargo fmu maps`: maps of the variator for vehicle simulations, their files, and a report.

use clap::Args;

use crate::cargo;
use crate::commands::python_program;
use crate::workspace::Workspace;

/// Options of the maps.
#[derive(Args)]
pub struct Arguments {
    /// Solve for 12 lines of points instead of 84
    #[arg(long)]
    short: bool,
    /// Passed on to the program, such as --variator belt155 or --beside maps.nc; `-- --help` lists its options
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    passed_on: Vec<String>,
}

/// Solves for the maps. The program prints what it writes.
///
/// # Errors
/// The FMU doesn't build, or no point has a steady state.
pub fn run(workspace: &Workspace, arguments: &Arguments) -> anyhow::Result<()> {
    let mut maps = python_program(workspace, "pushbelt.maps", "maps", "Solving for the maps")?;
    if arguments.short {
        maps.arg("--short");
    }
    cargo::run(maps.args(&arguments.passed_on))
}

/// Measures the time of the default maps.
///
/// # Errors
/// As [`run`].
pub fn measure(workspace: &Workspace) -> anyhow::Result<()> {
    let mut maps = python_program(workspace, "pushbelt.maps", "maps-measured", "Measuring the maps")?;
    cargo::run(maps.arg("--measure"))
}
