//! Equations and runs.

use pushbelt::pulley::PerPulley;
use pushbelt::variator::settings::{Axial, Drive, Inputs};
use pushbelt_fmi::table::{Causality, Variable};
use pushbelt_fmi::unit::{Experiment, Unit};
use pushbelt_map_unit::law::{Law, Radii, State};
use pushbelt_map_unit::settings::Settings;
use pushbelt_map_unit::unit::MapUnit;

use crate::{outputs, run, settings, start, step, try_step};

/// Each name of the lists is a variable of the detailed unit.
#[test]
fn the_variables_are_there() {
    let table = MapUnit::table();
    let outputs = |one: &&Variable<_, _>| one.causality == Causality::Output;
    let count = table.variables().iter().filter(outputs).count();
    assert_eq!((table.variables().len(), count, table.units.len()), (74, 31, 16));
}

/// The radii are pitch radii, and their quotient is the ratio. Between places of the table they err by less than a micrometre.
#[test]
fn radii_close_the_belt_and_meet_the_stops() {
    let parameters = settings().parameters;
    let radii = Radii::new(&parameters).expect("radii");
    let [least, most] = radii.stops;
    for (stop, [primary, secondary]) in [(least, [0.082, 0.03]), (most, [0.03, 0.082])] {
        let (found, _) = radii.at(stop).primary;
        let off = (found - primary).abs().min((stop.exp() * found - secondary).abs());
        assert!(off < 1e-6, "{off:e}");
    }
    for ratio in [0.4, 0.77, 1.0, 2.3_f64] {
        let (primary, _) = radii.at(ratio.ln()).primary;
        let [p, s] = [primary, ratio * primary].map(|radius| radius + parameters.belt.pitch_offset);
        let distance = parameters.geometry.center_distance;
        let angle = ((p - s) / distance).acos();
        let strand = (distance.powi(2) - (p - s).powi(2)).sqrt();
        let length = 2.0 * (strand + p * (std::f64::consts::PI - angle) + s * angle);
        assert!(
            (length - parameters.geometry.belt_length).abs() < 6e-6,
            "{ratio}: {length}"
        );
    }
}

/// T_P, T_S and ℓ' of the law of settings at speeds of the primary and the secondary shaft, and ln i.
struct Bench {
    settings: Settings,
    radii: Radii,
}

impl Bench {
    fn new() -> Self {
        let settings = settings();
        let radii = Radii::new(&settings.parameters).expect("radii");
        Self { settings, radii }
    }

    fn torques(&self, primary: f64, secondary: f64, log_ratio: f64) -> [f64; 3] {
        let law = Law {
            tables: self.settings.own.as_ref().expect("tables"),
            radii: &self.radii,
            parameters: &self.settings.parameters,
            held_thrust_ratio: None,
        };
        let speeds = PerPulley { primary, secondary };
        let frame = law.frame(&State { speeds, log_ratio }, &self.settings.inputs);
        let point = law.point(&frame, frame.sliding(speeds));
        let torque = frame.torque * point.traction.value;
        let (shift, _) = law.shift(&frame, &point);
        [torque, frame.ratio * (torque - point.torque_loss), shift]
    }

    fn torque(&self, primary: f64, secondary: f64, log_ratio: f64) -> f64 {
        self.torques(primary, secondary, log_ratio)[0]
    }
}

#[test]
fn signs_are_those_of_the_detailed_unit() {
    let mut bench = Bench::new();
    let [into, out, _] = bench.torques(200.0, 198.0, 0.0);
    // The faster primary shaft drives the belt, and the belt drives the secondary shaft.
    assert!(into > 40.0 && out > 30.0 && out < into);
    let [into, out, _] = bench.torques(200.0, 202.0, 0.0);
    assert!(into < -30.0 && out < into);
    // A larger primary force closes the primary pulley: overdrive, a smaller ratio.
    for (share, sign) in [(2.0, -1.0), (0.5, 1.0)] {
        bench.settings.inputs.primary.clamping_force = share * bench.settings.inputs.secondary.clamping_force;
        assert!(sign * bench.torques(200.0, 198.0, 0.0)[2] > 0.0);
    }
    assert_eq!(bench.torques(0.0, 0.0, 0.0)[2], 0.0);
}

#[test]
fn reverse_running_is_the_mirror_image() {
    let bench = Bench::new();
    for (primary, secondary) in [(200.0, 150.0), (30.0, 31.0), (0.5, 0.2), (0.0, 0.3), (-3.0, 1.0)] {
        let [into, out, shift] = bench.torques(primary, secondary, 0.25);
        let [back_in, back_out, back] = bench.torques(-primary, -secondary, 0.25);
        for (one, other) in [(into, back_in), (out, back_out), (shift, -back)] {
            assert!((one + other).abs() < 1e-12 * one.abs().max(1.0), "{primary}");
        }
    }
}

