//! Runs of a variator: the same bits in both versions, in every thread, and steps that can't be
//! done.

use crate::importer::{BOTH, Handles};
use crate::variator::{Importer, reference};
use pushbelt::fmi::Version::{self, Three, Two};
use pushbelt::fmi::log::Status::{Discard, Ok};
use pushbelt::variator::settings::{Inputs, Parameters, RingModel};
use pushbelt_support::checks::assert_close;
use pushbelt_support::manoeuvre::Manoeuvre;
use pushbelt_support::run::started;
use pushbelt_support::variators::mesh;
use std::thread;

#[test]
fn outputs_are_those_of_the_library() {
    let importer = Importer::running(Three);
    // The variator of [`Importer::coarse`], without the interface.
    let mut parameters = Parameters {
        ring_model: RingModel::Ale0,
        mesh: mesh(4, 4),
        ..Parameters::default()
    };
    parameters.initial.steady = false;
    let mut variator = started(parameters, &Inputs::default());
    let array = |name| importer.reals(&[reference(name)], 72).expect("an array");
    for k in 0..10 {
        importer.advance(f64::from(k) * 0.001, 0.001);
        let advanced = variator.advance(f64::from(k + 1) * 0.001, &Inputs::default());
        advanced.expect("a step");
        let outputs = variator.outputs().clone();
        let tension = variator.profile().ring_tension[71];
        assert_close(array("profile.ringTension")[71], tension, 1e-9, "ring tension");
        for (name, expected) in [
            ("thrustRatio", outputs.thrust_ratio),
            ("belt.speed", outputs.belt_speed),
            ("loss.ring", outputs.losses.ring),
            ("ring.stressMean.primary", outputs.ring_stress.mean.primary),
        ] {
            assert_close(importer.get(name), expected, 1e-9, name);
        }
        assert_eq!(importer.is("macroSlip"), outputs.macro_slip);
    }
    let places = array("profile.position");
    let spacing = places[1];
    assert!((5e-3..2e-2).contains(&spacing), "{spacing} m between places");
    for (k, place) in (0..).zip(places) {
        assert!((place - f64::from(k) * spacing).abs() < 1e-9, "{k}");
    }
    let force = array("profile.pushForce").into_iter().fold(0.0, f64::max);
    let most = importer.get("pushForce.max");
    assert!(force <= most * (1.0 + 1e-12) && force > 0.5 * most, "{force} of {most}");
}

