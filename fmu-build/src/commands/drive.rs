//! `cargo fmu drive`: a car on the WLTC with the FMU as its variator, and a report.

use clap::Args;

use crate::cargo;
use crate::commands::python_program;
use crate::workspace::Workspace;

/// Options of the drive.
#[derive(Args)]
pub struct Arguments {
    /// Drive 30 s of the cycle instead of all 1800 s
    #[arg(long)]
    short: bool,
    /// Run vehicle and control as FMUs too, coupled by an SSP package in ecos and libcosim, and compare with the drive
    #[arg(long)]
    cosim: bool,
    /// Passed on to the program; `-- --help` lists its options
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    passed_on: Vec<String>,
}

/// Runs the program, which prints where the report is.
///
/// # Errors
/// The FMU doesn't build, or the simulation fails.
pub fn run(workspace: &Workspace, arguments: &Arguments) -> anyhow::Result<()> {
    let module = if arguments.cosim {
        "pushbelt.drive.cosim"
    } else {
        "pushbelt.drive"
    };
    let mut drive = python_program(workspace, module, "drive", "Driving")?;
    if arguments.short {
        drive.arg("--short");
    }
    cargo::run(drive.args(&arguments.passed_on))
}