#[test]
fn torque_is_continuous_and_falls_in_fast_sliding() {
    let mut bench = Bench::new();
    let along = |bench: &Bench, speeds: &dyn Fn(f64) -> [f64; 2]| -> Vec<f64> {
        let at = |k: i32| speeds(f64::from(k) / 20_000.0);
        (0..=20_000).map(|k| bench.torque(at(k)[0], at(k)[1], 0.1)).collect()
    };
    let largest = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
    // Near standstill the torque grows by its capacity within 0.02 rad/s. At speed the belt slips through.
    let speeds: [&dyn Fn(f64) -> [f64; 2]; 2] = [&|t| [2.0 * t - 1.0, 0.4], &|t| [200.0, 185.0 * (1.0 - t)]];
    for speeds in speeds {
        let values = along(&bench, speeds);
        let jumps: Vec<f64> = values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
        assert!(largest(&jumps) < 0.01 * largest(&values));
    }
    let values = along(&bench, speeds[1]);
    let (most, fast) = (largest(&values), values[20_000]);
    let fall = 1.0 - fast / most;
    assert!((fall - bench.settings.parameters.friction.fall).abs() < 1e-3, "{fall}");
    bench.settings.parameters.friction.pulley *= 0.7;
    assert!((bench.torque(200.0, 0.0, 0.1) - 0.7 * fast).abs() < 1e-12 * fast);
}

#[test]
fn a_run_starts_steady_and_stays_there() {
    let mut settings = settings();
    settings.inputs.primary.clamping_force = 13.5e3;
    settings.parameters.secondary.drive = Drive::Speed;
    settings.parameters.secondary.axial = Axial::Force;
    settings.parameters.primary.axial = Axial::Held;
    let mut unit = start(&settings);
    let before = outputs(&mut unit);
    assert!((before.secondary.speed - 209.44).abs() < 1e-9);
    let after = run(&mut unit, &settings, 1e-2, 1.0);
    assert!((after.slip - before.slip).abs() < 1e-9);
    assert_eq!(after.ratio_geometric, 1.0);
    assert!(before.slip > 1e-3);
    // Equilibrium of torques at both shafts, and power.
    let into = after.primary.external_torque * after.primary.speed;
    let out = after.secondary.external_torque * after.secondary.speed;
    assert!((into + out - after.losses.total()).abs() < 1e-6 * into, "{into} {out}");
    assert!((after.efficiency + out / into).abs() < 1e-9);
}

#[test]
fn the_belt_slips_through_and_recovers() {
    let mut settings = settings();
    settings.parameters.secondary.drive = Drive::Speed;
    let mut unit = start(&settings);
    settings.inputs.primary.torque = 150.0;
    let slipping = run(&mut unit, &settings, 1e-2, 0.2);
    assert!(slipping.macro_slip && slipping.slip > 0.2, "{}", slipping.slip);
    settings.inputs.primary.torque = 20.0;
    let caught = run(&mut unit, &settings, 1e-2, 2.0);
    assert!(!caught.macro_slip && caught.slip < 0.01, "{}", caught.slip);
}

#[test]
fn a_shift_ends_at_the_equilibrium_or_at_a_stop() {
    let mut settings = settings();
    settings.parameters.primary.drive = Drive::Speed;
    settings.inputs.primary.clamping_force = 14e3;
    let mut unit = start(&settings);
    let found = run(&mut unit, &settings, 1e-2, 20.0);
    settings.parameters.initial.equilibrium = true;
    settings.inputs.secondary.torque = -49.0;
    let mut other = start(&settings);
    let direct = outputs(&mut other);
    // The shafts also accelerate: the secondary speed is not yet constant at the start of the second run.
    assert!((found.ratio_geometric - direct.ratio_geometric).abs() < 0.02);
    settings.inputs.primary.clamping_force = 60e3;
    settings.parameters.initial.equilibrium = false;
    let stop = run(&mut unit, &settings, 1e-2, 5.0);
    let [least, _] = Radii::new(&settings.parameters).expect("radii").stops;
    assert!((stop.ratio_geometric.ln() - least).abs() < 1e-12);
    assert_eq!(stop.primary.sheave_velocity, 0.0);
    assert!(unit.readings(false).outside);
}

