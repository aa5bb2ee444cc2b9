//! `cargo fmu validate`: comparison of the FMU with theory and measurements, and a report.

use clap::Args;

use crate::cargo;
use crate::commands::python_program;
use crate::workspace::Workspace;

/// Options of the validation.
#[derive(Args)]
pub struct Arguments {
    /// Solve for few points of each section
    #[arg(long)]
    short: bool,
    /// Passed on to the program, such as --section shifting; `-- --help` lists its options
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    passed_on: Vec<String>,
}

/// Runs the validation, which prints missed goals and the path of the report.
///
/// # Errors
/// The FMU doesn't build, or it can't be run.
pub fn run(workspace: &Workspace, arguments: &Arguments) -> anyhow::Result<()> {
    let mut validate = python_program(workspace, "pushbelt.validate", "validate", "Comparing")?;
    if arguments.short {
        validate.arg("--short");
    }
    cargo::run(validate.args(&arguments.passed_on))
}