/// Inputs by their names.
type Named = Vec<(&'static str, f64)>;

fn rows(importer: &Importer, set: fn(&Importer), steps: &[Named], size: f64) -> Vec<Vec<u64>> {
    set(importer);
    importer.start();
    let step = |(k, inputs): (u32, &Named)| {
        inputs.iter().for_each(|(name, value)| importer.put(name, *value));
        let ended = importer.step(f64::from(k) * size, size);
        assert_eq!((ended.status, ended.early), (Ok, false), "{}", importer.last());
        if ended.event {
            assert_eq!(importer.enter_event_mode(), Ok);
            importer.handle_event();
        }
        importer.readings()
    };
    (0..).zip(steps).map(step).collect()
}

/// The versions agree to the last bit, also with intermediate updates in which the importer does
/// nothing, after `set`, with the inputs of each step of a size, s.
fn check(set: fn(&Importer), steps: impl Iterator<Item = Named>, size: f64) {
    let steps: Vec<_> = steps.collect();
    let expected = rows(&Importer::new(Two), set, &steps, size);
    let required = ["thrustRatio", "primary.torque"].map(reference);
    let events = Handles {
        early_return: false,
        ..Handles::EVENTS
    };
    for handles in [Handles::default(), Handles::updates(&required), events] {
        let found = rows(&Importer::handling(Three, handles), set, &steps, size);
        let differs = expected.iter().zip(&found).position(|(a, b)| a != b);
        assert_eq!(differs, None, "the first step that differs");
    }
}

/// The manoeuvre's first second, with the launch, on the reference ring; all of it is a test of the
/// packed FMUs.
#[test]
fn the_manoeuvre_has_the_same_bits_in_both_versions() {
    let manoeuvre = Manoeuvre::read();
    let steps = (0..1000).map(|k| {
        let inputs = manoeuvre.at(f64::from(k) * 1e-3);
        let forces = [inputs.primary.clamping_force, inputs.secondary.clamping_force];
        LOADS
            .into_iter()
            .zip([forces[0], forces[1], inputs.primary.torque, inputs.secondary.torque])
            .collect()
    });
    let set = |importer: &Importer| {
        importer.choose("ring.model", 1);
        importer.put("secondary.inertia", 4.0);
        importer.put("initial.ratio", 2.2);
        importer.put("initial.primarySpeed", 0.0);
    };
    check(set, steps, 1e-3);
}

#[test]
fn real_time_has_the_same_bits_in_both_versions() {
    let steps = (0..100).map(|k| vec![("primary.torque", 50.0 + f64::from(k % 7) * 20.0)]);
    let set = |importer: &Importer| {
        importer.choose("solver.mode", 2);
        importer.choose("ring.model", 1);
        importer.flag("initial.steady", true);
    };
    check(set, steps, 3.5e-3);
}

/// Instances run on eight threads as one after the other, every second one with intermediate
/// updates.
#[test]
fn instances_on_threads_give_the_sequential_bits() {
    let run = |version: Version, number: u32| {
        let speed = [reference("primary.speed")];
        let watched: &[u32] = if number.is_multiple_of(2) { &speed } else { &[] };
        let importer = Importer::coarse(version, Handles::updates(watched));
        importer.start();
        let alias = importer.alias();
        importer.answer(move |_| {
            assert!(alias.get("primary.speed") > 0.0);
            None
        });
        importer.put("primary.torque", 50.0 + f64::from(number));
        importer.run(0)
    };
    for version in BOTH {
        let alone: Vec<_> = (0..16).map(|number| run(version, number)).collect();
        assert_ne!(alone[0], alone[1], "the instances differ");
        let together: Vec<_> = thread::scope(|scope| {
            let start =
                |worker: u32| scope.spawn(move || [run(version, 2 * worker), run(version, 2 * worker + 1)]);
            let workers: Vec<_> = (0..8).map(start).collect();
            let joined = workers.into_iter().flat_map(|worker| worker.join().expect("no panic"));
            joined.collect()
        });
        assert!(together == alone, "{version:?}");
    }
}

/// A run that starts at a time of today, in seconds since 1970, by a host that sums up its steps or
/// multiplies: within the tolerance of the solver, 1e-4, of the outputs' size.
#[test]
fn a_late_run_equals_one_from_zero() {
    let outputs = |mode: i32, start: f64, sums: bool| {
        let importer = Importer::new(Two);
        importer.choose("ring.model", 1);
        importer.choose("solver.mode", mode);
        importer.start_at(start);
        let mut time = start;
        let step = |k: u32| {
            importer.put("primary.torque", if (k / 50).is_multiple_of(2) { 80.0 } else { 50.0 });
            importer.advance(time, 1e-4);
            time = if sums {
                time + 1e-4
            } else {
                start + 1e-4 * f64::from(k + 1)
            };
            ["thrustRatio", "slip", "secondary.speed", "ratio.geometric"].map(|name| importer.get(name))
        };
        (0..200).flat_map(step).collect::<Vec<_>>()
    };
    let nominal = [1.0, 0.01, 200.0, 1.0];
    for mode in [1, 2] {
        let expected = outputs(mode, 0.0, true);
        for sums in [true, false] {
            let late = outputs(mode, 1.7e9, sums);
            for ((a, b), size) in late.iter().zip(&expected).zip(nominal.iter().cycle()) {
                assert!((a - b).abs() < 1e-4 * size, "mode {mode}, sums {sums}: {a} {b}");
            }
        }
    }
}

const LOADS: [&str; 4] = [
    "primary.clampingForce",
    "secondary.clampingForce",
    "primary.torque",
    "secondary.torque",
];

/// All loads at the ends of their ranges.
fn set_largest_loads(importer: &Importer) {
    for (name, load) in LOADS.into_iter().zip([5e5, 5e5, 1e4, -1e4]) {
        importer.put(name, load);
    }
}

/// A step from `from`, s, is discarded, and all is as before: outputs and their derivatives, counts
/// of work and flags.
fn discard(importer: &Importer, from: f64, size: f64) {
    let everything = || {
        let counts =
            ["solver.steps", "solver.jacobians", "solver.residuals"].map(|name| importer.count(name));
        (importer.readings(), importer.slopes(), counts, importer.is("macroSlip"))
    };
    let before = everything();
    let ended = importer.step(from, size);
    assert_eq!((ended.status, ended.time), (Discard, from));
    assert!(!ended.event && !ended.early);
    assert_eq!(everything(), before);
}

/// An instance with the least friction velocity, on which the largest loads are too much, after a
/// step from 0 s.
fn fragile(version: Version, handles: Handles<'_>, tolerance: f64) -> Importer {
    let importer = Importer::handling(version, handles);
    importer.put("solver.tolerance", tolerance);
    importer.put("friction.velocity", 1e-6);
    importer.put("inputs.ramp", 0.0);
    importer.start();
    importer.advance(0.0, 1e-3);
    importer
}

/// Too much for the error control at a very small tolerance, whose bound on work is wide enough
/// that the step stalls first.
#[test]
fn a_step_that_stalls_is_discarded() {
    let importer = fragile(Two, Handles::default(), 1e-10);
    set_largest_loads(&importer);
    discard(&importer, 1e-3, 2e-3);
    importer.assert_logged("stalled at 0.0");
}

/// The work of a step is bounded. The largest loads exceed the bound within two milliseconds. With
/// gentler loads the step can be repeated, without a stored state.
#[test]
fn a_step_that_takes_too_much_work_is_discarded_and_can_be_repeated() {
    let required = ["primary.torque", "primary.speed"].map(reference);
    for (version, handles) in [(Two, Handles::default()), (Three, Handles::updates(&required))] {
        let importer = fragile(version, handles, 1e-4);
        let gentle = LOADS.map(|name| (name, importer.get(name)));
        let step_gently = |step: f64| {
            gentle.iter().for_each(|(name, load)| importer.put(name, *load));
            importer.advance(1e-3, step);
            importer.readings()
        };
        let before = importer.stored();
        step_gently(2e-3);
        let expected = importer.get("thrustRatio");
        assert_eq!(importer.restore(before), Ok);
        set_largest_loads(&importer);
        // Another friction coefficient would take effect in this step.
        importer.put("friction.pulley", 0.1);
        importer.record.updates.borrow_mut().clear();
        discard(&importer, 1e-3, 2e-3);
        assert_eq!(importer.record.updates.borrow().is_empty(), version == Two);
        let text = importer.last();
        assert!(text.contains("far beyond what the belt transmits"), "{text}");
        let counted = text
            .split_once("after ")
            .and_then(|(_, rest)| rest.split(' ').next()?.parse().ok());
        let residuals: i64 = counted.expect("a count");
        assert!((11_000..13_000).contains(&residuals), "{residuals} residuals");
        importer.put("friction.pulley", 0.09);
        let after = importer.stored();
        let counted = importer.count("solver.residuals");
        let repeated = step_gently(2e-3);
        assert_close(importer.get("thrustRatio"), expected, 1e-6, "repeated");
        // The work that was in vain is counted with that of the next step, which is ordinary.
        let ordinary = importer.count("solver.residuals") - counted - residuals;
        assert!((1..100).contains(&ordinary), "{ordinary} residuals");
        assert_eq!(importer.restore(after), Ok);
        step_gently(1e-3);
        assert_eq!(importer.restore(after), Ok);
        assert_eq!(step_gently(2e-3), repeated, "from a state that was stored in between");
    }
}
