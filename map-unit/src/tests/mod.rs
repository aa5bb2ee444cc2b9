//! Equations, steps, stored states, tables. What the FMI layer does is tested with its own unit.

use std::path::{Path, PathBuf};

use pushbelt::variator::settings::{Inputs, Outputs};
use pushbelt_fmi::unit::{Experiment, Message, Unit};

use crate::settings::Settings;
use crate::unit::MapUnit;

mod cylinder;
mod files;
mod laws;
mod runs;
mod states;
mod tables;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../resources/maps")
}

fn settings() -> Settings {
    MapUnit::load(Some(&folder())).expect("the checked-in tables")
}

/// A unit that starts without remarks.
fn start(settings: &Settings) -> MapUnit {
    let mut remarks = Vec::new();
    let unit = MapUnit::start(settings, &Experiment::default(), &mut remarks).expect("a start");
    assert!(remarks.is_empty(), "{remarks:?}");
    unit
}

/// A step to a time, s, with inputs that are held or change at `rates`.
fn step(
    unit: &mut MapUnit,
    settings: &Settings,
    to: f64,
    rates: Option<Inputs>,
) -> Result<Vec<Message>, String> {
    let mut changing = settings.clone();
    changing.inputs = rates.unwrap_or(Inputs::ZERO);
    let mut remarks = Vec::new();
    let mut step = unit.begin(to, settings, rates.map(|_| &changing))?;
    unit.advance(to, &mut step, settings, &mut remarks)?;
    assert_eq!(unit.time(), to);
    Ok(remarks)
}

/// Steps of a length over a duration, s; the outputs then.
fn run(unit: &mut MapUnit, settings: &Settings, length: f64, duration: f64) -> Outputs {
    let begin = unit.time();
    for k in 1..=(duration / length).round() as usize {
        step(unit, settings, begin + length * k as f64, None).expect("a step");
    }
    outputs(unit)
}

fn outputs(unit: &mut MapUnit) -> Outputs {
    unit.readings(false).outputs.clone()
}
