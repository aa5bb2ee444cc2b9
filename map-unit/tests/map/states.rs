//! Stored states, and steps that can't be done.

use pushbelt::variator::settings::Drive;
use pushbelt_fmi::Unit;

use crate::{outputs, read, run, settings, start, step, try_step, written};

#[test]
fn a_stored_state_continues_bit_for_bit() {
    let mut settings = settings();
    let mut unit = start(&settings);
    settings.inputs.primary.torque = 65.0;
    run(&mut unit, &settings, 1e-2, 0.1);
    let mut other = read(&settings, &written(&mut unit)).expect("all bytes");
    settings.inputs.primary.clamping_force = 16e3;
    assert_eq!(
        run(&mut other, &settings, 1e-2, 0.3),
        run(&mut unit, &settings, 1e-2, 0.3)
    );
}

#[test]
fn each_number_of_a_stored_state_is_checked() {
    let mut settings = settings();
    settings.parameters.primary.drive = Drive::Speed;
    let bytes = written(&mut start(&settings));
    assert!(read(&settings, &bytes).is_some());
    // Speeds, ln i, time, thrust ratio and six inputs.
    for number in 0..11 {
        for wild in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e308] {
            let mut bytes = bytes.clone();
            bytes[8 * number..8 * number + 8].copy_from_slice(&wild.to_le_bytes());
            // Which time fits is checked by the FMI layer.
            let fits = number == 3 && wild == 1e308;
            assert_eq!(read(&settings, &bytes).is_some(), fits, "{number}: {wild}");
        }
    }
}

/// Loads without a solution end in an error after a number of steps that is bounded. State, inputs and friction are then as before.
#[test]
fn a_step_without_a_solution_ends_and_leaves_all_as_before() {
    for (torque, to) in [(f64::INFINITY, 0.025), (f64::NAN, 1e3)] {
        let mut settings = settings();
        let mut unit = start(&settings);
        run(&mut unit, &settings, 1e-3, 0.02);
        let (bytes, before) = (written(&mut unit), outputs(&mut unit));
        let wanted = settings.inputs.secondary.torque;
        settings.inputs.secondary.torque = torque;
        settings.parameters.friction.pulley = 0.08;
        let failed = try_step(&mut unit, &settings, to, None);
        assert!(failed.is_err_and(|why| why.contains("no solution")));
        assert_eq!((written(&mut unit), outputs(&mut unit)), (bytes, before));
        settings.inputs.secondary.torque = wanted;
        let next = unit.time() + 5e-3;
        step(&mut unit, &settings, next);
    }
}
