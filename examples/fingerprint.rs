//! A hash of every output bit of the manoeuvre, for each ring: a change that only moves code does
//! not change the hash.
//!
//! `cargo run --release --example fingerprint` prints a line per run: the case, the hash (over the
//! bits of all outputs after every step, and the profile at the end), and its work. Builds with the
//! same arithmetic agree in every bit on one kind of processor.
//!
//! `-- --write FILE` stores all outputs, and `-- --compare FILE` prints their differences from
//! those of another build, as a share of the range of each output in its case.

use std::error::Error;

use pushbelt::variator::Variator;
use pushbelt::variator::settings::{Parameters, RingModel};
use pushbelt_support::fingerprint::{Report, STEP};
use pushbelt_support::manoeuvre::Manoeuvre;

fn main() -> Result<(), Box<dyn Error>> {
    let trace = Manoeuvre::read().trace(STEP);
    let mut report = Report::of_arguments()?;
    let with = |change: &dyn Fn(&mut Parameters)| {
        let mut parameters = Parameters::default();
        change(&mut parameters);
        parameters
    };
    let launch = |model: RingModel| Manoeuvre::variator(with(&|p| p.ring_model = model));
    let all = trace.len();
    report.run("ALE", Variator::new(launch(RingModel::Ale))?, &trace, all)?;
    let one_cell = with(&|p| p.mesh.cells_per_element = 1);
    report.run("ALE, one cell an element", Variator::new(one_cell)?, &trace, all / 5)?;
    report.run("ALE0", Variator::new(launch(RingModel::Ale0))?, &trace, all)?;
    let in_space = with(&|p| (p.spatial, p.geometry.pulley_offset) = (true, 5e-4));
    report.run("ALE in space", Variator::new(in_space)?, &trace, 1000)?;
    report.finish()
}