#[test]
fn long_steps_are_accurate() {
    let mut settings = settings();
    settings.inputs.primary.clamping_force = 16e3;
    settings.parameters.solver.input_ramp = 0.0;
    let at = |time: f64| {
        let mut unit = start(&settings);
        let mut changed = settings.clone();
        changed.inputs.primary.torque = 65.0;
        let found = run(&mut unit, &changed, time, 0.32);
        [found.primary.speed, found.secondary.speed, found.ratio_geometric]
    };
    let exact = at(1.25e-4);
    let error = |time: f64| {
        let pairs = at(time).into_iter().zip(exact);
        pairs
            .map(|(found, exact)| (found / exact - 1.0).abs())
            .fold(0.0, f64::max)
    };
    let (coarse, fine) = (error(1e-2), error(2.5e-3));
    // The tables are pieces of lines, whose kinks limit the order.
    assert!(coarse < 1e-5, "{coarse}");
    assert!(fine < 0.5 * coarse, "{coarse} {fine}");
}

#[test]
fn energy_is_balanced() {
    let mut settings = settings();
    settings.inputs.primary.clamping_force = 15e3;
    settings.inputs.primary.torque = 70.0;
    let mut unit = start(&settings);
    let begin = outputs(&mut unit);
    let (mut supplied, mut lost, mut before) = (0.0, 0.0, begin.clone());
    for k in 1..=1000 {
        step(&mut unit, &settings, 1e-3 * f64::from(k));
        let now = outputs(&mut unit);
        for one in [&before, &now] {
            for of in [one.primary, one.secondary] {
                supplied += 0.5e-3 * of.external_torque * of.speed;
            }
            lost += 0.5e-3 * one.losses.total();
        }
        before = now;
    }
    let residual = supplied - lost - (before.stored_energy - begin.stored_energy);
    assert!(lost > 100.0);
    assert!(residual.abs() < 1e-4 * lost, "{residual} of {lost}");
}

#[test]
fn a_held_secondary_sheave_has_the_force_that_the_primary_one_requires() {
    let mut settings = settings();
    settings.parameters.secondary.axial = Axial::Held;
    let mut unit = start(&settings);
    let found = run(&mut unit, &settings, 1e-2, 0.5);
    assert_eq!(found.ratio_geometric, 1.0);
    assert!((found.primary.axial_force / found.secondary.axial_force - found.thrust_ratio).abs() < 1e-12);
    assert!((found.thrust_ratio - 1.35).abs() < 0.05, "{}", found.thrust_ratio);
    settings.parameters.primary.axial = Axial::Held;
    let refused = MapUnit::start(&settings, &Experiment::default(), &mut Vec::new()).map(drop);
    assert!(refused.unwrap_err().contains("both Held"));
}

#[test]
fn beyond_the_tables_is_logged_once() {
    let mut settings = settings();
    settings.inputs.secondary.clamping_force = 2e5;
    settings.inputs.primary.clamping_force = 2.7e5;
    let mut remarks = Vec::new();
    let mut unit = MapUnit::start(&settings, &Experiment::default(), &mut remarks).expect("a start");
    for k in 1..=3 {
        remarks.extend(step(&mut unit, &settings, 0.01 * f64::from(k)));
    }
    assert_eq!(remarks.len(), 1, "{remarks:?}");
    assert!(remarks[0].warning && remarks[0].text.contains("200000 N"));
    assert!(unit.readings(false).outside);
}

#[test]
fn settings_are_checked() {
    let mut settings = settings();
    settings.parameters.friction.pulley = 0.3;
    assert!(MapUnit::check(&settings).unwrap_err().contains("friction.pulley = 0.3"));
    settings.parameters.friction.pulley = 0.09;
    settings.parameters.primary.min_radius = 0.08;
    settings.parameters.secondary.min_radius = 0.08;
    let refused = MapUnit::start(&settings, &Experiment::default(), &mut Vec::new()).map(drop);
    assert!(refused.unwrap_err().contains("end stops"));
}

#[test]
fn an_input_ramps_over_the_whole_step_or_follows_its_derivative() {
    let speed = |torque: f64, rates: Option<Inputs>| {
        let mut settings = settings();
        settings.parameters.solver.input_ramp = -1.0;
        let mut unit = start(&settings);
        settings.inputs.primary.torque = torque;
        try_step(&mut unit, &settings, 0.1, rates).expect("a step");
        outputs(&mut unit).primary.speed
    };
    let mut rates = Inputs::ZERO;
    rates.primary.torque = 200.0;
    assert!((speed(70.0, None) - speed(50.0, Some(rates))).abs() < 1e-9);
}
