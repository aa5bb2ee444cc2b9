//! What FMI 2.0 alone has, on a toy unit.

#![allow(unsafe_code, reason = "C functions of the standard")]

use std::ffi::{CStr, c_int};
use std::ptr::{null, null_mut};

use pushbelt_fmi::Version::Two;
use pushbelt_fmi::fmi2::functions::*;
use pushbelt_fmi::fmi2::query::{free_text, query};
use pushbelt_fmi::log::Status::{self, Discard, Error, Ok, Warning};
use pushbelt_fmi::unit::Message;

use crate::importer::{experiment, token};
use crate::run::running;
use crate::tank::*;

#[test]
fn an_instance_without_a_logger_fails_silently() {
    assert_eq!(NAMES.len(), 44);
    // SAFETY: constant strings, an instance, and a value.
    unsafe {
        assert_eq!(CStr::from_ptr(fmi2GetVersion::<Tank>()), c"2.0");
        assert_eq!(CStr::from_ptr(fmi2GetTypesPlatform::<Tank>()), c"default");
        let c =
            fmi2Instantiate::<Tank>(c"mute".as_ptr(), 1, token::<Tank>(Two).as_ptr(), null(), null(), 0, 1);
        assert!(!c.is_null());
        assert_eq!(fmi2DoStep::<Tank>(c, 0.0, 1.0, 1), Error);
        assert_eq!(fmi2SetReal::<Tank>(c, &INFLOW, 1, &f64::NAN), Discard);
        fmi2FreeInstance::<Tank>(c);
    }
}

#[test]
fn null_and_misaligned_pointers_are_errors() {
    let importer = running(Two);
    let (c, numbers) = (importer.c, [1.0; 2]);
    // SAFETY: null and a misaligned address are what the functions are to handle.
    unsafe {
        fmi2FreeInstance::<Tank>(null_mut());
        assert_eq!(fmi2DoStep::<Tank>(null_mut(), 0.0, 1.0, 1), Error);
        assert_eq!(fmi2FreeFMUstate::<Tank>(null_mut(), null_mut()), Error);
        let refused = [
            fmi2GetReal::<Tank>(c, null(), 1, &mut 0.0),
            fmi2GetReal::<Tank>(c, &LEVEL, 1, null_mut()),
            fmi2GetReal::<Tank>(c, &LEVEL, usize::MAX, &mut 0.0),
            fmi2SetReal::<Tank>(c, &INFLOW, 1, null()),
            fmi2SetReal::<Tank>(c, &INFLOW, 1, (&raw const numbers).byte_add(1).cast()),
            fmi2GetString::<Tank>(c, null(), 1, null_mut()),
            fmi2SetRealInputDerivatives::<Tank>(c, &INFLOW, 1, null(), &1.0),
            fmi2GetRealOutputDerivatives::<Tank>(c, &LEVEL, 1, &1, null_mut()),
            fmi2GetFMUstate::<Tank>(c, null_mut()),
            fmi2SetFMUstate::<Tank>(c, null_mut()),
            fmi2SerializedFMUstateSize::<Tank>(c, null_mut(), &mut 0),
            fmi2SerializeFMUstate::<Tank>(c, null_mut(), null_mut(), 0),
            fmi2DeSerializeFMUstate::<Tank>(c, null(), 9, &mut null_mut()),
            fmi2DeSerializeFMUstate::<Tank>(c, c"x".as_ptr(), 1, null_mut()),
            fmi2GetStatus::<Tank>(c, 0, null_mut()),
            fmi2GetRealStatus::<Tank>(c, 2, null_mut()),
            fmi2GetBooleanStatus::<Tank>(c, 3, null_mut()),
            fmi2SetDebugLogging::<Tank>(c, 1, 1, null()),
            fmi2SetDebugLogging::<Tank>(c, 1, 1, &null()),
        ];
        assert_eq!(refused, [Error; 19]);
        assert_eq!(importer.record.messages.borrow().len(), refused.len(), "each is logged");
        for done in [
            fmi2GetReal::<Tank>(c, null(), 0, null_mut()),
            fmi2SetReal::<Tank>(c, null(), 0, null()),
            fmi2GetString::<Tank>(c, null(), 0, null_mut()),
            fmi2SetRealInputDerivatives::<Tank>(c, null(), 0, null(), null()),
            fmi2FreeFMUstate::<Tank>(c, null_mut()),
            fmi2FreeFMUstate::<Tank>(c, &mut null_mut()),
        ] {
            assert_eq!(done, Ok, "nothing of nothing");
        }
    }
    assert_eq!(importer.step(0.0, 1.0).status, Ok, "and nothing has changed");
}

