//! Cylinders of the variator from maps: pressure in, flow out.

use pushbelt::variator::settings::{Cylinder, PulleyOutputs};
use pushbelt_fmi::unit::{Remark, Unit};
use pushbelt_map_unit::settings::Settings;
use pushbelt_map_unit::unit::MapUnit;

use crate::{outputs, start};

/// friction.velocity, m/s.
const VELOCITY: f64 = 5e-4;

const CYLINDER: Cylinder = Cylinder {
    area: 0.012,
    spring_force: 400.0,
    spring_stiffness: 1.5e4,
    centrifugal: 0.01,
    seal: 0.0,
};

fn settings(cylinder: Cylinder) -> Settings {
    let mut settings = crate::settings();
    let of = &mut settings.parameters;
    (of.primary.cylinder, of.secondary.cylinder) = (cylinder, cylinder);
    settings
}

fn step(unit: &mut MapUnit, settings: &Settings, length: f64) -> Vec<Remark> {
    let to = unit.time() + length;
    crate::step(unit, settings, to)
}

fn by_pressure(mut settings: Settings) -> Settings {
    for (inputs, of) in [
        (&mut settings.inputs.primary, settings.parameters.primary.cylinder),
        (&mut settings.inputs.secondary, settings.parameters.secondary.cylinder),
    ] {
        inputs.pressure = inputs.clamping_force / of.area;
        inputs.clamping_force = 0.0;
    }
    settings
}

#[test]
fn pressures_and_forces_give_the_same_bits() {
    let area = 1.0 / 128.0;
    let settings = settings(Cylinder {
        area,
        ..Cylinder::default()
    });
    let of = |k: u32| {
        let mut settings = settings.clone();
        settings.inputs.primary.clamping_force = 13e3 + 512.0 * f64::from(k % 4);
        settings
    };
    let (mut force, mut pressure) = (start(&of(0)), start(&by_pressure(of(0))));
    for k in 1..40 {
        step(&mut force, &of(k), 5e-3);
        step(&mut pressure, &by_pressure(of(k)), 5e-3);
        assert_eq!(force.readings(false), pressure.readings(false));
    }
}

/// With springs and rotating oil the equilibrium is that of the whole forces, and at each point of a shift the oil supplies the work on
/// the sheave less that of the others. The radii give the speed of the sheave.
#[test]
fn cylinders_do_the_work_on_the_sheaves() {
    for seal in [0.0, 150.0] {
        let cylinder = Cylinder { seal, ..CYLINDER };
        let mut settings = by_pressure(settings(cylinder));
        settings.parameters.initial.equilibrium = true;
        let mut unit = start(&settings);
        let at = outputs(&mut unit);
        let mut plain = self::settings(Cylinder::default());
        plain.parameters.initial.equilibrium = true;
        plain.inputs.primary.clamping_force = at.primary.axial_force;
        plain.inputs.secondary.clamping_force = at.secondary.axial_force;
        let expected = outputs(&mut start(&plain));
        assert!((at.ratio_geometric / expected.ratio_geometric - 1.0).abs() < 1e-9);
        settings.inputs.primary.pressure += 1e5;
        let tangent = settings.parameters.geometry.wedge_angle.tan();
        let mut before = at;
        for count in 0..200 {
            step(&mut unit, &settings, 1e-3);
            let now = outputs(&mut unit);
            let mut rubbed = 0.0;
            let pulleys: [(&PulleyOutputs, &PulleyOutputs, f64); 2] = [
                (&now.primary, &before.primary, settings.inputs.primary.pressure),
                (&now.secondary, &before.secondary, settings.inputs.secondary.pressure),
            ];
            for (of, before, pressure) in pulleys {
                // From ratio 1, where both radii are alike.
                let position = 2.0 * tangent * (of.radius - RADIUS_AT_ONE);
                let others = cylinder.spring_force - cylinder.spring_stiffness * position
                    + cylinder.centrifugal * of.speed * of.speed
                    - cylinder.drag(of.sheave_velocity, VELOCITY);
                let mechanical = (of.axial_force - others) * of.sheave_velocity;
                let power = pressure * of.flow;
                assert!((power - mechanical).abs() <= 1e-9 * power.abs(), "{power} {mechanical}");
                let moved = 2.0 * tangent * (of.radius - before.radius) / 1e-3;
                let mean = 0.5 * (of.sheave_velocity + before.sheave_velocity);
                assert!(
                    count < 5 || (moved - mean).abs() <= 0.05 * mean.abs() + 1e-9,
                    "{moved} {mean}"
                );
                rubbed += cylinder.drag(of.sheave_velocity, VELOCITY) * of.sheave_velocity;
            }
            assert!((now.losses.seals - rubbed).abs() <= 1e-12 * rubbed, "step {count}");
            before = now;
        }
        assert!(before.primary.flow > 0.0 && before.secondary.flow < 0.0);
        assert_eq!(before.losses.seals > 0.0, seal > 0.0);
    }
}

/// Pitch radius of the checked-in tables at ratio 1, m: geometry.beltLength = 2 geometry.centerDistance + 2 pi (r + belt.pitchOffset).
const RADIUS_AT_ONE: f64 = (0.703 - 2.0 * 0.168) / std::f64::consts::TAU - 1e-3;

/// From an equilibrium, half the friction of the seals more pressure: the sheave creeps as the regularised law does.
#[test]
fn seals_hold_the_ratio_but_for_creep() {
    let velocity = |seal: f64| {
        let mut settings = by_pressure(settings(Cylinder {
            area: 0.01,
            seal,
            ..Cylinder::default()
        }));
        settings.parameters.secondary.cylinder.seal = 0.0;
        settings.parameters.initial.equilibrium = true;
        let mut unit = start(&settings);
        settings.inputs.primary.pressure += 0.5 * 400.0 / 0.01;
        step(&mut unit, &settings, 0.01);
        unit.readings(false).outputs.primary.sheave_velocity
    };
    let (rubbing, free) = (velocity(400.0), velocity(0.0));
    println!("{rubbing:.2e} m/s, {free:.2e} m/s without seals");
    assert!(0.0 < rubbing && rubbing < free && rubbing < 5e-4 / 3.0_f64.sqrt());
}

#[test]
fn a_pressure_that_opens_a_pulley_is_warned_about_once() {
    let mut settings = by_pressure(settings(CYLINDER));
    let mut unit = start(&settings);
    let mut remarks = Vec::new();
    for pressure in [-1e5, 1e6, -1e5] {
        settings.inputs.primary.pressure = pressure;
        remarks.extend(step(&mut unit, &settings, 2e-3));
        assert!(unit.readings(false).outputs.secondary.speed.is_finite());
    }
    let opens = remarks
        .iter()
        .filter(|remark| remark.warning && remark.text.contains("primary.pressure = -100000 Pa"));
    assert_eq!(opens.count(), 1, "{remarks:?}");
}
