//! The default experiment through the Rust API: 1 s of the laboratory variator in steps of 1 ms, as
//! CSV on stdout.
//!
//! `cargo run --release --example default_run > default.csv`. Numbers are printed in full, so they
//! read back bit by bit. The first argument, if any, is the number of steps.

use std::error::Error;
use std::io::Write;

use pushbelt::variator::run::Variator;
use pushbelt::variator::settings::Parameters;
use pushbelt::variator::settings::{Inputs, Outputs};

type Column = (&'static str, fn(&Outputs) -> f64);

/// Named as the variables of the FMU.
const COLUMNS: [Column; 12] = [
    ("thrustRatio", |o| o.thrust_ratio),
    ("belt.speed", |o| o.belt_speed),
    ("ring.speed", |o| o.ring_speed),
    ("primary.speed", |o| o.primary.speed),
    ("secondary.speed", |o| o.secondary.speed),
    ("ratio.geometric", |o| o.ratio_geometric),
    ("slip", |o| o.slip),
    ("primary.axialForce", |o| o.primary.axial_force),
    ("secondary.axialForce", |o| o.secondary.axial_force),
    ("efficiency", |o| o.efficiency),
    ("pushForce.max", |o| o.push_force_max),
    ("energy.residual", |o| o.energy_residual),
];

fn main() -> Result<(), Box<dyn Error>> {
    let steps: u32 = std::env::args().nth(1).map_or(Ok(1000), |text| text.parse())?;
    let inputs = Inputs::default();
    let mut variator = Variator::new(Parameters::default())?;
    variator.initialise(0.0, &inputs)?;
    for message in variator.take_messages() {
        eprintln!("{}", message.text);
    }

    let mut csv = std::io::stdout().lock();
    let names = COLUMNS.map(|(name, _)| name).join(",");
    writeln!(csv, "time,{names}")?;
    let mut row = |variator: &mut Variator| -> std::io::Result<()> {
        write!(csv, "{}", variator.time())?;
        let outputs = variator.outputs();
        for (_, value) in COLUMNS {
            write!(csv, ",{}", value(outputs))?;
        }
        writeln!(csv)
    };
    row(&mut variator)?;
    for step in 1..=steps {
        variator.advance(f64::from(step) / 1000.0, &inputs)?;
        row(&mut variator)?;
    }
    Ok(())
}
