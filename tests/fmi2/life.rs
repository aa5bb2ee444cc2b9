//! The life cycle of an instance: creation, the states of a run, reset, failures.

use std::ffi::{CStr, c_char, c_int};
use std::ptr::{null, null_mut};

use pushbelt::fmi::fmi2::CallbackFunctions;
use pushbelt::fmi::log::Status::{self, Discard, Error, Ok};
use pushbelt::unit::exports::c_abi::*;
use pushbelt::unit::model_description;
use pushbelt::variator::run::Variator;
use pushbelt::variator::settings::{Inputs, Parameters, RingModel};
use pushbelt_lab::checks::assert_close;

use crate::importer::*;

#[test]
fn platform_and_version_are_those_of_the_standard() {
    // SAFETY: both are constant strings.
    unsafe {
        assert_eq!(CStr::from_ptr(fmi2GetTypesPlatform()), c"default");
        assert_eq!(CStr::from_ptr(fmi2GetVersion()), c"2.0");
    }
}

#[test]
fn an_instance_needs_a_name_the_right_guid_and_co_simulation() {
    let guid = guid();
    let make = |name: *const c_char, kind, guid: *const c_char, location: *const c_char| {
        // SAFETY: null or valid strings; what comes back is freed at once.
        unsafe {
            let c = fmi2Instantiate(name, kind, guid, location, null(), 0, 1);
            fmi2FreeInstance(c);
            !c.is_null()
        }
    };
    let name = c"a".as_ptr();
    assert!(make(name, 1, guid.as_ptr(), null()), "no logger, no location");
    for location in [c"file:/tmp", c"file:///tmp", c"https://x/y", c"", c"%"] {
        assert!(make(name, 1, guid.as_ptr(), location.as_ptr()), "{location:?}");
    }
    assert!(!make(null(), 1, guid.as_ptr(), null()));
    assert!(!make(c"".as_ptr(), 1, guid.as_ptr(), null()));
    assert!(!make(name, 0, guid.as_ptr(), null()), "model exchange");
    assert!(!make(name, 1, null(), null()));
    assert!(!make(
        name,
        1,
        c"{8c4e810f-3df3-4a00-8276-176fa3c9f003}".as_ptr(),
        null()
    ));
    assert!(model_description().contains(guid.to_str().expect("ASCII")));
}

