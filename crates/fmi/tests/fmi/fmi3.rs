//! The C functions of FMI 3.0 on a toy unit.

#![allow(unsafe_code, non_snake_case, reason = "C functions of the standard")]

use std::cell::RefCell;
use std::ffi::{CStr, CString};
use std::ptr::{null, null_mut};

use pushbelt_fmi::log::Status::{Discard, Error, Ok};

use crate::tank::*;

pushbelt_fmi::export_fmi3!(crate::tank::Tank);

/// The master's callback in an intermediate update. From the time and whether inputs may be set, it returns the time of an early return.
type Answer = Box<dyn FnMut(f64, bool) -> Option<f64>>;

#[derive(Default)]
struct Record {
    messages: RefCell<Vec<String>>,
    answer: RefCell<Option<Answer>>,
}

unsafe extern "C" fn log_message(environment: Environment, _: c_int, _: Text, message: Text) {
    // SAFETY: the environment is the `Record` of the importer below, and the message ends with a zero.
    unsafe {
        let message = CStr::from_ptr(message).to_str().expect("UTF-8").to_owned();
        (*environment.cast::<Record>()).messages.borrow_mut().push(message);
    }
}

unsafe extern "C" fn update(
    environment: Environment,
    time: f64,
    set: Boolean,
    get: Boolean,
    accepted: Boolean,
    can_return: Boolean,
    requested: *mut Boolean,
    until: *mut f64,
) {
    assert_eq!((get, accepted), (1, 1));
    // SAFETY: the environment is the `Record` of the importer below, the places are those of the caller.
    unsafe {
        let record = &*environment.cast::<Record>();
        let Some(answer) = &mut *record.answer.borrow_mut() else {
            return;
        };
        if let Some(end) = answer(time, set != 0) {
            requested.write(1);
            until.write(end);
            assert!(can_return <= 1);
        }
    }
}

/// Capabilities of a master.
#[derive(Clone, Copy, Default)]
struct Handles {
    events: bool,
    early_return: bool,
    update: bool,
}

/// How a step ended.
#[derive(Debug, PartialEq)]
struct Ended {
    status: Status,
    event: Boolean,
    early: Boolean,
    time: f64,
}

const fn ended(event: Boolean, early: Boolean, time: f64) -> Ended {
    let status = Ok;
    Ended {
        status,
        event,
        early,
        time,
    }
}

struct Importer {
    c: Instance,
    record: Box<Record>,
}

impl Importer {
    fn with(name: Text, token: Text, required: &[u32], handles: Handles) -> Self {
        let record = Box::new(Record::default());
        let environment = std::ptr::from_ref(&*record).cast_mut().cast();
        let update: Option<IntermediateUpdate> = if handles.update { Some(update) } else { None };
        let (events, early) = (handles.events.into(), handles.early_return.into());
        let (count, required) = (required.len(), required.as_ptr());
        // SAFETY: all pointers are valid or null.
        let c = unsafe {
            fmi3InstantiateCoSimulation(
                name,
                token,
                null(),
                0,
                1,
                events,
                early,
                required,
                count,
                environment,
                Some(log_message),
                update,
            )
        };
        Self { c, record }
    }

    fn new(handles: Handles) -> Self {
        let importer = Self::with(c"tank".as_ptr(), token().as_ptr(), &[INFLOW, LEVEL], handles);
        assert!(!importer.c.is_null(), "{}", importer.last());
        importer
    }

    fn running(handles: Handles) -> Self {
        let importer = Self::new(handles);
        // SAFETY: an instance.
        unsafe {
            assert_eq!(fmi3EnterInitializationMode(importer.c, 0, 0.0, 0.0, 0, 0.0), Ok);
            assert_eq!(fmi3ExitInitializationMode(importer.c), Ok);
            if handles.events {
                assert_eq!(fmi3EnterStepMode(importer.c), Ok);
            }
        }
        importer
    }

