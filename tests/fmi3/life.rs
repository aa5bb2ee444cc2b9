//! The life cycle of an instance, and functions that are not supported.

use std::ffi::CStr;
use std::ptr::{null, null_mut};

use pushbelt::fmi::fmi3::{Environment, Text};
use pushbelt::fmi::log::Status::{self, Discard, Error, Ok};
use pushbelt::unit::exports::c_abi3::*;
use pushbelt::unit::model_description3;

use crate::importer::*;

#[test]
fn the_version_is_that_of_the_standard() {
    // SAFETY: a constant string.
    assert_eq!(unsafe { CStr::from_ptr(fmi3GetVersion()) }, c"3.0");
}

#[test]
fn an_instance_needs_a_name_the_right_token_and_variables_that_exist() {
    let token = token();
    let make = |name: Text, token: Text, required: &[u32]| {
        let c = instantiate(name, token, required);
        // SAFETY: what comes back is freed at once.
        unsafe { fmi3FreeInstance(c) };
        !c.is_null()
    };
    let name = c"a".as_ptr();
    assert!(make(name, token.as_ptr(), &[]));
    assert!(make(
        name,
        token.as_ptr(),
        &[reference("primary.torque"), reference("thrustRatio")]
    ));
    assert!(!make(null(), token.as_ptr(), &[]));
    assert!(!make(c" ".as_ptr(), token.as_ptr(), &[]));
    assert!(!make(name, null(), &[]));
    assert!(!make(name, c"{8c4e810f-3df3-4a00-8276-176fa3c9f003}".as_ptr(), &[]));
    assert!(!make(name, token.as_ptr(), &[77]));
    for warned in ["macroSlip", "friction.pulley", "stored.energy"] {
        assert!(make(name, token.as_ptr(), &[reference(warned)]), "{warned}");
    }
    assert!(model_description3().contains(token.to_str().expect("ASCII")));
}

#[test]
fn other_kinds_of_fmu_are_refused_with_a_message() {
    let importer = Importer::new(Handles::default());
    let environment = std::ptr::from_ref(&*importer.record).cast_mut().cast();
    unsafe extern "C" fn log_message(environment: Environment, status: i32, _: Text, message: Text) {
        // SAFETY: the `Record` of the importer, and a message.
        unsafe {
            let record = &*environment.cast::<Record>();
            let message = CStr::from_ptr(message).to_string_lossy().into_owned();
            record.messages.borrow_mut().push((status, String::new(), message));
        }
    }
    // SAFETY: valid strings, and null where it is allowed.
    unsafe {
        let (name, token) = (c"a".as_ptr(), token());
        let exchange = fmi3InstantiateModelExchange(name, token.as_ptr(), null(), 0, 1, environment, Some(log_message));
        assert!(exchange.is_null());
        assert!(
            importer
                .last()
                .contains("fmi3InstantiateModelExchange: this FMU is for co-simulation only")
        );
        let scheduled = fmi3InstantiateScheduledExecution(
            name,
            token.as_ptr(),
            null(),
            0,
            1,
            environment,
            Some(log_message),
            null(),
            null(),
            null(),
        );
        assert!(scheduled.is_null());
        assert!(importer.last().contains("fmi3InstantiateScheduledExecution"));
    }
}

#[test]
fn a_run_goes_through_its_states() {
    let importer = Importer::new(Handles::default());
    let c = importer.c;
    assert_eq!(
        importer.real("primary.torque"),
        50.0,
        "start values can be read at once"
    );
    let mut value = 0.0;
    // SAFETY: an instance and places for values.
    unsafe {
        assert_eq!(
            fmi3GetFloat64(c, &reference("thrustRatio"), 1, &raw mut value, 1),
            Error
        );
        assert!(
            importer.last().contains("before initialization mode"),
            "{}",
            importer.last()
        );
        assert_eq!(importer.step(0.0, 1e-3).status, Error);
        assert_eq!(
            importer.last(),
            "fmi3DoStep: not allowed while the instance is instantiated"
        );
        importer.make_cheap();
        assert_eq!(
            fmi3EnterInitializationMode(c, 0, 0.0, 1.0, 1, 0.5),
            Error,
            "stops before it starts"
        );
        assert!(
            importer
                .last()
                .starts_with("fmi3EnterInitializationMode: the stop time 0.5 s")
        );
        assert_eq!(fmi3EnterInitializationMode(c, 0, 0.0, 1.0, 1, 1.002), Ok);
        assert_eq!(importer.real("time"), 1.0);
        assert!(importer.real("primary.speed") > 0.0);
        assert_eq!(fmi3ExitInitializationMode(c), Ok);
        assert_eq!(fmi3EnterEventMode(c), Error, "made without event mode");
        assert!(importer.last().contains("eventModeUsed"));
        assert_eq!(fmi3EnterStepMode(c), Error);
        for k in 0..2 {
            let from = 1.0 + f64::from(k) * 1e-3;
            let ended = importer.step(from, 1e-3);
            assert_eq!((ended.status, ended.event, ended.early), (Ok, false, false));
            assert_eq!((ended.time, importer.real("time")), (from + 1e-3, from + 1e-3));
        }
        assert_eq!(importer.step(1.002, 1e-3).status, Error);
        assert!(importer.last().contains("after the stop time"));
        assert_eq!(fmi3Terminate(c), Ok);
        assert!(importer.real("primary.speed") > 0.0, "last values can be read");
        assert_eq!(importer.step(1.002, 1e-3).status, Error);
        assert_eq!(fmi3Reset(c), Ok);
        assert_eq!(fmi3Terminate(c), Error);
    }
}