/// The variator that [`Importer::make_cheap`] sets, without the interface.
fn cheap_variator() -> Variator {
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

/// Outputs are those that the library calculates for the same variator.
#[test]
fn a_run_without_wiring_goes_through_all_its_states() {
    let importer = Importer::running(c"run");
    let mut variator = cheap_variator();
    assert_eq!(importer.real("primary.clampingForce"), 13_000.0);
    for k in 0..10 {
        assert_eq!(importer.step(f64::from(k) * 0.001, 0.001), Ok, "{:?}", importer.record);
        variator
            .advance(f64::from(k + 1) * 0.001, &Inputs::default())
            .expect("a step");
        let outputs = variator.outputs().clone();
        let tension = variator.profile().ring_tension[71];
        for (name, expected) in [
            ("thrustRatio", outputs.thrust_ratio),
            ("belt.speed", outputs.belt_speed),
            ("loss.ring", outputs.losses.ring),
            ("profile.ringTension[72]", tension),
        ] {
            assert_close(importer.real(name), expected, 1e-9, name);
        }
        assert_eq!(importer.boolean("macroSlip"), c_int::from(outputs.macro_slip));
    }
    let last = importer.readings();
    // SAFETY: an instance.
    unsafe {
        let mut time = 0.0;
        assert_eq!(fmi2GetRealStatus(importer.c, 2, &mut time), Ok);
        assert!((time - 0.01).abs() < 1e-12);
        assert_eq!(fmi2Terminate(importer.c), Ok);
        assert_eq!(fmi2DoStep(importer.c, 0.01, 0.001, 0), Error);
    }
    assert_eq!(importer.readings(), last, "a terminated run keeps its outputs");
}

/// All loads at the ends of their ranges.
fn set_largest_loads(importer: &Importer) {
    for (name, load) in LOADS.into_iter().zip([5e5, 5e5, 1e4, -1e4]) {
        assert_eq!(importer.set_real(name, load), Ok);
    }
}

/// Outputs, counts of work and flags.
fn everything(importer: &Importer) -> (Vec<u64>, [c_int; 4]) {
    let counts = ["solver.steps", "solver.jacobians", "solver.residuals"].map(|name| importer.integer(name));
    let [steps, jacobians, residuals] = counts;
    (
        importer.readings(),
        [steps, jacobians, residuals, importer.boolean("macroSlip")],
    )
}

/// A step from `from`, s, is discarded, and all is as before.
fn discard(importer: &Importer, from: f64, step: f64) {
    let before = everything(importer);
    let (mut reached, mut status, mut terminated) = (f64::NAN, -1, -1);
    assert_eq!(importer.step(from, step), Status::Discard);
    // SAFETY: an instance, and places for values.
    unsafe {
        assert_eq!(fmi2GetRealStatus(importer.c, 2, &mut reached), Ok);
        assert_eq!(fmi2GetStatus(importer.c, 0, &mut status), Ok);
        assert_eq!(fmi2GetBooleanStatus(importer.c, 3, &mut terminated), Ok);
    }
    assert_eq!((reached, status, terminated), (from, Status::Discard as c_int, 0));
    assert_eq!(everything(importer), before);
}

/// All loads at the ends of their ranges, with a very small tolerance and the least friction velocity: too much for the error control.
#[test]
fn a_step_that_fails_is_discarded_and_can_be_repeated() {
    let importer = Importer::new(c"discard");
    assert_eq!(importer.set_real("solver.tolerance", 1e-9), Ok);
    assert_eq!(importer.set_real("friction.velocity", 1e-6), Ok);
    assert_eq!(importer.set_real("inputs.ramp", 0.0), Ok);
    importer.start();
    assert_eq!(importer.step(0.0, 1e-4), Ok, "{:?}", importer.record);
    let (c, mut stored) = (importer.c, null_mut());
    // SAFETY: an instance and a state of it.
    unsafe {
        assert_eq!(fmi2GetFMUstate(c, &mut stored), Ok);
        set_largest_loads(&importer);
        discard(&importer, 1e-4, 1e-3);
        assert!(importer.last().contains("stalled at 0.000"), "{}", importer.last());
        // After rollback a smaller step gives the same bits as without the discarded one.
        assert_eq!(fmi2SetFMUstate(c, stored), Ok);
        assert_eq!(importer.step(1e-4, 2e-5), Ok);
        let expected = importer.readings();
        assert_eq!(fmi2SetFMUstate(c, stored), Ok);
        set_largest_loads(&importer);
        discard(&importer, 1e-4, 1e-3);
        assert_eq!(fmi2SetFMUstate(c, stored), Ok);
        assert_eq!(importer.step(1e-4, 2e-5), Ok);
        assert_eq!(importer.readings(), expected);
        assert_eq!(fmi2FreeFMUstate(c, &mut stored), Ok);
    }
}

const LOADS: [&str; 4] = [
    "primary.clampingForce",
    "secondary.clampingForce",
    "primary.torque",
    "secondary.torque",
];

/// The work of a step is bounded. Loads at the ends of their ranges exceed the bound within two milliseconds, at the least friction
/// velocity. With gentler loads the step can be repeated, without a stored state.
#[test]
fn a_step_that_takes_too_much_work_is_discarded_and_can_be_repeated() {
    let importer = Importer::new(c"work");
    assert_eq!(importer.set_real("friction.velocity", 1e-6), Ok);
    assert_eq!(importer.set_real("inputs.ramp", 0.0), Ok);
    importer.start();
    assert_eq!(importer.step(0.0, 1e-3), Ok, "{:?}", importer.record);
    let gentle = LOADS.map(|name| (name, importer.real(name)));
    let step_gently = |step: f64| {
        for (name, load) in gentle {
            assert_eq!(importer.set_real(name, load), Ok);
        }
        assert_eq!(importer.step(1e-3, step), Ok, "{:?}", importer.record);
        importer.readings()
    };
    let (c, mut before, mut after) = (importer.c, null_mut(), null_mut());
    // SAFETY: an instance and states of it.
    unsafe {
        assert_eq!(fmi2GetFMUstate(c, &mut before), Ok);
        step_gently(2e-3);
        let expected = importer.real("thrustRatio");
        assert_eq!(fmi2SetFMUstate(c, before), Ok);
        set_largest_loads(&importer);
        // Another friction coefficient would take effect in this step.
        assert_eq!(importer.set_real("friction.pulley", 0.1), Ok);
        discard(&importer, 1e-3, 2e-3);
        let text = importer.last();
        assert!(text.contains("far beyond what the belt transmits"), "{text}");
        let residuals: c_int = text
            .split_once("after ")
            .and_then(|(_, rest)| rest.split(' ').next()?.parse().ok())
            .expect("a count");
        assert!((11_000..13_000).contains(&residuals), "{residuals} residuals");
        assert_eq!(importer.set_real("friction.pulley", 0.09), Ok);
        assert_eq!(fmi2GetFMUstate(c, &mut after), Ok);
        let counted = importer.integer("solver.residuals");
        let repeated = step_gently(2e-3);
        assert_close(importer.real("thrustRatio"), expected, 1e-6, "repeated");
        // The work that was in vain is counted with that of the next step, which is ordinary.
        let ordinary = importer.integer("solver.residuals") - counted - residuals;
        assert!((1..100).contains(&ordinary), "{ordinary} residuals");
        assert_eq!(fmi2SetFMUstate(c, after), Ok);
        step_gently(1e-3);
        assert_eq!(fmi2SetFMUstate(c, after), Ok);
        assert_eq!(step_gently(2e-3), repeated, "from a state that was stored in between");
        assert_eq!(fmi2FreeFMUstate(c, &mut after), Ok);
        assert_eq!(fmi2FreeFMUstate(c, &mut before), Ok);
    }
}

#[test]
fn unsupported_functions_are_refused() {
    let importer = Importer::running(c"not supported");
    let c = importer.c;
    let says = |status, flag: &str| {
        assert_eq!(status, Error);
        assert!(importer.last().contains(flag), "{}", importer.last());
        assert!(!model_description().contains(&format!("{flag}=\"true\"")));
    };
    let (vr, mut value) = (101, 0.0);
    // SAFETY: an instance and valid pointers.
    unsafe {
        says(
            fmi2GetDirectionalDerivative(c, &1, 1, &vr, 1, &1.0, &mut value),
            "providesDirectionalDerivative",
        );
        assert_eq!(fmi2CancelStep(c), Error);
    }
    assert_eq!(importer.step(0.0, 0.001), Ok, "and harms nothing");
}

#[test]
fn status_calls_return_the_status_of_the_last_step() {
    let importer = Importer::running(c"status");
    let c = importer.c;
    let (mut real, mut integer, mut text) = (f64::NAN, -1, null());
    // SAFETY: an instance and valid or null pointers.
    unsafe {
        assert_eq!(fmi2GetRealStatus(c, 2, &mut real), Ok);
        assert_eq!(real, 0.0);
        assert_eq!(fmi2GetStatus(c, 0, &mut integer), Ok);
        assert_eq!(integer, 0);
        assert_eq!(fmi2GetBooleanStatus(c, 3, &mut integer), Ok);
        assert_eq!(integer, 0);
        assert_eq!(fmi2GetRealStatus(c, 0, &mut real), Status::Discard);
        assert_eq!(fmi2GetStatus(c, 2, &mut integer), Status::Discard);
        assert_eq!(fmi2GetBooleanStatus(c, 0, &mut integer), Status::Discard);
        assert_eq!(fmi2GetIntegerStatus(c, 0, &mut integer), Status::Discard);
        assert_eq!(fmi2GetStringStatus(c, 1, &mut text), Status::Discard);
        assert_eq!(fmi2GetRealStatus(c, 9, &mut real), Error);
        assert_eq!(fmi2GetRealStatus(c, 2, null_mut()), Error);
    }
}

#[test]
fn null_pointers_are_errors() {
    let importer = Importer::running(c"null");
    let c = importer.c;
    let vr = 1;
    // SAFETY: the functions accept null.
    unsafe {
        fmi2FreeInstance(null_mut());
        assert_eq!(fmi2Reset(null_mut()), Error);
        assert_eq!(fmi2DoStep(null_mut(), 0.0, 1.0, 1), Error);
        assert_eq!(fmi2GetReal(null_mut(), &vr, 1, &mut 0.0), Error);
        assert_eq!(fmi2GetReal(c, null(), 1, &mut 0.0), Error);
        assert_eq!(fmi2GetReal(c, &vr, 1, null_mut()), Error);
        assert_eq!(fmi2GetInteger(c, null(), 1, null_mut()), Error);
        assert_eq!(fmi2GetBoolean(c, null(), 1, null_mut()), Error);
        assert_eq!(fmi2GetString(c, null(), 1, null_mut()), Error);
        assert_eq!(fmi2SetReal(c, null(), 1, null()), Error);
        assert_eq!(fmi2SetInteger(c, null(), 1, null()), Error);
        assert_eq!(fmi2SetBoolean(c, null(), 1, null()), Error);
        assert_eq!(fmi2SetString(c, null(), 1, null()), Error);
        assert_eq!(fmi2SetDebugLogging(c, 1, 1, null()), Error);
        assert_eq!(fmi2SetDebugLogging(c, 1, 1, &null()), Error);
        assert_eq!(fmi2GetReal(c, null(), usize::MAX, null_mut()), Error);
        // Null is legal for an array without elements.
        assert_eq!(fmi2GetReal(c, null(), 0, null_mut()), Ok);
        assert_eq!(fmi2SetReal(c, null(), 0, null()), Ok);
        assert_eq!(fmi2GetString(c, null(), 0, null_mut()), Ok);
        assert_eq!(fmi2SetString(c, null(), 0, null()), Ok);
        assert_eq!(fmi2SetDebugLogging(c, 1, 0, null()), Ok);
        // There are no string variables.
        assert_eq!(fmi2GetString(c, &vr, 1, &mut null()), Error);
    }
    assert_eq!(importer.step(0.0, 0.001), Ok, "and nothing has changed");
}

#[test]
fn an_instance_without_a_logger_fails_silently() {
    let functions = CallbackFunctions {
        logger: None,
        allocate_memory: None,
        free_memory: None,
        step_finished: None,
        component_environment: null_mut(),
    };
    // SAFETY: all pointers are valid.
    unsafe {
        let c = fmi2Instantiate(c"mute".as_ptr(), 1, guid().as_ptr(), null(), &functions, 0, 1);
        assert!(!c.is_null());
        assert_eq!(fmi2DoStep(c, 0.0, 1.0, 1), Error);
        assert_eq!(fmi2SetReal(c, &reference("primary.torque"), 1, &f64::NAN), Discard);
        fmi2FreeInstance(c);
    }
}

#[test]
fn reset_is_allowed_in_every_state() {
    // SAFETY: an instance.
    unsafe {
        let importer = Importer::new(c"reset");
        let c = importer.c;
        assert_eq!(fmi2Reset(c), Ok, "instantiated");
        assert_eq!(fmi2EnterInitializationMode(c), Ok);
        assert_eq!(fmi2Reset(c), Ok, "initialization mode");
        importer.make_cheap();
        importer.start();
        assert_eq!(fmi2Reset(c), Ok, "step mode");
        importer.make_cheap();
        importer.start();
        assert_eq!(fmi2Terminate(c), Ok);
        assert_eq!(fmi2Reset(c), Ok, "terminated");
        assert_eq!(fmi2Reset(c), Ok);
        importer.make_cheap();
        assert_eq!(importer.set_real("geometry.beltLength", 0.3), Ok);
        assert_eq!(fmi2EnterInitializationMode(c), Ok);
        assert_eq!(fmi2ExitInitializationMode(c), Error, "no belt is that short");
        assert_eq!(fmi2ExitInitializationMode(c), Error);
        assert!(importer.last().contains("reset"), "{}", importer.last());
        assert_eq!(fmi2Reset(c), Ok, "error");
        importer.make_cheap();
        importer.start();
        assert_eq!(importer.step(0.0, 0.001), Ok, "time is back at the start");
    }
}