    fn step(&self, from: f64, size: f64) -> Ended {
        let (mut event, mut terminate, mut early, mut time) = (9, 9, 9, f64::NAN);
        let [a, b, c] = [&mut event, &mut terminate, &mut early].map(std::ptr::from_mut);
        // SAFETY: an instance, and a place for each result.
        let status = unsafe { fmi3DoStep(self.c, from, size, 1, a, b, c, &raw mut time) };
        assert_eq!(terminate, 0);
        Ended {
            status,
            event,
            early,
            time,
        }
    }

    fn set(&self, reference: u32, value: f64) -> Status {
        set(self.c, reference, value)
    }

    fn real(&self, reference: u32) -> f64 {
        get(self.c, reference).expect("a value")
    }

    fn answer(&self, answer: impl FnMut(f64, bool) -> Option<f64> + 'static) {
        *self.record.answer.borrow_mut() = Some(Box::new(answer));
    }

    fn last(&self) -> String {
        self.record.messages.borrow().last().cloned().unwrap_or_default()
    }

    fn assert_logged(&self, part: &str) {
        assert!(self.last().contains(part), "{}", self.last());
    }
}

impl Drop for Importer {
    fn drop(&mut self) {
        // SAFETY: the instance is not used any more.
        unsafe { fmi3FreeInstance(self.c) };
    }
}

fn token() -> CString {
    CString::new(pushbelt_fmi::fmi3::instantiation_token::<Tank>()).expect("no zero inside")
}

fn set(c: Instance, reference: u32, value: f64) -> Status {
    // SAFETY: an instance, one reference and one value.
    unsafe { fmi3SetFloat64(c, &raw const reference, 1, &raw const value, 1) }
}

fn get(c: Instance, reference: u32) -> Option<f64> {
    let mut value = f64::NAN;
    // SAFETY: an instance, one reference and one value.
    let status = unsafe { fmi3GetFloat64(c, &raw const reference, 1, &raw mut value, 1) };
    (status == Ok).then_some(value)
}

const TIME: u32 = 0;
const WATCHES: Handles = Handles {
    events: false,
    early_return: true,
    update: true,
};
const EVENTS: Handles = Handles {
    events: true,
    early_return: true,
    update: false,
};

#[test]
fn an_instance_needs_a_name_the_right_token_and_intermediate_variables() {
    let (name, right) = (c"tank".as_ptr(), token());
    for (name, token, required, why) in [
        (null(), right.as_ptr(), LEVEL, "the instance name is missing"),
        (c" ".as_ptr(), right.as_ptr(), LEVEL, "the instance name is missing"),
        (name, null(), LEVEL, "the instantiation token is missing"),
        (
            name,
            c"{0}".as_ptr(),
            LEVEL,
            "the instantiation token {0} is not that of this binary",
        ),
        (name, right.as_ptr(), NONE, "no variable has the value reference 99"),
    ] {
        let importer = Importer::with(name, token, &[required], WATCHES);
        assert!(importer.c.is_null());
        importer.assert_logged(why);
        importer.assert_logged("fmi3InstantiateCoSimulation: ");
    }
    // SAFETY: a constant string; other kinds of instance need no valid arguments.
    unsafe {
        assert_eq!(CStr::from_ptr(fmi3GetVersion()), c"3.0");
        assert!(fmi3InstantiateModelExchange(name, right.as_ptr(), null(), 0, 0, null_mut(), None).is_null());
        let importer = Importer::new(WATCHES);
        let environment = std::ptr::from_ref(&*importer.record).cast_mut().cast();
        let (none, log_message): (*const c_void, LogMessage) = (null(), log_message);
        let other = fmi3InstantiateScheduledExecution(
            name,
            right.as_ptr(),
            null(),
            0,
            0,
            environment,
            Some(log_message),
            none,
            none,
            none,
        );
        assert!(other.is_null());
        importer.assert_logged("fmi3InstantiateScheduledExecution: this FMU is for co-simulation only");
    }
    assert_eq!(pushbelt_fmi::fmi3::NAMES.len(), 75);
}

