//! The C functions of FMI 2.0 on a toy unit.

#![allow(unsafe_code, non_snake_case, reason = "C functions of the standard")]

use std::cell::RefCell;
use std::ffi::{CStr, CString};
use std::ptr::{null, null_mut};

use pushbelt_fmi::fmi2::Logger;
use pushbelt_fmi::log::Status::{Discard, Error, Ok};

use crate::tank::*;

pushbelt_fmi::export_fmi2!(crate::tank::Tank);

/// Messages that the unit logged: status and text.
#[derive(Default)]
struct Record(RefCell<Vec<(c_int, String)>>);

/// The standard's logger is variadic. This one takes the one argument that belongs to "%s"; on the platforms of the
/// tests both are called the same way.
unsafe extern "C" fn log_message(
    environment: *mut std::ffi::c_void,
    _: *const c_char,
    status: c_int,
    _: *const c_char,
    format: *const c_char,
    argument: *const c_char,
) {
    // SAFETY: `environment` is the `Record` of the importer below, and the strings end with a zero.
    unsafe {
        assert_eq!(CStr::from_ptr(format), c"%s");
        let text = CStr::from_ptr(argument).to_str().expect("UTF-8").to_owned();
        (*environment.cast::<Record>()).0.borrow_mut().push((status, text));
    }
}

/// An instance and its messages.
struct Importer {
    c: Component,
    record: Box<Record>,
}

impl Importer {
    fn with(name: *const c_char, kind: c_int, guid: *const c_char, resources: *const c_char) -> Self {
        let record = Box::new(Record::default());
        let functions = CallbackFunctions {
            // SAFETY: see `log_message`.
            logger: Some(unsafe { std::mem::transmute::<*const (), Logger>(log_message as *const ()) }),
            allocate_memory: None,
            free_memory: None,
            step_finished: None,
            component_environment: std::ptr::from_ref(&*record).cast_mut().cast(),
        };
        // SAFETY: all pointers are valid or null.
        let c = unsafe { fmi2Instantiate(name, kind, guid, resources, &raw const functions, 0, 0) };
        Self { c, record }
    }

    fn new() -> Self {
        let importer = Self::with(c"tank".as_ptr(), 1, guid().as_ptr(), null());
        assert!(!importer.c.is_null(), "{}", importer.last());
        importer
    }

    fn running() -> Self {
        let importer = Self::new();
        // SAFETY: an instance.
        unsafe {
            assert_eq!(fmi2SetupExperiment(importer.c, 0, 0.0, 0.0, 0, 0.0), Ok);
            assert_eq!(fmi2EnterInitializationMode(importer.c), Ok);
            assert_eq!(fmi2ExitInitializationMode(importer.c), Ok);
        }
        importer
    }

    fn set(&self, reference: u32, value: f64) -> Status {
        // SAFETY: an instance, one reference and one value.
        unsafe { fmi2SetReal(self.c, &raw const reference, 1, &raw const value) }
    }

    fn real(&self, reference: u32) -> f64 {
        let mut value = f64::NAN;
        // SAFETY: an instance, one reference and one value.
        assert_eq!(
            unsafe { fmi2GetReal(self.c, &raw const reference, 1, &raw mut value) },
            Ok
        );
        value
    }

    fn step(&self, from: f64, size: f64) -> Status {
        // SAFETY: an instance.
        unsafe { fmi2DoStep(self.c, from, size, 1) }
    }

    fn last(&self) -> String {
        self.record
            .0
            .borrow()
            .last()
            .map_or_else(String::new, |(_, text)| text.clone())
    }

    fn assert_logged(&self, part: &str) {
        assert!(self.last().contains(part), "{}", self.last());
    }
}

impl Drop for Importer {
    fn drop(&mut self) {
        // SAFETY: the instance is not used any more.
        unsafe { fmi2FreeInstance(self.c) };
    }
}

fn guid() -> CString {
    CString::new(pushbelt_fmi::guid::<Tank>()).expect("no zero inside")
}

