//! What FMI 3.0 alone has, on a toy unit: arrays and the time, events, early returns, intermediate
//! updates.

#![allow(unsafe_code, reason = "C functions of the standard")]

use std::ffi::CStr;
use std::ptr::{null, null_mut};
use std::rc::Rc;

use pushbelt_fmi::Version::Three;
use pushbelt_fmi::fmi3::functions::*;
use pushbelt_fmi::log::Status::{self, Discard, Error, Ok};

use crate::importer::{Handles, Message, TIME, experiment, log_of_fmi3, token};
use crate::run::{ended, running};
use crate::tank::*;

const WATCHES: Handles<'_> = Handles::updates(&[TIME, INFLOW, LEVEL]);

fn running_with(handles: Handles<'_>) -> Importer {
    let importer = Importer::handling(Three, handles);
    importer.start();
    importer
}

#[test]
fn other_kinds_of_fmu_are_refused_with_a_message() {
    assert_eq!(NAMES.len(), 75);
    let importer = running(Three);
    let environment = Rc::as_ptr(&importer.record).cast_mut().cast();
    let (name, right) = (c"tank".as_ptr(), token::<Tank>(Three));
    let token = right.as_ptr();
    // SAFETY: valid strings, null where it is allowed, and the record of the importer.
    unsafe {
        assert_eq!(CStr::from_ptr(fmi3GetVersion::<Tank>()), c"3.0");
        assert!(fmi3InstantiateModelExchange::<Tank>(name, token, null(), 0, 0, null_mut(), None).is_null());
        let (log, clock) = (Some(log_of_fmi3 as _), null());
        fmi3InstantiateModelExchange::<Tank>(name, token, null(), 0, 0, environment, log);
        importer.assert_logged("fmi3InstantiateModelExchange: this FMU is for co-simulation only");
        let other = fmi3InstantiateScheduledExecution::<Tank>(
            name,
            token,
            null(),
            0,
            0,
            environment,
            log,
            clock,
            clock,
            clock,
        );
        assert!(other.is_null());
        importer.assert_logged("fmi3InstantiateScheduledExecution: this FMU is for co-simulation only");
        let c = fmi3InstantiateCoSimulation::<Tank>(
            name,
            token,
            null(),
            0,
            1,
            0,
            0,
            null(),
            0,
            null_mut(),
            None,
            None,
        );
        assert_eq!(fmi3Terminate::<Tank>(c), Error);
        fmi3FreeInstance::<Tank>(c);
        fmi3FreeInstance::<Tank>(null_mut());
        assert_eq!(fmi3Terminate::<Tank>(null_mut()), Error);
    }
}

#[test]
fn start_values_and_the_time_can_be_read_at_once() {
    let importer = Importer::new(Three);
    assert_eq!(importer.real(START), 1.0);
    importer.assert(importer.reals(&[LEVEL], 1), Err(Error), "before initialization mode");
    assert_eq!(importer.enter(experiment(1.0, None)), Ok);
    assert_eq!(importer.real(TIME), 1.0);
    assert_eq!(importer.exit(), Ok);
    assert_eq!(importer.step(1.0, 1.0), ended(false, false, 2.0));
    assert_eq!(importer.real(TIME), 2.0);
    // SAFETY: an instance, and null for the results.
    unsafe {
        let refused =
            fmi3DoStep::<Tank>(importer.c, 2.0, 1.0, 1, null_mut(), null_mut(), null_mut(), null_mut());
        importer.assert(refused, Error, "the pointer for the result is null");
        importer.assert(fmi3EnterEventMode::<Tank>(importer.c), Error, "eventModeUsed");
        assert_eq!(fmi3EnterStepMode::<Tank>(importer.c), Error);
    }
}

#[test]
fn types_are_those_of_the_description() {
    let importer = Importer::new(Three);
    let (c, mut truth, mut single) = (importer.c, 0, 0.0);
    let check = |status, expected: Status, why| importer.assert(status, expected, why);
    // SAFETY: an instance, and places for values.
    unsafe {
        check(fmi3SetInt32::<Tank>(c, &SHAPE, 1, &2, 1), Error, "another type");
        check(fmi3SetInt64::<Tank>(c, &FLOORS, 1, &2, 1), Error, "another type");
        let large = fmi3SetInt64::<Tank>(c, &SHAPE, 1, &(1 << 40), 1);
        check(large, Discard, "shape = 1099511627776 is out of range");
        let none = fmi3GetBoolean::<Tank>(c, &LOCKED, 1, &raw mut truth, 0);
        check(none, Error, "0 values for 1 variables");
        let short = fmi3GetFloat32::<Tank>(c, &LEVEL, 1, &raw mut single, 1);
        check(short, Error, "no 32-bit real has the value reference 5");
        check(fmi3SetString::<Tank>(c, &LEVEL, 1, &null(), 1), Error, "no string");
        check(fmi3SetBinary::<Tank>(c, &LEVEL, 1, &1, &null(), 1), Error, "no binary");
        check(fmi3GetClock::<Tank>(c, &LEVEL, 1, &raw mut truth), Error, "no clock");
        check(fmi3SetShiftDecimal::<Tank>(c, &LEVEL, 1, &0.0), Error, "no clock");
        check(fmi3GetBinary::<Tank>(c, null(), 0, null_mut(), null_mut(), 0), Ok, "");
        check(fmi3GetString::<Tank>(c, null(), 0, null_mut(), 0), Ok, "");
    }
}

