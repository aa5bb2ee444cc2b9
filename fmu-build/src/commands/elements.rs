//! `cargo fmu elements`: runs the model of single elements, whose results go to `target/elements`
//! and `elements/results`.

use std::process::Command;

use anyhow::Context;
use clap::Args;

use crate::cargo;
use crate::progress;
use crate::workspace::Workspace;

/// Words of the program.
#[derive(Args)]
#[command(disable_help_flag = true)]
pub struct Arguments {
    /// Cases and options of the program; --help lists them
    #[arg(required = true, trailing_var_arg = true, allow_hyphen_values = true)]
    words: Vec<String>,
}

/// Builds the program and runs it in the working directory.
///
/// # Errors
/// It doesn't build, or a case fails.
pub fn run(workspace: &Workspace, arguments: &Arguments) -> anyhow::Result<()> {
    let program = cargo::build_program(workspace, cargo::ELEMENTS)?;
    progress::headline("Running single elements");
    let folder = std::env::current_dir().context("there is no working directory")?;
    let mut program = Command::new(program);
    program
        .current_dir(folder)
        .arg("--output")
        .arg(workspace.target().join("elements"));
    cargo::run(program.args(&arguments.words))
}
