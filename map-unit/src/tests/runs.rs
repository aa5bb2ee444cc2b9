//! Starts and runs.

use pushbelt::variator::settings::{Axial, Drive, Inputs, Outputs};
use pushbelt_fmi::table::{Causality, Variable};
use pushbelt_fmi::unit::{Experiment, Unit};

use super::{outputs, run, settings, start, step};
use crate::settings::Settings;
use crate::unit::MapUnit;

/// Each name of the lists is a variable of the detailed unit.
#[test]
fn the_variables_are_there() {
    let table = MapUnit::table();
    let (all, units) = (table.variables(), table.units.len());
    let is_output = |one: &&Variable<_, _>| one.causality == Causality::Output;
    let outputs = all.iter().filter(is_output).count();
    assert_eq!((all.len(), outputs, units), (79, 35, 17));
}

fn refused(settings: &Settings) -> String {
    let started = MapUnit::start(settings, &Experiment::default(), &mut Vec::new());
    started.map(drop).expect_err("settings that do not fit")
}

/// Power that neither is lost nor goes out, as a fraction of that which goes in: 0 in an
/// equilibrium of torques at both shafts.
fn unbalanced(of: &Outputs) -> f64 {
    let [into, out] = [of.primary, of.secondary].map(|of| of.external_torque * of.speed);
    assert!((of.efficiency + out / into).abs() < 1e-9);
    (into + out - of.losses.total()) / into
}

#[test]
fn a_run_starts_steady_and_stays_there() {
    let mut settings = settings();
    settings.inputs.primary.clamping_force = 13.5e3;
    settings.parameters.primary.axial = Axial::Held;
    for drives in [(Drive::Torque, Drive::Speed), (Drive::Speed, Drive::Torque)] {
        (settings.parameters.primary.drive, settings.parameters.secondary.drive) = drives;
        let mut unit = start(&settings);
        let before = outputs(&mut unit);
        let led = [before.primary, before.secondary][usize::from(drives.1 == Drive::Speed)];
        assert!((led.speed - 209.44).abs() < 1e-9 && before.slip > 1e-3);
        let after = run(&mut unit, &settings, 1e-2, 1.0);
        assert!((after.slip - before.slip).abs() < 1e-9);
        assert_eq!(after.ratio_geometric, 1.0);
        assert!(unbalanced(&after).abs() < 1e-6);
    }
}

#[test]
fn the_belt_slips_through_and_recovers() {
    let mut settings = settings();
    settings.parameters.secondary.drive = Drive::Speed;
    settings.parameters.primary.axial = Axial::Held;
    let mut unit = start(&settings);
    settings.inputs.primary.torque = 150.0;
    let slipping = run(&mut unit, &settings, 1e-2, 0.2);
    assert!(slipping.macro_slip && slipping.slip > 0.2, "{}", slipping.slip);
    settings.inputs.primary.torque = 20.0;
    let caught = run(&mut unit, &settings, 1e-2, 2.0);
    assert!(!caught.macro_slip && caught.slip < 0.01, "{}", caught.slip);
    settings.parameters.friction.pulley *= 0.8;
    let smoother = run(&mut unit, &settings, 1e-2, 1.0);
    let grown = smoother.torque_utilisation / caught.torque_utilisation;
    assert!((grown - 1.25).abs() < 0.01, "{grown}");
}

#[test]
fn a_shift_ends_at_the_equilibrium_or_at_a_stop() {
    let mut settings = settings();
    settings.parameters.primary.drive = Drive::Speed;
    settings.inputs.primary.clamping_force = 14e3;
    let mut unit = start(&settings);
    let found = run(&mut unit, &settings, 1e-2, 20.0);
    settings.parameters.initial.equilibrium = true;
    let direct = outputs(&mut start(&settings));
    // The shafts also accelerate: the secondary speed is not yet constant at the start of the
    // second run.
    assert!((found.ratio_geometric - direct.ratio_geometric).abs() < 0.02);
    settings.inputs.primary.clamping_force = 60e3;
    let stop = run(&mut unit, &settings, 1e-2, 5.0);
    assert!((stop.ratio_geometric.ln() - unit.law.stops.start()).abs() < 1e-12);
    assert_eq!(stop.primary.sheave_velocity, 0.0);
    assert!(unit.readings(false).outside);
}

#[test]
fn long_steps_are_accurate() {
    let mut settings = settings();
    settings.inputs.primary.clamping_force = 16e3;
    settings.parameters.solver.input_ramp = 0.0;
    let mut changed = settings.clone();
    changed.inputs.primary.torque = 65.0;
    let [exact, coarse, fine] = [1.25e-4, 1e-2, 2.5e-3].map(|time| {
        let found = run(&mut start(&settings), &changed, time, 0.32);
        [found.primary.speed, found.secondary.speed, found.ratio_geometric]
    });
    let error = |found: [f64; 3]| (0..3).map(|k| (found[k] / exact[k] - 1.0).abs()).fold(0.0, f64::max);
    // The tables are pieces of lines, whose kinks limit the order.
    let (coarse, fine) = (error(coarse), error(fine));
    assert!(coarse < 1e-5 && fine < 0.5 * coarse, "{coarse} {fine}");
}

