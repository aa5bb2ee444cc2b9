//! The commands, one file for each.

use std::process::Command;

use crate::progress;
use crate::python::{Environment, RUNNING};
use crate::workspace::Workspace;

pub mod bench;
pub mod build;
pub mod calibrate;
pub mod compare;
pub mod demo;
pub mod describe;
pub mod docs;
pub mod drive;
pub mod linearize;
pub mod paper;
pub mod sweep;
pub mod test;
pub mod validate;
pub mod wheel;

/// Builds the FMU, installs the Python packages, and returns the command that starts a Python program with the FMU. Its
/// results go to a folder of this name below the target directory.
///
/// # Errors
/// The FMU doesn't build, or the packages can't be installed.
fn python_program(workspace: &Workspace, module: &str, folder: &str, headline: &str) -> anyhow::Result<Command> {
    let fmu = build::run(workspace, &build::Arguments::default())?;
    let environment = Environment::prepare(workspace, &RUNNING)?;
    progress::headline(headline);
    let mut program = environment.command();
    program
        .args(["-m", module, "--fmu"])
        .arg(fmu)
        .arg("--output")
        .arg(workspace.target().join(folder));
    Ok(program)
}