#[test]
fn a_run_goes_through_its_states() {
    let importer = Importer::new(Handles::default());
    let c = importer.c;
    assert_eq!(importer.real(START), 1.0, "start values can be read at once");
    assert_eq!(get(c, LEVEL), None);
    importer.assert_logged("before initialization mode");
    // SAFETY: an instance.
    unsafe {
        assert_eq!(fmi3EnterInitializationMode(c, 0, 0.0, 1.0, 1, 0.5), Error);
        assert_eq!(fmi3EnterInitializationMode(c, 1, 1e-3, 1.0, 1, 2.0), Ok);
        assert_eq!(importer.real(TIME), 1.0);
        assert_eq!(fmi3ExitInitializationMode(c), Ok);
        assert_eq!(fmi3EnterEventMode(c), Error);
        importer.assert_logged("eventModeUsed");
    }
    assert_eq!(importer.step(1.0, 1.0), ended(0, 0, 2.0));
    assert_eq!(importer.step(2.0, 1.0).status, Error);
    importer.assert_logged("after the stop time 2 s");
    assert_eq!((importer.real(TIME), importer.real(LEVEL)), (2.0, 3.0));
    // SAFETY: an instance.
    unsafe {
        assert_eq!(fmi3Terminate(c), Ok);
        assert_eq!(fmi3Reset(c), Ok);
        assert_eq!(
            fmi3DoStep(c, 0.0, 1.0, 1, null_mut(), null_mut(), null_mut(), null_mut()),
            Error
        );
    }
    importer.assert_logged("the pointer for the result is null");
}

#[test]
fn every_type_is_read_and_written() {
    let importer = Importer::new(Handles::default());
    let (c, mut number, mut choice, mut truth) = (importer.c, 0, 0, 0);
    // SAFETY: an instance, and places for values.
    unsafe {
        assert_eq!(fmi3SetInt32(c, &FLOORS, 1, &3, 1), Ok);
        assert_eq!(fmi3SetInt32(c, &SHAPE, 1, &2, 1), Error, "an enumeration has 64 bits");
        assert_eq!(fmi3SetInt64(c, &SHAPE, 1, &2, 1), Ok);
        assert_eq!(fmi3SetInt64(c, &SHAPE, 1, &(1 << 40), 1), Discard);
        importer.assert_logged("fmi3SetInt64: shape = 1099511627776 is out of range: 1 Round, 2 Square");
        assert_eq!(fmi3SetBoolean(c, &LOCKED, 1, &7, 1), Ok);
        assert_eq!(fmi3GetInt32(c, &FLOORS, 1, &raw mut number, 1), Ok);
        assert_eq!(fmi3GetInt64(c, &SHAPE, 1, &raw mut choice, 1), Ok);
        assert_eq!(fmi3GetBoolean(c, &LOCKED, 1, &raw mut truth, 1), Ok);
        assert_eq!((number, choice, truth), (3, 2, 1));
        assert_eq!(fmi3GetBoolean(c, &LOCKED, 1, &raw mut truth, 0), Error);
        importer.assert_logged("0 values for 1 variables");
        assert_eq!(fmi3GetFloat32(c, &LEVEL, 1, [0.0].as_mut_ptr(), 1), Error);
        importer.assert_logged("no 32-bit real has the value reference 5");
        assert_eq!(fmi3SetShiftDecimal(c, &LEVEL, 1, &0.0), Error);
        importer.assert_logged("no clock");
        assert_eq!(
            fmi3GetBinary(c, null(), 0, null_mut(), null_mut(), 0),
            Ok,
            "none of none"
        );
    }
}