#[test]
fn constants_are_those_of_the_standard() {
    // SAFETY: constant strings.
    unsafe {
        assert_eq!(CStr::from_ptr(fmi2GetVersion()), c"2.0");
        assert_eq!(CStr::from_ptr(fmi2GetTypesPlatform()), c"default");
    }
    assert_eq!(pushbelt_fmi::fmi2::NAMES.len(), 34);
}

#[test]
fn an_instance_needs_a_name_the_right_kind_and_guid() {
    let (name, right) = (c"tank".as_ptr(), guid());
    for (name, kind, guid, why) in [
        (null(), 1, right.as_ptr(), "the instance name is missing"),
        (c"".as_ptr(), 1, right.as_ptr(), "the instance name is missing"),
        (name, 0, right.as_ptr(), "for co-simulation only"),
        (name, 1, null(), "the GUID is missing"),
        (name, 1, c"{0}".as_ptr(), "the GUID {0} is not that of this binary"),
    ] {
        let importer = Importer::with(name, kind, guid, null());
        assert!(importer.c.is_null());
        importer.assert_logged(why);
        importer.assert_logged("fmi2Instantiate: ");
    }
}

#[test]
fn a_resource_location_that_cannot_be_searched_is_skipped() {
    let long = CString::new(format!("file:///tmp/{}", "x".repeat(5000))).expect("no zero inside");
    let importer = Importer::with(c"tank".as_ptr(), 1, guid().as_ptr(), long.as_ptr());
    assert!(!importer.c.is_null(), "{}", importer.last());
}

