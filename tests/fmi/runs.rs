//! Runs of a variator: the same bits in both versions and in every host, and steps that can't be done.

use pushbelt::fmi::log::Status::{Discard, Ok};
use pushbelt::fmi::slave::Version::{self, Three, Two};
use pushbelt::variator::run::Variator;
use pushbelt::variator::settings::{Inputs, Parameters, RingModel};
use pushbelt_support::checks::assert_close;
use pushbelt_support::manoeuvre::Manoeuvre;

use crate::importer::{BOTH, Ended, Handles};
use crate::variator::{Importer, reference};

/// The variator of [`Importer::coarse`], without the interface.
fn coarse_variator() -> Variator {
    let mut parameters = Parameters {
        ring_model: RingModel::Ale0,
        ..Parameters::default()
    };
    (parameters.mesh.primary_arc, parameters.mesh.secondary_arc) = (4, 4);
    parameters.mesh.strand = 4;
    parameters.initial.steady = false;
    let mut variator = Variator::new(parameters).expect("valid parameters");
    variator.initialise(0.0, &Inputs::default()).expect("a start");
    variator
}

#[test]
fn outputs_are_those_of_the_library() {
    let importer = Importer::running(Three);
    let mut variator = coarse_variator();
    for k in 0..10 {
        importer.advance(f64::from(k) * 0.001, 0.001);
        let advanced = variator.advance(f64::from(k + 1) * 0.001, &Inputs::default());
        advanced.expect("a step");
        let outputs = variator.outputs().clone();
        let (profile, tension) = (reference("profile.ringTension"), variator.profile().ring_tension[71]);
        let found = importer.reals(&[profile], 72).expect("an array");
        assert_close(found[71], tension, 1e-9, "ring tension");
        for (name, expected) in [
            ("thrustRatio", outputs.thrust_ratio),
            ("belt.speed", outputs.belt_speed),
            ("loss.ring", outputs.losses.ring),
        ] {
            assert_close(importer.get(name), expected, 1e-9, name);
        }
        assert_eq!(importer.is("macroSlip"), outputs.macro_slip);
    }
}

#[test]
fn fields_along_the_belt_are_arrays() {
    let importer = Importer::running(Three);
    importer.advance(0.0, 3e-3);
    let array = |name| importer.reals(&[reference(name)], 72).expect("an array");
    let places = array("profile.position");
    let spacing = places[1];
    assert!(spacing > 5e-3 && spacing < 2e-2, "{spacing} m between places");
    for (k, place) in (0..).zip(places) {
        assert!((place - f64::from(k) * spacing).abs() < 1e-9, "{k}");
    }
    let force = array("profile.pushForce").into_iter().fold(0.0, f64::max);
    let most = importer.get("pushForce.max");
    assert!(force <= most * (1.0 + 1e-12) && force > 0.5 * most, "{force} of {most}");
}