#[test]
fn arrays_lie_between_scalars_and_the_time() {
    let importer = Importer::running(Handles::default());
    assert_eq!(importer.step(0.0, 0.5).status, Ok);
    let (c, mut values) = (importer.c, [f64::NAN; 6]);
    // SAFETY: an instance; arrays have the given lengths, or are null.
    unsafe {
        let references = [INFLOW, DEPTH, TIME, LEVEL];
        assert_eq!(fmi3GetFloat64(c, references.as_ptr(), 4, values.as_mut_ptr(), 6), Ok);
        assert_eq!(values, [2.0, 0.0, 1.0, 2.0, 0.5, 2.0]);
        assert_eq!(fmi3GetFloat64(c, references.as_ptr(), 4, values.as_mut_ptr(), 4), Error);
        importer.assert_logged("4 values for 4 variables, which have 6 values together");
        assert_eq!(fmi3GetFloat64(c, null(), 1, values.as_mut_ptr(), 1), Error);
        assert_eq!(fmi3GetFloat64(c, &LEVEL, 1, null_mut(), 1), Error);
    }
    assert_eq!(get(c, DEPTH + 1), None);
    importer.assert_logged("element of depth");
    assert_eq!(get(c, NONE), None);
    assert_eq!(importer.set(TIME, 1.0), Error);
    importer.assert_logged("time can't be set");
    assert_eq!(importer.set(GAIN, 0.5), Discard);
    importer.assert_logged("fmi3SetFloat64: gain = 0.5 does not fit");
}

#[test]
fn an_event_ends_a_step_that_may_end_early() {
    let importer = Importer::running(EVENTS);
    assert_eq!(importer.set(MARK, 2.2), Ok);
    assert_eq!(
        importer.step(0.0, 2.0),
        ended(1, 1, 0.75),
        "at the end of an internal step"
    );
    importer.assert_logged("event at 0.75 s: the level reaches 2.2");
    let mut flags = [9; 5];
    let [a, b, c, d, e] = flags.each_mut().map(std::ptr::from_mut);
    // SAFETY: an instance, and a place for each result.
    unsafe {
        assert_eq!(fmi3EnterEventMode(importer.c), Ok);
        assert_eq!(importer.step(0.75, 1.0).status, Error, "first the event");
        assert_eq!(importer.set(INFLOW, 1.0), Ok);
        assert_eq!(fmi3UpdateDiscreteStates(importer.c, a, b, c, d, e, null_mut()), Error);
        assert_eq!(fmi3UpdateDiscreteStates(importer.c, a, b, c, d, e, &mut 1.0), Ok);
        assert_eq!(flags, [0; 5]);
        assert_eq!(fmi3EnterStepMode(importer.c), Ok);
    }
    assert_eq!(importer.step(0.75, 1.25), ended(0, 0, 2.0));
    assert_eq!(importer.real(LEVEL), 3.75);
    let late = Importer::running(Handles {
        early_return: false,
        ..EVENTS
    });
    assert_eq!(late.set(MARK, 2.2), Ok);
    assert_eq!(late.step(0.0, 2.0), ended(1, 0, 2.0), "otherwise at its end");
    let deaf = Importer::running(Handles::default());
    assert_eq!(deaf.set(MARK, 2.2), Ok);
    assert_eq!(deaf.step(0.0, 2.0), ended(0, 0, 2.0), "or never");
}

/// Intermediate updates do not change the results.
#[test]
fn intermediate_updates_do_not_change_the_bits() {
    let all = [false, true];
    let masters = all.iter().flat_map(|&events| {
        all.map(|update| Handles {
            events,
            early_return: true,
            update,
        })
    });
    let levels: Vec<u64> = masters
        .map(|handles| {
            let importer = Importer::running(handles);
            for k in 0..10 {
                assert_eq!(importer.set(INFLOW, 0.1 * f64::from(k)), Ok);
                assert_eq!(importer.step(0.7 * f64::from(k), 0.7).status, Ok);
            }
            importer.real(LEVEL).to_bits()
        })
        .collect();
    assert_eq!(levels, vec![levels[0]; 4]);
}

