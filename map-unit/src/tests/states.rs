//! Stored states, and steps that can't be done.

use pushbelt::variator::settings::Drive;
use pushbelt_fmi::Archive;
use pushbelt_fmi::unit::{Experiment, Unit};

use super::{outputs, run, settings, start, step};
use crate::settings::Settings;
use crate::unit::MapUnit;

pub(super) fn written(unit: &mut MapUnit) -> Vec<u8> {
    let mut archive = Archive::writer();
    unit.serialize(&mut archive);
    archive.into_bytes()
}

pub(super) fn read(settings: &Settings, bytes: &[u8]) -> Option<MapUnit> {
    let mut unit = MapUnit::blank(settings, &Experiment::default()).expect("a blank unit");
    let mut archive = Archive::reader(bytes);
    unit.serialize(&mut archive);
    archive.finish().ok().map(|()| unit)
}

#[test]
fn a_stored_state_continues_bit_for_bit() {
    let mut settings = settings();
    let mut unit = start(&settings);
    settings.inputs.primary.torque = 65.0;
    run(&mut unit, &settings, 1e-2, 0.1);
    let mut other = read(&settings, &written(&mut unit)).expect("all bytes");
    assert_eq!(outputs(&mut other), outputs(&mut unit));
    settings.inputs.primary.clamping_force = 16e3;
    let [one, other] = [&mut unit, &mut other].map(|unit| run(unit, &settings, 1e-2, 0.3));
    assert_eq!(one, other);
}

/// A copy, stored bytes and a failed step restore every reading, also while a coefficient is set
/// and not yet in force.
#[test]
fn each_way_back_gives_every_reading() {
    let mut settings = settings();
    let mut unit = start(&settings);
    settings.inputs.primary.torque = 65.0;
    for friction in [0.09, 0.06] {
        settings.parameters.friction.pulley = friction;
        for _ in 0..2 {
            let expected = unit.readings(true).clone();
            let mut other = read(&settings, &written(&mut unit)).expect("all bytes");
            assert_eq!(*other.readings(true), expected, "bytes, {friction}");
            let mut failing = settings.clone();
            (failing.inputs.primary.torque, failing.parameters.friction.pulley) = (f64::NAN, 0.08);
            let to = unit.time() + 0.01;
            step(&mut unit, &failing, to, None).expect_err("no solution");
            assert_eq!(*unit.readings(true), expected, "a failed step, {friction}");
            let mut copy = unit.clone();
            let ends = [&mut unit, &mut copy, &mut other].map(|unit| {
                step(unit, &settings, to, None).expect("a step");
                unit.readings(true).clone()
            });
            assert!(
                ends.iter().all(|end| *end == ends[0]) && ends[0] != expected,
                "{friction}"
            );
        }
    }
}

#[test]
fn each_number_of_a_stored_state_is_checked() {
    let mut settings = settings();
    settings.parameters.primary.drive = Drive::Speed;
    let bytes = written(&mut start(&settings));
    // Speeds, ln i, time, thrust ratio and eight inputs.
    for number in 0..13 {
        for wild in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e308] {
            let mut bytes = bytes.clone();
            bytes[8 * number..8 * number + 8].copy_from_slice(&wild.to_le_bytes());
            // Which time fits is checked by the FMI layer.
            let fits = number == 3 && wild == 1e308;
            assert_eq!(read(&settings, &bytes).is_some(), fits, "{number}: {wild}");
        }
    }
}

/// Loads without a solution end in an error after a number of steps that is bounded. State and
/// inputs are then as before.
#[test]
fn a_step_without_a_solution_ends_and_leaves_all_as_before() {
    for (torque, to) in [(f64::INFINITY, 0.025), (f64::NAN, 1e3)] {
        let mut settings = settings();
        let mut unit = start(&settings);
        run(&mut unit, &settings, 1e-3, 0.02);
        let (bytes, before) = (written(&mut unit), outputs(&mut unit));
        let wanted = std::mem::replace(&mut settings.inputs.secondary.torque, torque);
        let failed = step(&mut unit, &settings, to, None);
        assert!(failed.is_err_and(|why| why.contains("no solution")));
        assert!(written(&mut unit) == bytes);
        assert_eq!(outputs(&mut unit), before);
        settings.inputs.secondary.torque = wanted;
        run(&mut unit, &settings, 5e-3, 5e-3);
    }
}
