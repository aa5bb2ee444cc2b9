//! Cylinders: pressure in, flow out.

use pushbelt::variator::settings::Cylinder;
use pushbelt_fmi::unit::{Experiment, Unit};

use super::states::{read, written};
use super::{outputs, run, start, step};
use crate::settings::Settings;
use crate::unit::MapUnit;

const CYLINDER: Cylinder = Cylinder {
    area: 0.012,
    spring_force: 400.0,
    spring_stiffness: 1.5e4,
    centrifugal: 0.01,
    seal: 0.0,
};

/// Both pulleys have this cylinder, and pressures instead of clamping forces. The run starts in the
/// equilibrium.
fn settings(seal: f64) -> Settings {
    let mut settings = super::settings();
    let (of, inputs) = (&mut settings.parameters, &mut settings.inputs);
    of.initial.equilibrium = true;
    for (of, given) in [
        (&mut of.primary, &mut inputs.primary),
        (&mut of.secondary, &mut inputs.secondary),
    ] {
        of.cylinder = Cylinder { seal, ..CYLINDER };
        given.pressure = std::mem::take(&mut given.clamping_force) / CYLINDER.area;
    }
    settings
}

/// With springs and rotating oil the equilibrium is that of the whole forces. At each point of a
/// shift the axial force is that of pressure, spring and oil less the friction of the seals, and
/// the radii give the speed of the sheave.
#[test]
fn cylinders_move_the_sheaves() {
    for seal in [0.0, 150.0] {
        let mut settings = settings(seal);
        let mut unit = start(&settings);
        let mut before = outputs(&mut unit);
        let mut plain = super::settings();
        plain.parameters.initial.equilibrium = true;
        plain.inputs.primary.clamping_force = before.primary.axial_force;
        plain.inputs.secondary.clamping_force = before.secondary.axial_force;
        let expected = outputs(&mut start(&plain));
        assert!((before.ratio_geometric / expected.ratio_geometric - 1.0).abs() < 1e-9);
        settings.inputs.primary.pressure += 1e5;
        let parameters = &settings.parameters;
        let way = 2.0 * parameters.geometry.wedge_angle.tan();
        let at_one = parameters.pitch_radii(1.0).expect("a closed belt").primary;
        for count in 0..200 {
            let now = run(&mut unit, &settings, 1e-3, 1e-3);
            let mut rubbed = 0.0;
            for (of, before, given) in [
                (&now.primary, &before.primary, &settings.inputs.primary),
                (&now.secondary, &before.secondary, &settings.inputs.secondary),
            ] {
                let (cylinder, position) = (&parameters.primary.cylinder, way * (of.radius - at_one));
                let drag = cylinder.drag(of.sheave_velocity, parameters.friction.velocity);
                let force = given.force(cylinder) + cylinder.passive_force(position, of.speed) - drag;
                assert!(
                    (of.axial_force - force).abs() <= 1e-9 * force,
                    "{} {force}",
                    of.axial_force
                );
                assert_eq!(of.flow, cylinder.area * of.sheave_velocity);
                assert!((of.volume - cylinder.area * position).abs() < 1e-15, "{}", of.volume);
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

/// From an equilibrium, half the friction of the seals of a pulley more pressure: the sheave creeps
/// as the regularised law does, at half the speed without friction.
#[test]
fn seals_hold_the_ratio_but_for_creep() {
    let creep = |seals: [f64; 2], more: [f64; 2]| {
        let mut settings = settings(0.0);
        settings.parameters.primary.cylinder.seal = seals[0];
        settings.parameters.secondary.cylinder.seal = seals[1];
        let mut unit = start(&settings);
        settings.inputs.primary.pressure += more[0] / CYLINDER.area;
        settings.inputs.secondary.pressure += more[1] / CYLINDER.area;
        let o = run(&mut unit, &settings, 0.01, 0.01);
        [o.primary.sheave_velocity, o.secondary.sheave_velocity]
    };
    for (k, one) in [[400.0, 0.0], [0.0, 400.0]].into_iter().enumerate() {
        let half = one.map(|seal| 0.5 * seal);
        let [creeps, free] = [one, [0.0; 2]].map(|seals| creep(seals, half)[k]);
        assert!((0.3..0.7).contains(&(creeps / free)), "{k}: {creeps} {free}");
        assert!(creeps < 5e-4 / 3.0_f64.sqrt(), "{k}: {creeps}");
    }
}

/// At the start and in a run, each once.
#[test]
fn a_pressure_without_an_area_is_warned_about_once() {
    let mut settings = super::settings();
    settings.inputs.secondary.pressure = 1e5;
    let mut remarks = Vec::new();
    let mut unit = MapUnit::start(&settings, &Experiment::default(), &mut remarks).expect("a start");
    settings.inputs.primary.pressure = 2e5;
    for to in [0.01, 0.02] {
        remarks.extend(step(&mut unit, &settings, to, None).expect("a step"));
    }
    let texts: Vec<_> = remarks.iter().map(|remark| (remark.warning, &*remark.text)).collect();
    let [(true, first), (true, second)] = texts[..] else {
        panic!("{texts:?}");
    };
    assert!(first.contains("secondary.cylinder.area is 0") && second.contains("primary.cylinder.area is 0"));
}

/// Out of equilibrium too: a coupled circuit reads no flow before the first step, also where the
/// start was stored.
#[test]
fn sheaves_are_at_rest_at_the_start() {
    let mut settings = settings(150.0);
    settings.parameters.initial.equilibrium = false;
    settings.inputs.primary.pressure += 1e5;
    let mut unit = start(&settings);
    let mut stored = read(&settings, &written(&mut unit)).expect("all bytes");
    for unit in [&mut unit, &mut stored] {
        let o = outputs(unit);
        let moves = [&o.primary, &o.secondary].map(|of| [of.sheave_velocity, of.flow]);
        assert_eq!((moves, o.losses.seals), ([[0.0; 2]; 2], 0.0));
    }
    assert!(run(&mut unit, &settings, 1e-3, 1e-3).primary.flow > 0.0);
}