#[test]
fn a_master_reads_sets_and_returns_within_a_step() {
    let importer = Importer::running(WATCHES);
    let c = importer.c;
    importer.answer(move |time, inputs_may_be_set| {
        assert_eq!(get(c, TIME), Some(time));
        assert_eq!(
            get(c, LEVEL),
            Some(1.0 + 2.0 * time.min(0.5) + 4.0 * (time - 0.5).max(0.0))
        );
        assert_eq!(
            inputs_may_be_set,
            time < 1.0,
            "inputs may not be set at the end of the step"
        );
        assert_eq!(
            set(c, INFLOW, if time < 0.5 { 2.0 } else { 4.0 }) == Ok,
            inputs_may_be_set
        );
        assert_eq!(set(c, INFLOW, f64::NAN) == Discard, inputs_may_be_set);
        None
    });
    assert_eq!(importer.step(0.0, 1.0), ended(0, 0, 1.0));
    assert_eq!(importer.real(LEVEL), 4.0);
    for (later, end) in [(0.0, 1.25), (0.1, 1.35), (f64::NAN, 1.25), (-1.0, 1.25), (9.0, 2.0)] {
        let importer = Importer::running(WATCHES);
        assert_eq!(importer.step(0.0, 1.0).status, Ok);
        importer.answer(move |time, _| (time == 1.25).then_some(time + later));
        assert_eq!(importer.step(1.0, 1.0), ended(0, (end < 2.0).into(), end), "{later}");
    }
    let importer = Importer::running(Handles {
        early_return: false,
        ..WATCHES
    });
    importer.answer(|time, _| Some(time));
    assert_eq!(importer.step(0.0, 1.0), ended(0, 0, 1.0), "not without early return");
}

#[test]
fn a_variable_that_cannot_be_updated_is_announced_with_a_warning_and_refused() {
    let importer = Importer::with(c"tank".as_ptr(), token().as_ptr(), &[GAIN, LEVEL], WATCHES);
    let c = importer.c;
    assert!(!c.is_null(), "{}", importer.last());
    importer.assert_logged("fmi3InstantiateCoSimulation: gain can't be set or read in intermediate update mode");
    // SAFETY: an instance.
    unsafe {
        assert_eq!(fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0), Ok);
        assert_eq!(fmi3ExitInitializationMode(c), Ok);
    }
    importer.answer(move |_, inputs_may_be_set| {
        assert!(!inputs_may_be_set, "no input is announced");
        assert!(get(c, LEVEL).is_some() && get(c, GAIN).is_none());
        assert_eq!(set(c, GAIN, 2.0), Error);
        None
    });
    assert_eq!(importer.step(0.0, 1.0).status, Ok);
    importer.assert_logged("or does not support this mode");
}

#[test]
fn an_update_can_use_announced_variables_only_and_call_nothing_else() {
    let importer = Importer::running(WATCHES);
    let c = importer.c;
    importer.answer(move |_, _| {
        let (mut state, mut value, mut flags) = (null_mut(), 0.0, [0; 3]);
        assert_eq!((get(c, DEPTH), get(c, START), set(c, BRIM, 1.0)), (None, None, Error));
        // SAFETY: the instance that calls back, and places for values.
        unsafe {
            assert_eq!(fmi3GetOutputDerivatives(c, &LEVEL, 1, &1, &raw mut value, 1), Ok);
            assert_eq!(fmi3GetOutputDerivatives(c, &FULL, 1, &1, &raw mut value, 1), Error);
            assert_eq!(fmi3GetBoolean(c, &FULL, 1, flags.as_mut_ptr(), 1), Error);
            assert_eq!(fmi3GetFMUState(c, &raw mut state), Error);
            assert_eq!(fmi3FreeFMUState(c, &raw mut state), Error);
            assert_eq!(fmi3Reset(c), Error);
            assert_eq!(fmi3Terminate(c), Error);
            assert_eq!(fmi3EnterEventMode(c), Error);
            assert_eq!(fmi3SetDebugLogging(c, 0, 0, null()), Error);
            // No effect, because a step is in progress.
            fmi3FreeInstance(c);
            let [a, b, d] = flags.each_mut().map(std::ptr::from_mut);
            assert_eq!(fmi3DoStep(c, 0.0, 1.0, 1, a, b, d, &raw mut value), Error);
        }
        None
    });
    assert_eq!(importer.step(0.0, 1.0), ended(0, 0, 1.0));
    importer.assert_logged("not allowed while the instance is in intermediate update mode");
    assert_eq!(
        (importer.real(LEVEL), importer.set(BRIM, 9.0)),
        (3.0, Ok),
        "afterwards as before"
    );
}

