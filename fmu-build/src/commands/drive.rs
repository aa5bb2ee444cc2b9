//! `cargo fmu drive`: a car on the WLTC with the FMU as its variator, and a report.

use clap::Args;

use crate::cargo;
use crate::commands::program;
use crate::workspace::Workspace;

/// How to drive.
#[derive(Args)]
pub struct Arguments {
    /// 30 s of the cycle instead of all 1800 s
    #[arg(long)]
    short: bool,
    /// Couple variator, vehicle and control as FMUs in other masters, by an SSP package, and compare with the drive
    #[arg(long)]
    cosim: bool,
    /// Passed on to the program; `-- --help` lists what it takes
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
    let mut drive = program(workspace, module, "drive", "Driving")?;
    if arguments.short {
        drive.arg("--short");
    }
    cargo::run(drive.args(&arguments.passed_on))
}