#[test]
fn arrays_lie_between_scalars_and_the_time() {
    let importer = running(Three);
    assert_eq!(importer.step(0.0, 0.5).status, Ok);
    let references = [INFLOW, DEPTH, TIME, LEVEL];
    importer.assert_reals(&references, &[2.0, 0.0, 1.0, 2.0, 0.5, 2.0]);
    for count in [4, 5, 7] {
        assert_eq!(importer.reals(&references, count), Err(Error));
        importer.assert_logged(&format!("{count} values for 4 variables, which have 6 values together"));
    }
    importer.assert(importer.reals(&[DEPTH + 1], 1), Err(Error), "element of depth");
    let mut values = [0.0; 2];
    // SAFETY: an instance, and arrays with the given lengths.
    let refused =
        unsafe { fmi3GetOutputDerivatives::<Tank>(importer.c, &LEVEL, 1, &1, values.as_mut_ptr(), 2) };
    importer.assert(refused, Error, "2 values for 1 variables");
}

#[test]
fn an_event_ends_a_step_that_may_end_early() {
    let importer = running_with(Handles::EVENTS);
    assert_eq!(importer.set(MARK, 2.2), Ok);
    assert_eq!(importer.step(0.0, 2.0), ended(true, true, 0.75));
    importer.assert_logged("event at 0.75 s: the level reaches 2.2");
    let event = importer.record.messages.borrow().last().expect("it").clone();
    assert_eq!((event.status, &*event.category), (0, "logEvents"));
    let flag: *mut u8 = &mut 9;
    let update = |time: *mut f64| {
        // SAFETY: an instance, and places for results or null.
        unsafe { fmi3UpdateDiscreteStates::<Tank>(importer.c, flag, flag, flag, flag, flag, time) }
    };
    assert_eq!(update(&mut 1.0), Error, "not in step mode");
    assert_eq!([importer.enter_event_mode(), importer.enter_event_mode()], [Ok, Error]);
    assert_eq!(update(null_mut()), Error);
    assert_eq!(importer.step(0.75, 1.0).status, Error, "first the event");
    assert_eq!(importer.set(INFLOW, 1.0), Ok);
    importer.handle_event();
    assert_eq!(importer.step(0.75, 1.25), ended(false, false, 2.0));
    assert_eq!(importer.real(LEVEL), 3.75);
    for (events, early_return, event) in [(true, false, true), (false, true, false), (false, false, false)] {
        let importer = running_with(Handles {
            events,
            early_return,
            required: &[],
        });
        assert_eq!(importer.set(MARK, 2.2), Ok);
        assert_eq!(importer.step(0.0, 2.0), ended(event, false, 2.0));
    }
}

#[test]
fn an_importer_reads_sets_and_returns_within_a_step() {
    let importer = running_with(WATCHES);
    let alias = importer.alias();
    importer.answer(move |update| {
        let time = update.time;
        assert_eq!(alias.real(TIME), time);
        let level = 1.0 + 2.0 * time.min(0.5) + 4.0 * (time - 0.5).max(0.0);
        assert_eq!(alias.real(LEVEL), level);
        assert_eq!((update.set, update.can_return), (time < 1.0, time < 1.0));
        let inflow = if time < 0.5 { 2.0 } else { 4.0 };
        assert_eq!(alias.set(INFLOW, inflow) == Ok, update.set);
        assert_eq!(alias.set(INFLOW, f64::NAN) == Discard, update.set);
        None
    });
    assert_eq!(importer.step(0.0, 1.0), ended(false, false, 1.0));
    assert_eq!((importer.real(LEVEL), importer.record.updates.borrow().len()), (4.0, 4));
    for (later, end) in [
        (0.0, 1.25),
        (0.1, 1.35),
        (f64::NAN, 1.25),
        (-1.0, 1.25),
        (0.75, 2.0),
        (9.0, 2.0),
    ] {
        let importer = running_with(WATCHES);
        assert_eq!(importer.step(0.0, 1.0).status, Ok);
        importer.answer(move |update| (update.time == 1.25).then_some(update.time + later));
        assert_eq!(importer.step(1.0, 1.0), ended(false, end < 2.0, end), "{later}");
        assert_eq!(importer.real(LEVEL), 1.0 + 2.0 * end);
    }
    let importer = running_with(Handles {
        early_return: false,
        ..WATCHES
    });
    importer.answer(|update| Some(update.time));
    assert_eq!(importer.step(0.0, 1.0), ended(false, false, 1.0));
}