#[test]
fn energy_is_balanced() {
    let mut settings = settings();
    settings.inputs.primary.clamping_force = 15e3;
    settings.inputs.primary.torque = 70.0;
    let mut unit = start(&settings);
    let begin = outputs(&mut unit);
    let (mut supplied, mut lost, mut before) = (0.0, 0.0, begin.clone());
    for _ in 0..1000 {
        let now = run(&mut unit, &settings, 1e-3, 1e-3);
        for one in [&before, &now] {
            let power = [one.primary, one.secondary].map(|of| of.external_torque * of.speed);
            supplied += 0.5e-3 * (power[0] + power[1]);
            lost += 0.5e-3 * one.losses.total();
        }
        before = now;
    }
    let residual = supplied - lost - (before.stored_energy - begin.stored_energy);
    assert!(lost > 100.0 && residual.abs() < 1e-4 * lost, "{residual} of {lost}");
}

#[test]
fn a_held_secondary_sheave_has_the_force_that_the_primary_one_requires() {
    let mut settings = settings();
    settings.parameters.secondary.axial = Axial::Held;
    settings.parameters.primary.drive = Drive::Speed;
    let mut unit = start(&settings);
    let begin = outputs(&mut unit);
    let found = run(&mut unit, &settings, 1e-2, 0.5);
    assert!((found.slip - begin.slip).abs() < 1e-8, "{} {}", begin.slip, found.slip);
    assert!(unbalanced(&found).abs() < 1e-6);
    assert_eq!(found.ratio_geometric, 1.0);
    assert!((found.primary.axial_force / found.secondary.axial_force - found.thrust_ratio).abs() < 1e-12);
    assert!((found.thrust_ratio - 1.35).abs() < 0.05, "{}", found.thrust_ratio);
    settings.parameters.primary.axial = Axial::Held;
    assert!(refused(&settings).contains("both Held"));
}

#[test]
fn a_state_beyond_the_tables_and_a_pulley_that_opens_are_logged_once_each() {
    let (mut settings, mut remarks) = (settings(), Vec::new());
    settings.parameters.primary.cylinder.area = 0.012;
    settings.inputs.secondary.clamping_force = 2e5;
    settings.inputs.primary.clamping_force = 2.7e5;
    let mut unit = MapUnit::start(&settings, &Experiment::default(), &mut remarks).expect("a start");
    for k in 1..=4 {
        let primary = &mut settings.inputs.primary;
        (primary.clamping_force, primary.pressure) = if k % 2 == 0 { (1e3, -1e5) } else { (2.7e5, 0.0) };
        remarks.extend(step(&mut unit, &settings, 0.01 * f64::from(k), None).expect("a step"));
        assert!(unit.readings(false).outside);
    }
    assert!(
        remarks.len() == 2 && remarks.iter().all(|remark| remark.warning),
        "{remarks:?}"
    );
    assert!(remarks[0].text.contains("200000 N"));
    assert!(remarks[1].text.contains("primary.pressure = -100000 Pa"));
}

#[test]
fn settings_are_checked() {
    let mut settings = settings();
    settings.parameters.friction.pulley = 0.3;
    assert!(refused(&settings).contains("friction.pulley = 0.3"));
    settings.parameters.friction.pulley = 0.09;
    let of = &mut settings.parameters;
    (of.primary.min_radius, of.secondary.min_radius) = (0.08, 0.08);
    assert!(refused(&settings).contains("end stops"));
}

#[test]
fn an_input_ramps_over_the_whole_step_or_follows_its_derivative() {
    let speed = |torque: f64, rates: Option<Inputs>| {
        let mut settings = settings();
        settings.parameters.solver.input_ramp = -1.0;
        let mut unit = start(&settings);
        settings.inputs.primary.torque = torque;
        step(&mut unit, &settings, 0.1, rates).expect("a step");
        outputs(&mut unit).primary.speed
    };
    let mut rates = Inputs::ZERO;
    rates.primary.torque = 200.0;
    assert!((speed(70.0, None) - speed(50.0, Some(rates))).abs() < 1e-9);
}

/// A torque that the belt does not carry: a start without slip, with a warning, or with
/// `initial.strict` an error.
#[test]
fn a_torque_beyond_capacity_is_a_warning_or_an_error() {
    let mut settings = settings();
    (settings.inputs.primary.torque, settings.inputs.secondary.torque) = (400.0, -400.0);
    for strict in [false, true] {
        settings.parameters.initial.strict = strict;
        let mut remarks = Vec::new();
        let started = MapUnit::start(&settings, &Experiment::default(), &mut remarks);
        let warned = remarks
            .iter()
            .filter(|remark| remark.text.contains("does not carry"))
            .count();
        let error = started.err();
        assert_eq!((error.is_some(), warned), (strict, usize::from(!strict)));
        assert!(
            error.is_none_or(|error| error.contains("does not carry") && error.contains("initial.strict"))
        );
    }
}