#[test]
fn start_values_come_from_the_resources() {
    let folder = std::env::temp_dir().join(format!("pushbelt-fmi {}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let file = folder.join(pushbelt_fmi::start_values::FILE);
    let uri = format!("file://{}", folder.to_str().expect("UTF-8").replace(' ', "%20"));
    let uri = CString::new(uri).expect("no zero inside");
    let make = |text: &str| {
        std::fs::write(&file, text).expect("a file");
        Importer::with(c"tank".as_ptr(), 1, guid().as_ptr(), uri.as_ptr())
    };
    let importer = make("# a comment\nstart = 3\nfloors=4\nlocked = true\n\nshape = 2");
    let c = importer.c;
    // SAFETY: an instance and places for values.
    unsafe {
        for _ in 0..2 {
            assert_eq!(fmi2EnterInitializationMode(c), Ok, "{}", importer.last());
            let (mut numbers, mut locked) = ([0; 2], 0);
            assert_eq!(fmi2GetInteger(c, [FLOORS, SHAPE].as_ptr(), 2, numbers.as_mut_ptr()), Ok);
            assert_eq!(fmi2GetBoolean(c, &LOCKED, 1, &raw mut locked), Ok);
            assert_eq!((importer.real(LEVEL), numbers, locked), (3.0, [4, 2], 1));
            assert_eq!(fmi2Reset(c), Ok, "and again after a reset");
        }
    }
    for (text, why) in [
        ("start", "line 1: \"start\" is not of the form name = value"),
        ("start = 1\nstart = 1", "line 2: start is set twice"),
        ("level = 1", "level is calculated"),
        ("sleep = 1", "no variable \"sleep\""),
        ("start = x", "start = \"x\" is not a number"),
        ("start = -2000", "start = -2000 is out of range: at least -1000"),
        ("floors = 1.5", "floors = \"1.5\" is not a whole number"),
        ("floors = 10", "floors = 10 is out of range: 1 to 9"),
        ("shape = 3", "shape = 3 is out of range: 1 Round, 2 Square"),
        ("locked = 1", "locked = \"1\" is not a truth value"),
    ] {
        let importer = make(text);
        assert!(importer.c.is_null(), "{text}");
        importer.assert_logged(why);
        importer.assert_logged("the start values in ");
    }
    // A copy with start values has a token of its own, and does not start without them.
    let token = guid().into_string().expect("UTF-8");
    let with = |token: &str, location: &CStr| {
        let token = CString::new(token).expect("no zero inside");
        Importer::with(c"tank".as_ptr(), 1, token.as_ptr(), location.as_ptr())
    };
    let copy = format!("{}0123-0123456789ab}}", &token[..20]);
    std::fs::write(&file, "start = 3").expect("a file");
    let path = CString::new(folder.to_str().expect("UTF-8")).expect("no zero inside");
    for location in [&*uri, &path] {
        let importer = with(&copy, location);
        assert!(!importer.c.is_null(), "{}", importer.last());
        // SAFETY: an instance.
        assert_eq!(unsafe { fmi2EnterInitializationMode(importer.c) }, Ok);
        assert_eq!(importer.real(LEVEL), 3.0);
    }
    std::fs::remove_dir_all(&folder).expect("removed");
    for (location, why) in [
        (&*uri, folder.to_str().expect("UTF-8")),
        (c"", "passed no resource location"),
        (c"http://a/b", "passed no resource location"),
    ] {
        let importer = with(&copy, location);
        assert!(importer.c.is_null(), "{location:?}");
        importer.assert_logged("this copy of the FMU has start values of its own");
        importer.assert_logged(why);
    }
    let other = with(&format!("{{0{}", &token[2..]), &uri);
    assert!(token.starts_with("{0") || other.c.is_null(), "the token of another FMU");
    let elsewhere = Importer::with(c"tank".as_ptr(), 1, guid().as_ptr(), c"http://a/b".as_ptr());
    assert!(!elsewhere.c.is_null(), "a warning only");
    elsewhere.assert_logged("is not a file: URI");
}

#[test]
fn a_run_goes_through_its_states() {
    let importer = Importer::running();
    assert_eq!((importer.step(0.0, 1.0), importer.real(LEVEL)), (Ok, 3.0));
    assert_eq!(importer.set(INFLOW, 1.0), Ok);
    assert_eq!((importer.step(1.0, 0.6), importer.real(LEVEL)), (Ok, 3.6));
    assert_eq!(importer.step(1.0, 0.6), Error);
    importer.assert_logged("fmi2DoStep: the step starts at 1 s, but the last one ended at 1.6 s");
    // SAFETY: an instance.
    unsafe {
        assert_eq!(fmi2Terminate(importer.c), Ok);
        assert_eq!(fmi2Terminate(importer.c), Error);
        importer.assert_logged("fmi2Terminate: not allowed while the instance is terminated");
        assert_eq!(fmi2Reset(importer.c), Ok);
        assert_eq!(fmi2EnterInitializationMode(importer.c), Ok);
    }
    assert_eq!(importer.real(LEVEL), 1.0);
}

#[test]
fn every_type_is_read_and_written() {
    let importer = Importer::new();
    let c = importer.c;
    let mut integers = [0; 2];
    let (mut truth, mut text) = ([0; 2], null());
    // SAFETY: an instance, and places for values.
    unsafe {
        assert_eq!(fmi2SetInteger(c, [FLOORS, SHAPE].as_ptr(), 2, [3, 2].as_ptr()), Ok);
        assert_eq!(fmi2SetInteger(c, [FLOORS, SHAPE].as_ptr(), 2, [4, 3].as_ptr()), Discard);
        importer.assert_logged("fmi2SetInteger: shape = 3 is out of range: 1 Round, 2 Square");
        assert_eq!(fmi2SetBoolean(c, &LOCKED, 1, &5), Ok);
        assert_eq!(fmi2SetBoolean(c, &FULL, 1, &1), Error);
        assert_eq!(fmi2SetString(c, &START, 1, &null()), Error);
        importer.assert_logged("no string has the value reference 1");
        assert_eq!(fmi2EnterInitializationMode(c), Ok);
        assert_eq!(
            fmi2GetInteger(c, [FLOORS, SHAPE].as_ptr(), 2, integers.as_mut_ptr()),
            Ok
        );
        assert_eq!(fmi2GetBoolean(c, [LOCKED, FULL].as_ptr(), 2, truth.as_mut_ptr()), Ok);
        assert_eq!((integers, truth), ([3, 2], [1, 0]));
        assert_eq!(fmi2GetInteger(c, &LEVEL, 1, integers.as_mut_ptr()), Error);
        importer.assert_logged("level (value reference 5) has another type");
        assert_eq!(fmi2GetString(c, &START, 1, &raw mut text), Error);
        assert_eq!(fmi2GetString(c, null(), 0, null_mut()), Ok);
    }
    assert_eq!(
        [DEPTH, DEPTH + 1, DEPTH + 2].map(|reference| importer.real(reference)),
        [0.0, 0.5, 1.0]
    );
}

#[test]
fn null_pointers_are_errors() {
    let importer = Importer::running();
    let c = importer.c;
    // SAFETY: null is what the functions are to handle.
    unsafe {
        fmi2FreeInstance(null_mut());
        assert_eq!(fmi2DoStep(null_mut(), 0.0, 1.0, 1), Error);
        assert_eq!(fmi2FreeFMUstate(null_mut(), null_mut()), Error);
        for status in [
            fmi2GetReal(c, null(), 1, &raw mut *[0.0].as_mut_ptr()),
            fmi2GetReal(c, &LEVEL, 1, null_mut()),
            fmi2GetReal(c, null(), usize::MAX, null_mut()),
            fmi2SetReal(c, &INFLOW, 1, null()),
            fmi2GetInteger(c, null(), 1, null_mut()),
            fmi2SetInteger(c, null(), 1, null()),
            fmi2GetBoolean(c, null(), 1, null_mut()),
            fmi2SetBoolean(c, null(), 1, null()),
            fmi2GetString(c, null(), 1, null_mut()),
            fmi2SetRealInputDerivatives(c, &INFLOW, 1, null(), &1.0),
            fmi2GetRealOutputDerivatives(c, &LEVEL, 1, &1, null_mut()),
            fmi2GetFMUstate(c, null_mut()),
            fmi2SetFMUstate(c, null_mut()),
            fmi2SerializedFMUstateSize(c, null_mut(), &mut 0),
            fmi2SerializeFMUstate(c, null_mut(), null_mut(), 0),
            fmi2DeSerializeFMUstate(c, c"x".as_ptr(), 1, null_mut()),
            fmi2GetStatus(c, 0, null_mut()),
            fmi2GetStatus(c, 1, null_mut()),
            fmi2SetDebugLogging(c, 1, 1, null()),
            fmi2SetDebugLogging(c, 1, 1, &null()),
        ] {
            assert_eq!(status, Error);
        }
        assert_eq!(
            importer.record.0.borrow().len(),
            20,
            "every refused call logs a message"
        );
        assert_eq!(fmi2GetReal(c, null(), 0, null_mut()), Ok);
        assert_eq!(fmi2SetReal(c, null(), 0, null()), Ok);
        assert_eq!(fmi2FreeFMUstate(c, null_mut()), Ok);
        assert_eq!(fmi2FreeFMUstate(c, &mut null_mut()), Ok);
    }
    assert_eq!(importer.step(0.0, 1.0), Ok, "and nothing has changed");
}

#[test]
fn a_stored_state_continues_with_the_same_bits() {
    let importer = Importer::running();
    let c = importer.c;
    assert_eq!(importer.step(0.0, 0.7), Ok);
    let (mut state, mut size) = (null_mut(), 0);
    let go_on = |importer: &Importer| {
        assert_eq!(importer.set(INFLOW, 0.3), Ok);
        assert_eq!(importer.step(0.7, 0.9), Ok);
        importer.real(LEVEL).to_bits()
    };
    // SAFETY: instances and their states.
    unsafe {
        assert_eq!(fmi2GetFMUstate(c, &raw mut state), Ok);
        let expected = go_on(&importer);
        assert_eq!(fmi2SetFMUstate(c, state), Ok);
        assert_eq!(importer.real(INFLOW), 2.0);
        assert_eq!(go_on(&importer), expected);
        assert_eq!(fmi2SerializedFMUstateSize(c, state, &raw mut size), Ok);
        let mut bytes = vec![0; size];
        assert_eq!(fmi2SerializeFMUstate(c, state, bytes.as_mut_ptr(), size - 1), Error);
        assert_eq!(fmi2SerializeFMUstate(c, state, bytes.as_mut_ptr(), size), Ok);
        let handle = state;
        assert_eq!(fmi2GetFMUstate(c, &raw mut state), Ok);
        assert_eq!(state, handle, "a state that is not null is used again");
        assert_eq!(fmi2FreeFMUstate(c, &raw mut state), Ok);
        assert!(state.is_null());
        let other = Importer::new();
        assert_eq!(
            fmi2DeSerializeFMUstate(other.c, bytes.as_ptr(), size, &raw mut state),
            Ok
        );
        assert_eq!(fmi2SetFMUstate(other.c, state), Ok);
        assert_eq!(go_on(&other), expected);
        assert_eq!(fmi2FreeFMUstate(other.c, &raw mut state), Ok);
        bytes[size / 2] ^= 1;
        assert_eq!(
            fmi2DeSerializeFMUstate(other.c, bytes.as_ptr(), size, &raw mut state),
            Error
        );
        other.assert_logged("the stored state is damaged");
    }
}

#[test]
fn derivatives_are_those_of_the_unit() {
    let importer = Importer::running();
    let (c, mut value) = (importer.c, 0.0);
    // SAFETY: an instance, and a place for the value.
    unsafe {
        assert_eq!(fmi2SetRealInputDerivatives(c, &INFLOW, 1, &1, &1.0), Ok);
        assert_eq!(fmi2SetRealInputDerivatives(c, &INFLOW, 1, &2, &1.0), Error);
        assert_eq!(fmi2SetRealInputDerivatives(c, &GAIN, 1, &1, &1.0), Error);
        importer.assert_logged("gain is not an input");
        assert_eq!((importer.step(0.0, 1.0), importer.real(LEVEL)), (Ok, 3.5));
        assert_eq!(fmi2GetRealOutputDerivatives(c, &LEVEL, 1, &1, &raw mut value), Ok);
        assert_eq!(value, 3.0);
        assert_eq!(fmi2GetRealOutputDerivatives(c, &INFLOW, 1, &1, &raw mut value), Error);
        assert_eq!(
            fmi2GetDirectionalDerivative(c, &LEVEL, 1, &INFLOW, 1, &1.0, &raw mut value),
            Error
        );
        importer.assert_logged("fmi2GetDirectionalDerivative: not supported: ");
    }
}

#[test]
fn a_step_reports_how_it_ended() {
    let importer = Importer::running();
    let (c, mut time, mut number, mut text) = (importer.c, 0.0, -1, null());
    assert_eq!(importer.set(BRIM, 2.0), Ok);
    assert_eq!(importer.step(0.0, 1.0), Discard);
    importer.assert_logged("fmi2DoStep: full");
    // SAFETY: an instance, and places for values.
    unsafe {
        assert_eq!(fmi2GetRealStatus(c, 2, &raw mut time), Ok);
        assert_eq!(fmi2GetStatus(c, 0, &raw mut number), Ok);
        assert_eq!((time, number), (0.0, Discard as c_int));
        assert_eq!(fmi2GetBooleanStatus(c, 3, &raw mut number), Ok);
        assert_eq!(number, 0);
        assert_eq!(fmi2GetIntegerStatus(c, 0, &raw mut number), Discard);
        assert_eq!(fmi2GetStringStatus(c, 1, &raw mut text), Discard);
        importer.assert_logged("there is no status Pending");
        assert_eq!(fmi2GetStatus(c, 4, &raw mut number), Error);
        assert_eq!(fmi2CancelStep(c), Error);
    }
    assert_eq!(importer.set(BRIM, 100.0), Ok);
    assert_eq!(importer.real(LEVEL), 1.0, "as before the step");
    assert_eq!((importer.step(0.0, 1.0), importer.real(LEVEL)), (Ok, 3.0));
    assert_eq!(importer.set(MARK, -1.0), Ok);
    assert_eq!(importer.step(1.0, 0.5), Discard, "a setting that the unit refuses");
    importer.assert_logged("mark is below 0");
}

#[test]
fn a_panic_fails_its_own_instance_only() {
    let importer = Importer::running();
    assert_eq!(importer.set(INFLOW, BURST), Ok);
    assert_eq!(importer.step(0.0, 1.0), Error);
    importer.assert_logged("internal error, please report: the tank burst");
    assert_eq!(importer.step(0.0, 1.0), Error);
    importer.assert_logged("in the error state; reset it or restore a stored state");
}

#[test]
fn the_log_is_a_matter_of_choice() {
    let importer = Importer::running();
    assert!(importer.record.0.borrow().is_empty());
    // SAFETY: an instance, strings that end with a zero.
    unsafe {
        assert_eq!(fmi2SetDebugLogging(importer.c, 1, 1, &c"noise".as_ptr()), Error);
        importer.assert_logged("no log category \"noise\"");
        assert_eq!(fmi2SetDebugLogging(importer.c, 1, 1, &c"logEvents".as_ptr()), Ok);
        assert_eq!(fmi2Terminate(importer.c), Ok);
    }
}

/// The environment in which the logger runs.
#[cfg(target_arch = "x86_64")]
unsafe extern "C" fn record_environment(
    environment: *mut std::ffi::c_void,
    _: *const c_char,
    _: c_int,
    _: *const c_char,
    _: *const c_char,
    _: *const c_char,
) {
    // SAFETY: `environment` is the list of the test below.
    let seen = unsafe { &mut *environment.cast::<Vec<crate::environment::Environment>>() };
    seen.push(crate::environment::present());
}

#[cfg(target_arch = "x86_64")]
#[test]
fn every_floating_point_environment_gives_the_same_bits_and_stays_as_it_is() {
    use crate::environment::{DEFAULT, Environment, HOSTS, within};

    let run = || {
        let mut seen = Vec::<Environment>::new();
        let functions = CallbackFunctions {
            // SAFETY: see `log_message`.
            logger: Some(unsafe { std::mem::transmute::<*const (), Logger>(record_environment as *const ()) }),
            allocate_memory: None,
            free_memory: None,
            step_finished: None,
            component_environment: (&raw mut seen).cast(),
        };
        let (mut values, mut state) = ([0.0; 3], null_mut());
        // SAFETY: all pointers are valid, and the instance is freed at the end.
        unsafe {
            let c = fmi2Instantiate(c"tank".as_ptr(), 1, guid().as_ptr(), null(), &raw const functions, 0, 1);
            assert!(!c.is_null());
            let numbers: [f64; 2] = [1.0 / 3.0, 0.1];
            assert_eq!(fmi2SetReal(c, [GAIN, INFLOW].as_ptr(), 2, numbers.as_ptr()), Ok);
            assert_eq!(fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0), Ok);
            assert_eq!(fmi2EnterInitializationMode(c), Ok);
            assert_eq!(fmi2ExitInitializationMode(c), Ok);
            assert_eq!(fmi2DoStep(c, 0.0, 0.7, 1), Ok);
            assert_eq!(fmi2GetReal(c, &LEVEL, 1, &raw mut values[0]), Ok);
            assert_eq!(fmi2GetFMUstate(c, &raw mut state), Ok);
            // Subnormal, an overflow in the tank, and not a number.
            assert_eq!(fmi2SetReal(c, &INFLOW, 1, &5e-324), Ok);
            assert_eq!(fmi2DoStep(c, 0.7, 0.1, 1), Ok);
            assert_eq!(fmi2GetReal(c, &INFLOW, 1, &raw mut values[1]), Ok);
            assert_eq!(fmi2SetReal(c, &INFLOW, 1, &f64::MAX), Ok);
            assert_eq!(fmi2SetReal(c, &GAIN, 1, &10.0), Ok);
            fmi2DoStep(c, 0.7999999999999999, 0.1, 1);
            assert_eq!(fmi2SetReal(c, &INFLOW, 1, &f64::NAN), Discard);
            assert_eq!(fmi2SetFMUstate(c, state), Ok);
            assert_eq!(fmi2FreeFMUstate(c, &raw mut state), Ok);
            assert_eq!(fmi2DoStep(c, 0.7, 0.3, 1), Ok);
            assert_eq!(fmi2GetReal(c, &LEVEL, 1, &raw mut values[2]), Ok);
            fmi2FreeInstance(c);
        }
        (values.map(f64::to_bits), seen)
    };
    let (expected, seen) = within(DEFAULT, run);
    assert!(seen.len() >= 2, "a remark at the start, and a discarded value");
    for host in HOSTS {
        let (bits, seen) = within(host, run);
        assert_eq!(bits, expected, "{host:?}");
        assert!(seen.iter().all(|of_logger| *of_logger == host), "{host:?} {seen:?}");
    }
}