#[test]
fn a_variable_that_cannot_be_updated_is_announced_with_a_warning_and_refused() {
    let importer = running_with(Handles::updates(&[GAIN, LEVEL, GAIN]));
    let warning = "fmi3InstantiateCoSimulation: gain can't be set or read in intermediate update";
    let is_it = |message: &&Message| message.status == 1 && message.text.contains(warning);
    assert_eq!(importer.record.messages.borrow().iter().filter(is_it).count(), 1);
    let alias = importer.alias();
    importer.answer(move |update| {
        assert!(!update.set, "no input is announced");
        assert!(alias.reals(&[LEVEL], 1).is_ok() && alias.reals(&[GAIN], 1).is_err());
        assert_eq!(alias.set(GAIN, 2.0), Error);
        None
    });
    assert_eq!(importer.step(0.0, 1.0).status, Ok);
    importer.assert_logged("or does not support this mode");
}

#[test]
fn an_update_can_use_announced_variables_only_and_call_nothing_else() {
    let importer = running_with(WATCHES);
    let i = importer.alias();
    importer.answer(move |_| {
        let mut state = null_mut();
        assert_eq!(i.derivatives(&[LEVEL], 1).map(|values| values.len()), Result::Ok(1));
        for refused in [
            i.reals(&[DEPTH], DEPTHS).err(),
            i.reals(&[START], 1).err(),
            Some(i.set(BRIM, 1.0)),
            i.derivatives(&[FULL], 1).err(),
            i.number(FULL).err(),
            Some(i.store(&mut state)),
            Some(i.free(&mut state)),
            Some(i.reset()),
            Some(i.terminate()),
            Some(i.log(false, &[])),
            Some(i.step(0.0, 1.0).status),
            Some(i.enter_event_mode()),
        ] {
            assert_eq!(refused, Some(Error));
        }
        // SAFETY: no effect, because a step is in progress.
        unsafe { fmi3FreeInstance::<Tank>(i.c) };
        None
    });
    assert_eq!(importer.step(0.0, 1.0), ended(false, false, 1.0));
    importer.assert_logged("not allowed while the instance is in intermediate update mode");
    assert_eq!((importer.real(LEVEL), importer.set(BRIM, 9.0)), (3.0, Ok));
}

#[test]
fn unsupported_functions_are_refused() {
    let importer = running(Three);
    let (c, mut number, mut count, mut flags) = (importer.c, 0.0, 0, [0; 2]);
    let [flag, other] = flags.each_mut().map(std::ptr::from_mut);
    let (number, count, null) = (&raw mut number, &raw mut count, null_mut());
    // SAFETY: an instance and places for values.
    let refused: [Status; 18] = unsafe {
        [
            fmi3GetDirectionalDerivative::<Tank>(c, &1, 1, &1, 1, &1.0, 1, number, 1),
            fmi3GetAdjointDerivative::<Tank>(c, &1, 1, &1, 1, &1.0, 1, number, 1),
            fmi3GetNumberOfVariableDependencies::<Tank>(c, 1, count),
            fmi3GetVariableDependencies::<Tank>(c, 1, null, null_mut(), null, null_mut(), 1),
            fmi3EnterConfigurationMode::<Tank>(c),
            fmi3ExitConfigurationMode::<Tank>(c),
            fmi3EvaluateDiscreteStates::<Tank>(c),
            fmi3EnterContinuousTimeMode::<Tank>(c),
            fmi3CompletedIntegratorStep::<Tank>(c, 1, flag, other),
            fmi3SetTime::<Tank>(c, 1.0),
            fmi3SetContinuousStates::<Tank>(c, &1.0, 1),
            fmi3GetContinuousStateDerivatives::<Tank>(c, number, 1),
            fmi3GetEventIndicators::<Tank>(c, number, 1),
            fmi3GetContinuousStates::<Tank>(c, number, 1),
            fmi3GetNominalsOfContinuousStates::<Tank>(c, number, 1),
            fmi3GetNumberOfEventIndicators::<Tank>(c, count),
            fmi3GetNumberOfContinuousStates::<Tank>(c, count),
            fmi3ActivateModelPartition::<Tank>(c, 1, 0.0),
        ]
    };
    assert_eq!(refused, [Error; 18]);
    let messages = importer.record.messages.borrow();
    let reasons = messages
        .iter()
        .filter(|message| message.text.contains("not supported: "));
    assert_eq!(reasons.count(), refused.len());
    assert_eq!(importer.step(0.0, 1.0).status, Ok, "and nothing has changed");
}