#[test]
fn after_a_failed_step_all_is_as_before() {
    for handles in [Handles::default(), WATCHES, EVENTS] {
        let importer = Importer::running(handles);
        assert_eq!(importer.set(BRIM, 2.0), Ok);
        let failed = importer.step(0.0, 1.0);
        assert_eq!(
            (failed.status, failed.event, failed.early, failed.time),
            (Discard, 0, 0, 0.0)
        );
        assert_eq!(
            (importer.real(LEVEL), importer.set(BRIM, 9.0), importer.step(0.0, 1.0)),
            (1.0, Ok, ended(0, 0, 1.0))
        );
        assert_eq!(importer.set(INFLOW, BURST), Ok);
        assert_eq!(importer.step(1.0, 1.0).status, Error);
        importer.assert_logged("fmi3DoStep: internal error, please report: the tank burst");
    }
}

#[test]
fn a_stored_state_continues_with_the_same_bits() {
    let importer = Importer::running(EVENTS);
    assert_eq!(importer.step(0.0, 0.7).status, Ok);
    let (mut state, mut size) = (null_mut(), 0);
    let go_on = |importer: &Importer| {
        assert_eq!(importer.step(0.7, 0.9).status, Ok, "{}", importer.last());
        importer.real(LEVEL).to_bits()
    };
    // SAFETY: instances and their states.
    unsafe {
        assert_eq!(fmi3EnterEventMode(importer.c), Ok);
        assert_eq!(fmi3GetFMUState(importer.c, &raw mut state), Ok);
        assert_eq!(fmi3SerializedFMUStateSize(importer.c, state, &raw mut size), Ok);
        let mut bytes = vec![0; size];
        assert_eq!(fmi3SerializeFMUState(importer.c, state, bytes.as_mut_ptr(), size), Ok);
        assert_eq!(fmi3EnterStepMode(importer.c), Ok);
        let expected = go_on(&importer);
        assert_eq!(fmi3SetFMUState(importer.c, state), Ok);
        assert_eq!(importer.step(0.7, 0.9).status, Error, "it was stored in event mode");
        assert_eq!(fmi3EnterStepMode(importer.c), Ok);
        assert_eq!(go_on(&importer), expected);
        assert_eq!(fmi3FreeFMUState(importer.c, &raw mut state), Ok);
        // A master without event mode continues in step mode.
        let other = Importer::new(Handles::default());
        assert_eq!(
            fmi3DeserializeFMUState(other.c, bytes.as_ptr(), size, &raw mut state),
            Ok
        );
        assert_eq!(fmi3SetFMUState(other.c, state), Ok);
        assert_eq!(go_on(&other), expected);
        assert_eq!(fmi3FreeFMUState(other.c, &raw mut state), Ok);
    }
}

