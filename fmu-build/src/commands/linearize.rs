//! `cargo fmu linearize`: the linear model about a steady working point, for controller design.

use std::fs;
use std::path::PathBuf;

use anyhow::Context;
use clap::Args;

use crate::cargo;
use crate::progress;
use crate::workspace::Workspace;

/// The working point.
#[derive(Args)]
pub struct Arguments {
    /// Keep the modes below this frequency, Hz, as states
    #[arg(long, default_value_t = 50.0)]
    frequency: f64,
    /// File that is written [default: target/linear-model.json]
    #[arg(long)]
    output: Option<PathBuf>,
    /// Parameters and inputs of the working point, e.g. initial.ratio=2.2 secondary.clampingForce=15000
    #[arg(value_name = "NAME=VALUE")]
    settings: Vec<String>,
}

/// Writes A, B, C, D as JSON.
///
/// # Errors
/// There is no steady state at this working point, or the file can't be written.
pub fn run(workspace: &Workspace, arguments: &Arguments) -> anyhow::Result<()> {
    progress::headline("Finding the steady state and its modes");
    let frequency = arguments.frequency.to_string();
    let words: Vec<String> = std::iter::once(frequency)
        .chain(arguments.settings.iter().cloned())
        .collect();
    let model = cargo::example_output(workspace, "linear_model", &words).context("there is no linear model")?;
    let path = arguments
        .output
        .clone()
        .unwrap_or_else(|| workspace.target().join("linear-model.json"));
    fs::write(&path, model).with_context(|| format!("can't write {}", path.display()))?;
    println!("{}", path.display());
    Ok(())
}
