//! The same run by both versions, with and without intermediate updates, has the same bits.

use std::ffi::{CString, c_int};
use std::ptr::null;

use pushbelt::fmi::guid;
use pushbelt::fmi::log::Status::Ok;
use pushbelt::unit::VariatorUnit;
use pushbelt::unit::exports::c_abi::*;
use pushbelt_lab::manoeuvre::Manoeuvre;

use crate::importer::*;

/// Inputs of a step, by name.
type Inputs = Vec<(&'static str, f64)>;

/// A run: integers and reals that are set first, the inputs of each step, and its size, s.
struct Run {
    choices: Vec<(&'static str, i64)>,
    reals: Vec<(&'static str, f64)>,
    booleans: Vec<(&'static str, bool)>,
    steps: Vec<Inputs>,
    size: f64,
}

fn by_fmi2(run: &Run) -> Vec<Vec<u64>> {
    let outputs = real_outputs();
    let guid = CString::new(guid::<VariatorUnit>()).expect("no zero inside");
    // SAFETY: an instance, and arrays of the given lengths.
    unsafe {
        let c = fmi2Instantiate(c"two".as_ptr(), 1, guid.as_ptr(), null(), null(), 0, 0);
        for (name, value) in &run.choices {
            let value = c_int::try_from(*value).expect("small");
            assert_eq!(fmi2SetInteger(c, &reference(name), 1, &value), Ok);
        }
        for (name, value) in &run.reals {
            assert_eq!(fmi2SetReal(c, &reference(name), 1, value), Ok);
        }
        for (name, value) in &run.booleans {
            assert_eq!(fmi2SetBoolean(c, &reference(name), 1, &c_int::from(*value)), Ok);
        }
        assert_eq!(fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0), Ok);
        assert_eq!(fmi2EnterInitializationMode(c), Ok);
        assert_eq!(fmi2ExitInitializationMode(c), Ok);
        let mut rows = Vec::new();
        for (k, inputs) in (0_u32..).zip(&run.steps) {
            for (name, value) in inputs {
                assert_eq!(fmi2SetReal(c, &reference(name), 1, value), Ok);
            }
            assert_eq!(fmi2DoStep(c, f64::from(k) * run.size, run.size, 1), Ok);
            let mut values = vec![f64::NAN; outputs.len()];
            assert_eq!(fmi2GetReal(c, outputs.as_ptr(), outputs.len(), values.as_mut_ptr()), Ok);
            rows.push(values.into_iter().map(f64::to_bits).collect());
        }
        fmi2FreeInstance(c);
        rows
    }
}

fn by_fmi3(run: &Run, handles: Handles<'_>) -> Vec<Vec<u64>> {
    use pushbelt::unit::exports::c_abi3::*;
    let outputs = real_outputs();
    let importer = Importer::new(handles);
    for (name, value) in &run.choices {
        assert_eq!(importer.set_choice(name, *value), Ok);
    }
    for (name, value) in &run.reals {
        assert_eq!(importer.set_real(name, *value), Ok);
    }
    for (name, value) in &run.booleans {
        assert_eq!(importer.set_boolean(name, u8::from(*value)), Ok);
    }
    // SAFETY: an instance.
    unsafe {
        assert_eq!(fmi3EnterInitializationMode(importer.c, 0, 0.0, 0.0, 0, 0.0), Ok);
        assert_eq!(fmi3ExitInitializationMode(importer.c), Ok);
    }
    if handles.events {
        importer.handle_event(false);
    }
    let mut rows = Vec::new();
    for (k, inputs) in (0_u32..).zip(&run.steps) {
        for (name, value) in inputs {
            assert_eq!(importer.set_real(name, *value), Ok);
        }
        let ended = importer.step(f64::from(k) * run.size, run.size);
        assert_eq!((ended.status, ended.early), (Ok, false), "{}", importer.last());
        if ended.event {
            importer.handle_event(true);
        }
        let mut values = vec![f64::NAN; outputs.len()];
        // SAFETY: an instance, and as many values as references.
        let status = unsafe {
            fmi3GetFloat64(
                importer.c,
                outputs.as_ptr(),
                outputs.len(),
                values.as_mut_ptr(),
                values.len(),
            )
        };
        assert_eq!(status, Ok);
        rows.push(values.into_iter().map(f64::to_bits).collect());
    }
    rows
}

/// The versions agree to the last bit, also with intermediate updates in which the master does nothing.
fn check(run: &Run) {
    let expected = by_fmi2(run);
    for handles in [
        Handles::default(),
        Handles {
            events: false,
            early_return: true,
            required: &["thrustRatio", "primary.torque"],
        },
        Handles {
            events: true,
            early_return: false,
            required: &[],
        },
    ] {
        let found = by_fmi3(run, handles);
        let differs = expected.iter().zip(&found).position(|(a, b)| a != b);
        assert_eq!(differs, None, "the first step that differs");
    }
}

#[test]
fn the_default_experiment_has_the_same_bits() {
    check(&Run {
        choices: vec![],
        reals: vec![],
        booleans: vec![],
        steps: vec![vec![]; 300],
        size: 1e-3,
    });
}

/// The manoeuvre's first two seconds, with the launch, on the reference ring; all of it is a test of the packed FMUs.
#[test]
fn the_manoeuvre_has_the_same_bits() {
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
        choices: vec![("ring.model", 1)],
        reals: vec![
            ("secondary.inertia", 4.0),
            ("initial.ratio", 2.2),
            ("initial.primarySpeed", 0.0),
        ],
        booleans: vec![],
        steps: steps.collect(),
        size: 1e-3,
    });
}

#[test]
fn real_time_has_the_same_bits() {
    let steps = (0..100).map(|k| vec![("primary.torque", 50.0 + f64::from(k % 7) * 20.0)]);
    check(&Run {
        choices: vec![("solver.mode", 2), ("ring.model", 1)],
        reals: vec![],
        booleans: vec![("initial.steady", true)],
        steps: steps.collect(),
        size: 3.5e-3,
    });
}