#[test]
fn unsupported_functions_are_refused() {
    let importer = Importer::running(Handles::default());
    let c = importer.c;
    let (mut flag, mut number, mut count) = (0, 0.0, 0);
    let (mut flag2, mut kind, mut vr) = (0, 0, 0);
    // SAFETY: an instance and places for values.
    let refused: [(Status, &str); 18] = unsafe {
        [
            (
                fmi3GetDirectionalDerivative(c, &1, 1, &101, 1, &1.0, 1, &raw mut number, 1),
                "providesDirectionalDerivatives",
            ),
            (
                fmi3GetAdjointDerivative(c, &1, 1, &101, 1, &1.0, 1, &raw mut number, 1),
                "providesAdjointDerivatives",
            ),
            (
                fmi3GetNumberOfVariableDependencies(c, 1, &raw mut count),
                "providesPerElementDependencies",
            ),
            (
                fmi3GetVariableDependencies(c, 1, null_mut(), &raw mut vr, null_mut(), &raw mut kind, 1),
                "providesPerElementDependencies",
            ),
            (fmi3EnterConfigurationMode(c), "structural"),
            (fmi3ExitConfigurationMode(c), "structural"),
            (fmi3EvaluateDiscreteStates(c), "discrete states"),
            (fmi3EnterContinuousTimeMode(c), "co-simulation only"),
            (
                fmi3CompletedIntegratorStep(c, 1, &raw mut flag, &raw mut flag2),
                "co-simulation only",
            ),
            (fmi3SetTime(c, 1.0), "co-simulation only"),
            (fmi3SetContinuousStates(c, &1.0, 1), "co-simulation only"),
            (
                fmi3GetContinuousStateDerivatives(c, &raw mut number, 1),
                "co-simulation only",
            ),
            (fmi3GetEventIndicators(c, &raw mut number, 1), "co-simulation only"),
            (fmi3GetContinuousStates(c, &raw mut number, 1), "co-simulation only"),
            (
                fmi3GetNominalsOfContinuousStates(c, &raw mut number, 1),
                "co-simulation only",
            ),
            (fmi3GetNumberOfEventIndicators(c, &raw mut count), "co-simulation only"),
            (fmi3GetNumberOfContinuousStates(c, &raw mut count), "co-simulation only"),
            (fmi3ActivateModelPartition(c, 1, 0.0), "co-simulation only"),
        ]
    };
    let messages = importer.record.messages.borrow();
    let logged: Vec<_> = messages
        .iter()
        .filter(|(_, _, text)| text.contains("not supported"))
        .collect();
    assert_eq!(logged.len(), refused.len());
    for ((status, words), (_, category, text)) in refused.iter().zip(logged) {
        assert_eq!((*status, category.as_str()), (Error, "logStatusError"));
        assert!(text.contains(words), "{text}");
    }
    drop(messages);
    assert_eq!(importer.step(0.0, 1e-3).status, Ok, "and nothing has changed");
}

/// Without debug logging the callback for messages is called for errors.
#[test]
fn an_instance_without_logging_sends_errors_only() {
    let importer = Importer::new(Handles::default());
    // SAFETY: an instance, no categories.
    unsafe {
        assert_eq!(fmi3SetDebugLogging(importer.c, 0, 0, null()), Ok);
        importer.record.messages.borrow_mut().clear();
        assert_eq!(importer.set_real("primary.clampingForce", -5.0), Discard);
        assert!(importer.record.messages.borrow().is_empty());
        assert_eq!(importer.step(0.0, 1.0).status, Error);
        assert_eq!(importer.record.messages.borrow().len(), 1);
        importer.record.messages.borrow_mut().clear();
        let category = c"logStatusError".as_ptr();
        assert_eq!(fmi3SetDebugLogging(importer.c, 1, 1, &category), Ok);
        assert_eq!(importer.step(0.0, 1.0).status, Error);
        assert_eq!(importer.record.messages.borrow().len(), 1);
        assert_eq!(fmi3SetDebugLogging(importer.c, 1, 1, &c"noise #1".as_ptr()), Error);
    }
    assert!(importer.last().contains("\"noise ##1\""), "a number sign is doubled");
}

/// What can hardly be meant is a warning in the log.
#[test]
fn implausible_loads_are_logged() {
    let importer = Importer::new(Handles::default());
    importer.make_cheap();
    assert_eq!(importer.set_boolean("initial.steady", 1), Ok);
    assert_eq!(importer.set_real("initial.primarySpeed", 2000.0), Ok);
    importer.start(false);
    let messages = importer.record.messages.borrow();
    assert!(
        messages
            .iter()
            .any(|(_, category, text)| category == "logStatusWarning" && text.contains("initial.primarySpeed in rpm"))
    );
}