#[test]
fn unsupported_functions_are_refused() {
    let importer = Importer::running(Handles::default());
    let (c, mut number, mut count, mut flags) = (importer.c, 0.0, 0, [0; 2]);
    let [flag, other] = flags.each_mut().map(std::ptr::from_mut);
    let (number, count) = (&raw mut number, &raw mut count);
    // SAFETY: an instance and places for values.
    let refused: [(Status, &str); 18] = unsafe {
        let exchange = "this FMU is for co-simulation only";
        let none = "no output depends directly on an input";
        [
            (fmi3GetDirectionalDerivative(c, &1, 1, &1, 1, &1.0, 1, number, 1), none),
            (fmi3GetAdjointDerivative(c, &1, 1, &1, 1, &1.0, 1, number, 1), none),
            (
                fmi3GetNumberOfVariableDependencies(c, 1, count),
                "providesPerElementDependencies",
            ),
            (
                fmi3GetVariableDependencies(c, 1, null_mut(), null_mut(), null_mut(), null_mut(), 1),
                "providesPerElementDependencies",
            ),
            (fmi3EnterConfigurationMode(c), "structural"),
            (fmi3ExitConfigurationMode(c), "structural"),
            (fmi3EvaluateDiscreteStates(c), "discrete states"),
            (fmi3EnterContinuousTimeMode(c), exchange),
            (fmi3CompletedIntegratorStep(c, 1, flag, other), exchange),
            (fmi3SetTime(c, 1.0), exchange),
            (fmi3SetContinuousStates(c, &1.0, 1), exchange),
            (fmi3GetContinuousStateDerivatives(c, number, 1), exchange),
            (fmi3GetEventIndicators(c, number, 1), exchange),
            (fmi3GetContinuousStates(c, number, 1), exchange),
            (fmi3GetNominalsOfContinuousStates(c, number, 1), exchange),
            (fmi3GetNumberOfEventIndicators(c, count), exchange),
            (fmi3GetNumberOfContinuousStates(c, count), exchange),
            (fmi3ActivateModelPartition(c, 1, 0.0), exchange),
        ]
    };
    let messages = importer.record.messages.borrow();
    let messages: Vec<_> = messages
        .iter()
        .filter(|text| text.contains("not supported: "))
        .collect();
    assert_eq!(messages.len(), refused.len());
    for ((status, why), message) in refused.iter().zip(messages) {
        assert!(*status == Error && message.contains(why), "{message}");
    }
    assert_eq!(importer.step(0.0, 1.0).status, Ok, "and nothing has changed");
}

#[test]
fn an_instance_without_logging_sends_errors_only() {
    let importer = Importer::running(Handles::default());
    // SAFETY: an instance, strings that end with a zero.
    unsafe {
        assert_eq!(fmi3SetDebugLogging(importer.c, 0, 0, null()), Ok);
        importer.record.messages.borrow_mut().clear();
        assert_eq!(importer.set(GAIN, 99.0), Discard);
        assert!(importer.record.messages.borrow().is_empty());
        assert_eq!(importer.step(9.0, 1.0).status, Error);
        importer.assert_logged("fmi3DoStep: the step starts at 9 s");
        assert_eq!(importer.record.messages.borrow().len(), 1);
        assert_eq!(fmi3SetDebugLogging(importer.c, 1, 1, &c"logAll".as_ptr()), Ok);
        assert_eq!(fmi3SetDebugLogging(importer.c, 1, 1, &c"noise #1".as_ptr()), Error);
    }
    importer.assert_logged("\"noise ##1\"");
}

#[cfg(target_arch = "x86_64")]
#[test]
fn every_floating_point_environment_gives_the_same_bits_and_callbacks_run_in_it() {
    use crate::environment::{DEFAULT, HOSTS, present, within};
    use std::rc::Rc;

    let run = || {
        let seen = Rc::new(RefCell::new(Vec::new()));
        let importer = Importer::running(WATCHES);
        let (c, record) = (importer.c, Rc::clone(&seen));
        importer.answer(move |_, _| {
            let before = present();
            // A call within the callback returns to the host's environment too.
            let level = get(c, LEVEL).expect("a value");
            record.borrow_mut().push((level.to_bits(), before, present()));
            None
        });
        assert_eq!(importer.set(INFLOW, 0.1), Ok);
        assert_eq!(importer.set(GAIN, 1.0 / 3.0), Ok);
        assert_eq!(importer.step(0.0, 0.7).status, Ok);
        let level = importer.real(LEVEL).to_bits();
        drop(importer);
        (level, Rc::try_unwrap(seen).expect("the importer is gone").into_inner())
    };
    let (expected, updates) = within(DEFAULT, run);
    assert_eq!(updates.len(), 3);
    for host in HOSTS {
        let (bits, seen) = within(host, run);
        assert_eq!(bits, expected, "{host:?}");
        for (of_default, of_host) in updates.iter().zip(seen) {
            assert_eq!(of_host, (of_default.0, host, host));
        }
    }
}