/// A run: what is set first, the inputs of each step, and its size, s.
struct Run {
    set: fn(&Importer),
    steps: Vec<Vec<(&'static str, f64)>>,
    size: f64,
}

fn rows(run: &Run, version: Version, handles: Handles<'_>) -> Vec<Vec<u64>> {
    let importer = Importer::handling(version, handles);
    (run.set)(&importer);
    importer.start();
    let step = |(k, inputs): (u32, &Vec<(&str, f64)>)| {
        inputs.iter().for_each(|(name, value)| importer.put(name, *value));
        let ended = importer.step(f64::from(k) * run.size, run.size);
        assert_eq!((ended.status, ended.early), (Ok, false), "{}", importer.last());
        if ended.event {
            assert_eq!(importer.enter_event_mode(), Ok);
            importer.handle_event();
        }
        importer.readings()
    };
    (0..).zip(&run.steps).map(step).collect()
}

/// The versions agree to the last bit, also with intermediate updates in which the master does nothing.
fn check(run: &Run) {
    let expected = rows(run, Two, Handles::default());
    let required = ["thrustRatio", "primary.torque"].map(reference);
    for (events, early_return, required) in [(false, false, &[][..]), (false, true, &required), (true, false, &[])] {
        let handles = Handles::of(events, early_return, required);
        let found = rows(run, Three, handles);
        let differs = expected.iter().zip(&found).position(|(a, b)| a != b);
        assert_eq!(differs, None, "the first step that differs");
    }
}

#[test]
fn the_default_experiment_has_the_same_bits_in_both_versions() {
    check(&Run {
        set: |_| {},
        steps: vec![vec![]; 300],
        size: 1e-3,
    });
}

/// The manoeuvre's first two seconds, with the launch, on the reference ring; all of it is a test of the packed FMUs.
#[test]
fn the_manoeuvre_has_the_same_bits_in_both_versions() {
    let manoeuvre = Manoeuvre::read();
    let steps = (0..2000).map(|k| {
        let inputs = manoeuvre.at(f64::from(k) * 1e-3);
        vec![
            ("primary.torque", inputs.primary.torque),
            ("secondary.torque", inputs.secondary.torque),
            ("primary.clampingForce", inputs.primary.clamping_force),
            ("secondary.clampingForce", inputs.secondary.clamping_force),
        ]
    });
    check(&Run {
        set: |importer| {
            importer.choose("ring.model", 1);
            importer.put("secondary.inertia", 4.0);
            importer.put("initial.ratio", 2.2);
            importer.put("initial.primarySpeed", 0.0);
        },
        steps: steps.collect(),
        size: 1e-3,
    });
}

#[test]
fn real_time_has_the_same_bits_in_both_versions() {
    let steps = (0..100).map(|k| vec![("primary.torque", 50.0 + f64::from(k % 7) * 20.0)]);
    check(&Run {
        set: |importer| {
            importer.choose("solver.mode", 2);
            importer.choose("ring.model", 1);
            importer.flag("initial.steady", true);
        },
        steps: steps.collect(),
        size: 3.5e-3,
    });
}

#[test]
fn a_reset_instance_equals_a_fresh_one_and_no_other_instance_matters() {
    for version in BOTH {
        let alone = Importer::running(version).run(0);
        let [one, other] = [(); 2].map(|()| Importer::running(version));
        other.put("friction.pulley", 0.05);
        other.advance(0.0, 0.004);
        assert_eq!(one.run(0), alone);
        one.put("friction.ring", 0.01);
        assert_eq!(one.reset(), Ok);
        one.make_coarse();
        one.start();
        assert_eq!((one.get("friction.ring"), one.get("secondary.torque")), (0.05, -49.0));
        assert_eq!(one.run(0), alone);
    }
}

/// A steady start, a linear model, steps, slip through the belt, a stored state, on a host that traps, flushes or rounds upward.
#[cfg(target_arch = "x86_64")]
#[test]
fn every_host_gets_the_same_bits_and_keeps_its_environment() {
    use crate::environment::{DEFAULT, HOSTS, present, within};
    use std::cell::RefCell;
    use std::rc::Rc;

    let run = |version, times: &[f64]| {
        let speed = [reference("primary.speed")];
        let handles = Handles::of(false, true, &speed);
        let importer = Importer::coarse(version, handles);
        importer.flag("initial.steady", true);
        importer.start();
        let seen = Rc::new(RefCell::new((Vec::new(), Vec::new())));
        let (alias, record) = (importer.alias(), Rc::clone(&seen));
        importer.answer(move |_| {
            let before = present();
            let speed = alias.get("primary.speed").to_bits();
            let (speeds, environments) = &mut *record.borrow_mut();
            speeds.push(speed);
            environments.extend([before, present()]);
            None
        });
        let mut readings = vec![importer.readings()];
        if version == Two {
            let (status, json) = crate::linear::text(&importer, 100.0);
            assert!(status <= pushbelt::fmi::log::Status::Warning);
            readings.push(json.expect("a model").bytes().map(u64::from).collect());
        }
        let step = |k: usize| {
            importer.advance(times[k], 1e-3);
            importer.readings()
        };
        readings.extend((0..3).map(step));
        readings.push(importer.slopes());
        let bytes = importer.bytes();
        importer.put("primary.torque", 400.0);
        readings.extend((3..20).map(step));
        assert!(importer.is("macroSlip"));
        assert_eq!(importer.continue_from(&bytes), Ok);
        readings.extend((3..6).map(step));
        drop(importer);
        let (speeds, environments) = seen.take();
        readings.push(speeds);
        (readings, environments)
    };
    let times: Vec<f64> = (0..30).map(|k| f64::from(k) * 1e-3).collect();
    for version in BOTH {
        let (expected, seen) = within(DEFAULT, || run(version, &times));
        assert_eq!(seen.is_empty(), version == Two);
        for host in HOSTS {
            let (readings, seen) = within(host, || run(version, &times));
            assert!(readings == expected, "{host:?}");
            assert!(seen.iter().all(|of_callback| *of_callback == host), "{host:?}");
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

/// A step from `from`, s, is discarded, and all is as before: outputs, counts of work and flags.
fn discard(importer: &Importer, from: f64, size: f64) {
    let everything = || {
        let counts = ["solver.steps", "solver.jacobians", "solver.residuals"].map(|name| importer.count(name));
        (importer.readings(), counts, importer.is("macroSlip"))
    };
    let before = everything();
    let discarded = Ended {
        status: Discard,
        event: false,
        early: false,
        time: from,
    };
    assert_eq!(importer.step(from, size), discarded);
    assert_eq!(everything(), before);
}

/// An instance with the least friction velocity, on which the largest loads are too much, after a step from 0 s.
fn fragile(version: Version, handles: Handles<'_>, tolerance: f64, size: f64) -> Importer {
    let importer = Importer::handling(version, handles);
    importer.put("solver.tolerance", tolerance);
    importer.put("friction.velocity", 1e-6);
    importer.put("inputs.ramp", 0.0);
    importer.start();
    importer.advance(0.0, size);
    importer
}

/// Too much for the error control at a very small tolerance.
#[test]
fn a_step_that_stalls_is_discarded_and_can_be_repeated() {
    let importer = fragile(Two, Handles::default(), 1e-9, 1e-4);
    let mut stored = importer.stored();
    let repeat = |discarded: bool| {
        if discarded {
            set_largest_loads(&importer);
            discard(&importer, 1e-4, 2e-3);
            importer.assert_logged("stalled at 0.0");
        }
        assert_eq!(importer.restore(stored), Ok);
        importer.advance(1e-4, 2e-5);
        importer.readings()
    };
    let expected = repeat(false);
    assert_eq!(importer.restore(stored), Ok);
    assert_eq!(repeat(true), expected, "a smaller step after a rollback");
    assert_eq!(importer.free(&mut stored), Ok);
}

/// The work of a step is bounded. The largest loads exceed the bound within two milliseconds. With gentler loads the step can be repeated,
/// without a stored state.
#[test]
fn a_step_that_takes_too_much_work_is_discarded_and_can_be_repeated() {
    let required = ["primary.torque", "primary.speed"].map(reference);
    let watched = Handles::of(false, true, &required);
    for (version, handles) in [(Two, Handles::default()), (Three, watched)] {
        let importer = fragile(version, handles, 1e-4, 1e-3);
        let gentle = LOADS.map(|name| (name, importer.get(name)));
        let step_gently = |step: f64| {
            gentle.iter().for_each(|(name, load)| importer.put(name, *load));
            importer.advance(1e-3, step);
            importer.readings()
        };
        let mut before = importer.stored();
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
        let mut after = importer.stored();
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
        assert_eq!(importer.free(&mut after), Ok);
        assert_eq!(importer.free(&mut before), Ok);
    }
}
