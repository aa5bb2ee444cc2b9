//! Cylinders: pressure in, flow out.

use std::f64::consts::TAU;

use pushbelt::variator::settings::Cylinder;

use super::{outputs, run, start};
use crate::settings::Settings;

const CYLINDER: Cylinder = Cylinder {
    area: 0.012,
    spring_force: 400.0,
    spring_stiffness: 1.5e4,
    centrifugal: 0.01,
    seal: 0.0,
};

/// Pitch radius of the checked-in tables at ratio 1, m: geometry.beltLength = 2 geometry.centerDistance + 2 pi (r + belt.pitchOffset).
const RADIUS_AT_ONE: f64 = (0.703 - 2.0 * 0.168) / TAU - 1e-3;

/// Both pulleys have this cylinder, and with an area pressures instead of clamping forces. The run starts in the equilibrium.
fn settings(cylinder: Cylinder) -> Settings {
    let mut settings = super::settings();
    let (of, inputs) = (&mut settings.parameters, &mut settings.inputs);
    (of.primary.cylinder, of.secondary.cylinder) = (cylinder, cylinder);
    of.initial.equilibrium = true;
    if cylinder.area > 0.0 {
        for given in [&mut inputs.primary, &mut inputs.secondary] {
            given.pressure = std::mem::take(&mut given.clamping_force) / cylinder.area;
        }
    }
    settings
}

/// With springs and rotating oil the equilibrium is that of the whole forces, and at each point of a shift the oil supplies the work on
/// the sheave less that of the others. The radii give the speed of the sheave.
#[test]
fn cylinders_do_the_work_on_the_sheaves() {
    for seal in [0.0, 150.0] {
        let cylinder = Cylinder { seal, ..CYLINDER };
        let mut settings = settings(cylinder);
        let mut unit = start(&settings);
        let mut before = outputs(&mut unit);
        let mut plain = self::settings(Cylinder::default());
        plain.inputs.primary.clamping_force = before.primary.axial_force;
        plain.inputs.secondary.clamping_force = before.secondary.axial_force;
        let expected = outputs(&mut start(&plain));
        assert!((before.ratio_geometric / expected.ratio_geometric - 1.0).abs() < 1e-9);
        settings.inputs.primary.pressure += 1e5;
        let way = 2.0 * settings.parameters.geometry.wedge_angle.tan();
        for count in 0..200 {
            let now = run(&mut unit, &settings, 1e-3, 1e-3);
            let mut rubbed = 0.0;
            for (of, before, given) in [
                (&now.primary, &before.primary, &settings.inputs.primary),
                (&now.secondary, &before.secondary, &settings.inputs.secondary),
            ] {
                let drag = cylinder.drag(of.sheave_velocity, settings.parameters.friction.velocity);
                // From ratio 1, where both radii are alike.
                let others = cylinder.push(way * (of.radius - RADIUS_AT_ONE), of.speed) - drag;
                let mechanical = (of.axial_force - others) * of.sheave_velocity;
                let power = given.pressure * of.flow;
                assert!((power - mechanical).abs() <= 1e-9 * power.abs(), "{power} {mechanical}");
                let moved = way * (of.radius - before.radius) / 1e-3;
                let mean = 0.5 * (of.sheave_velocity + before.sheave_velocity);
                let follows = (moved - mean).abs() <= 0.05 * mean.abs() + 1e-9;
                assert!(count < 5 || follows, "{moved} {mean}");
                rubbed += drag * of.sheave_velocity;
            }
            assert!((now.losses.seals - rubbed).abs() <= 1e-12 * rubbed, "step {count}");
            before = now;
        }
        assert!(before.primary.flow > 0.0 && before.secondary.flow < 0.0);
        assert_eq!(before.losses.seals > 0.0, seal > 0.0);
    }
}

/// From an equilibrium, half the friction of the seals more pressure: the sheave creeps as the regularised law does.
#[test]
fn seals_hold_the_ratio_but_for_creep() {
    let [rubbing, free] = [400.0, 0.0].map(|seal| {
        let cylinder = Cylinder {
            area: 0.01,
            ..Cylinder::default()
        };
        let mut settings = settings(cylinder);
        settings.parameters.primary.cylinder.seal = seal;
        let mut unit = start(&settings);
        settings.inputs.primary.pressure += 0.5 * 400.0 / cylinder.area;
        run(&mut unit, &settings, 0.01, 0.01).primary.sheave_velocity
    });
    let creeps = 0.0 < rubbing && rubbing < free && rubbing < 5e-4 / 3.0_f64.sqrt();
    assert!(creeps, "{rubbing} {free}");
}