#[test]
fn status_calls_return_how_the_last_step_ended() {
    let importer = running(Two);
    let (c, mut time, mut number, mut text) = (importer.c, f64::NAN, -1, null());
    // SAFETY: an instance, and places for values.
    unsafe {
        for (brim, status) in [(1e9, Ok), (2.0, Discard)] {
            assert_eq!(importer.set(BRIM, brim), Ok);
            assert_eq!(importer.step([1.0, 0.0][usize::from(status == Ok)], 1.0).status, status);
            assert_eq!(fmi2GetStatus::<Tank>(c, 0, &raw mut number), Ok);
            assert_eq!(fmi2GetRealStatus::<Tank>(c, 2, &raw mut time), Ok);
            assert_eq!((number, time), (status as c_int, 1.0));
            assert_eq!(fmi2GetBooleanStatus::<Tank>(c, 3, &raw mut number), Ok);
            assert_eq!(number, 0);
        }
        for discarded in [
            fmi2GetStatus::<Tank>(c, 2, &raw mut number),
            fmi2GetRealStatus::<Tank>(c, 0, &raw mut time),
            fmi2GetBooleanStatus::<Tank>(c, 0, &raw mut number),
            fmi2GetIntegerStatus::<Tank>(c, 0, &raw mut number),
            fmi2GetStringStatus::<Tank>(c, 1, &raw mut text),
        ] {
            assert_eq!(discarded, Discard);
        }
        importer.assert_logged("there is no status of the kind 1");
        for kind in [-1, 4] {
            assert_eq!(fmi2GetStatus::<Tank>(c, kind, &raw mut number), Error);
        }
        assert_eq!(fmi2CancelStep::<Tank>(c), Error);
        assert_eq!(importer.terminate(), Ok);
        assert_eq!(fmi2GetRealStatus::<Tank>(c, 2, &raw mut time), Ok);
        let instantiated = Importer::new(Two);
        assert_eq!(fmi2GetStatus::<Tank>(instantiated.c, 0, &raw mut number), Error);
    }
}

#[test]
fn a_query_returns_a_text_or_null() {
    let importer = Importer::new(Two);
    let ask = |found: Result<&str, &str>, warning: bool| {
        let mut text = c"before".as_ptr().cast_mut();
        // SAFETY: an instance, and a place for a pointer; the text is copied and freed.
        unsafe {
            let status = query::<Tank>(importer.c, "ask", (null(), 0), &raw mut text, |_, _, _, messages| {
                messages.push(Message {
                    warning,
                    text: "a hint".into(),
                });
                found.map(str::to_owned).map_err(str::to_owned)
            });
            let found = (!text.is_null()).then(|| CStr::from_ptr(text).to_owned());
            free_text(text);
            (status, found)
        }
    };
    assert_eq!(ask(Result::Ok("early"), false), (Error, None), "before the start");
    assert_eq!(importer.enter(experiment(0.0, None)), Ok);
    assert_eq!(ask(Result::Ok("a\0b"), false), (Ok, Some(c"a b".to_owned())));
    assert_eq!(ask(Result::Ok("text"), true), (Warning, Some(c"text".to_owned())));
    importer.assert_logged("a hint");
    importer.assert(ask(Err("no such thing"), true), (Error, None), "ask: no such thing");
    // SAFETY: an instance, and null.
    let refused = unsafe {
        query::<Tank>(importer.c, "ask", (null(), 0), null_mut(), |_, _, _, _| {
            Result::Ok(String::new())
        })
    };
    importer.assert(refused, Error, "the pointer for the result is null");
    assert_eq!(importer.exit(), Ok, "and the run goes on");
    assert_eq!(importer.reset(), Ok);
    assert_eq!(importer.set(GAIN, 0.5), Ok);
    assert_eq!(importer.enter(experiment(0.0, None)), Ok);
    for why in ["gain = 0.5 does not fit", "there is no model after a failed start"] {
        importer.assert(ask(Result::Ok("none"), false), (Error, None), why);
    }
}

/// Model exchange: the functions are there, each logs its refusal, and the run goes on.
#[test]
fn functions_of_model_exchange_are_refused() {
    let importer = running(Two);
    let (c, mut number, mut flag) = (importer.c, 0.0, 0);
    let (number, flag) = (&raw mut number, &raw mut flag);
    // SAFETY: an instance, places for values, and null for the information on events.
    let refused: [Status; 10] = unsafe {
        [
            fmi2EnterEventMode::<Tank>(c),
            fmi2NewDiscreteStates::<Tank>(c, null_mut()),
            fmi2EnterContinuousTimeMode::<Tank>(c),
            fmi2CompletedIntegratorStep::<Tank>(c, 1, flag, flag),
            fmi2SetTime::<Tank>(c, 1.0),
            fmi2SetContinuousStates::<Tank>(c, number, 1),
            fmi2GetDerivatives::<Tank>(c, number, 1),
            fmi2GetEventIndicators::<Tank>(c, number, 1),
            fmi2GetContinuousStates::<Tank>(c, number, 1),
            fmi2GetNominalsOfContinuousStates::<Tank>(c, number, 1),
        ]
    };
    let why = "fmi2GetNominalsOfContinuousStates: not supported: this FMU is for co-simulation only";
    importer.assert(refused, [Error; 10], why);
    assert_eq!(importer.record.messages.borrow().len(), refused.len());
    assert_eq!(importer.step(0.0, 1.0).status, Ok, "and nothing has changed");
}

#[test]
fn there_are_no_strings_and_no_directional_derivatives() {
    let importer = running(Two);
    let (c, mut value, mut text) = (importer.c, 0.0, null());
    // SAFETY: an instance, and places for values.
    let refused = unsafe {
        [
            fmi2GetString::<Tank>(c, &START, 1, &raw mut text),
            fmi2SetString::<Tank>(c, &START, 1, &null()),
            fmi2GetDirectionalDerivative::<Tank>(c, &LEVEL, 1, &INFLOW, 1, &1.0, &raw mut value),
        ]
    };
    importer.assert(refused, [Error; 3], "fmi2GetDirectionalDerivative: not supported: ");
}
