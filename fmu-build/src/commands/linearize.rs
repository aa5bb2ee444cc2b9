//! `cargo fmu linearize`: linear models about steady working points, for controller design.

use clap::Args;

use crate::cargo;
use crate::commands::python_program;
use crate::workspace::Workspace;

/// The working points.
#[derive(Args)]
pub struct Arguments {
    /// Parameters and inputs of the working points, e.g. initial.ratio=0.5,1,2 primary.torque=60, and options of the
    /// program; `-- --help` lists them
    #[arg(value_name = "NAME=VALUE", trailing_var_arg = true, allow_hyphen_values = true)]
    passed_on: Vec<String>,
}

/// Runs the program, which prints what it writes.
///
/// # Errors
/// The FMU doesn't build, or there is no steady state at any of the points.
pub fn run(workspace: &Workspace, arguments: &Arguments) -> anyhow::Result<()> {
    let mut linearize = python_program(workspace, "pushbelt.linearize", "linearize", "Linear models")?;
    cargo::run(linearize.args(&arguments.passed_on))
}
