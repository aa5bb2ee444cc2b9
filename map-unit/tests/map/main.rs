//! The variator from maps: equations, steps, stored states, tables. What the FMI layer does is tested with its own unit.

use std::path::{Path, PathBuf};

use pushbelt::variator::settings::{Inputs, Outputs};
use pushbelt_fmi::Archive;
use pushbelt_fmi::unit::{Experiment, Remark, Unit};
use pushbelt_map_unit::settings::Settings;
use pushbelt_map_unit::unit::MapUnit;

mod cylinder;
mod files;
mod runs;
mod states;

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
fn try_step(unit: &mut MapUnit, settings: &Settings, to: f64, rates: Option<Inputs>) -> Result<Vec<Remark>, String> {
    let rates = rates.map(|inputs| Settings {
        inputs,
        ..settings.clone()
    });
    let mut remarks = Vec::new();
    let mut step = unit.begin(to, settings, rates.as_ref())?;
    unit.advance(to, &mut step, settings, &mut remarks)?;
    assert_eq!(unit.time(), to);
    Ok(remarks)
}

fn step(unit: &mut MapUnit, settings: &Settings, to: f64) -> Vec<Remark> {
    try_step(unit, settings, to, None).expect("a step")
}

/// Steps of a length over a duration, s.
fn run(unit: &mut MapUnit, settings: &Settings, length: f64, duration: f64) -> Outputs {
    let begin = unit.time();
    for k in 1..=(duration / length).round() as usize {
        step(unit, settings, begin + length * k as f64);
    }
    outputs(unit)
}

fn outputs(unit: &mut MapUnit) -> Outputs {
    unit.readings(false).outputs.clone()
}

fn written(unit: &mut MapUnit) -> Vec<u8> {
    let mut archive = Archive::writer();
    unit.serialize(&mut archive);
    archive.into_bytes()
}

fn read(settings: &Settings, bytes: &[u8]) -> Option<MapUnit> {
    let mut unit = MapUnit::blank(settings, &Experiment::default()).expect("a blank unit");
    let mut archive = Archive::reader(bytes);
    unit.serialize(&mut archive);
    archive.finish().ok().map(|()| unit)
}
