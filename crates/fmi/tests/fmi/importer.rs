//! An importer of either version: it makes the C functions' calls, and records the messages and the
//! intermediate updates.
//!
//! Other tests include this file: `crate::layer` is the FMI layer.

#![allow(
    unsafe_code,
    clippy::undocumented_unsafe_blocks,
    reason = "it calls C functions, on its own instance and arrays"
)]

use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::fmt::Debug;
use std::marker::PhantomData;
use std::ptr::{null, null_mut};
use std::rc::Rc;

use crate::layer::Unit;
use crate::layer::Version::{self, Three, Two};
use crate::layer::fmi2::functions as f2;
use crate::layer::fmi2::{CallbackFunctions, Logger};
use crate::layer::fmi3::functions as f3;
use crate::layer::log::Status::{self, Discard, Ok as Done};
use crate::layer::table::Kind;
use crate::layer::unit::Experiment;

pub const BOTH: [Version; 2] = [Two, Three];
/// Value reference of the time in FMI 3.0.
pub const TIME: u32 = 0;

#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    pub status: c_int,
    pub category: String,
    pub text: String,
}

/// Arguments of the callback in intermediate update mode: the time, whether inputs may be set, and
/// an early return be requested.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Update {
    pub time: f64,
    pub set: bool,
    pub can_return: bool,
}

/// The importer's callback; it returns the time of an early return, if it requests one.
type Answer = Box<dyn FnMut(Update) -> Option<f64>>;

/// The importer's data for an instance.
#[derive(Default)]
pub struct Record {
    pub messages: RefCell<Vec<Message>>,
    /// Name of the instance in the last message, in FMI 2.0.
    pub instance: RefCell<String>,
    pub updates: RefCell<Vec<Update>>,
    /// Stored states that are freed with the instance.
    states: RefCell<Vec<Stored>>,
    pub answer: RefCell<Option<Answer>>,
    /// Called at each message.
    pub hears: RefCell<Option<Box<dyn FnMut()>>>,
}

impl Record {
    fn hear(&self, status: c_int, category: String, text: String) {
        self.messages.borrow_mut().push(Message {
            status,
            category,
            text,
        });
        if let Some(hears) = &mut *self.hears.borrow_mut() {
            hears();
        }
    }
}

unsafe fn own(text: *const c_char) -> String {
    unsafe { CStr::from_ptr(text) }.to_str().expect("UTF-8").to_owned()
}

/// The standard's logger is variadic. This one takes the one argument that belongs to "%s"; on the
/// platforms of the tests both are called the same way.
unsafe extern "C" fn log_of_fmi2(
    environment: *mut c_void,
    instance: *const c_char,
    status: c_int,
    category: *const c_char,
    format: *const c_char,
    argument: *const c_char,
) {
    unsafe {
        let (record, format) = (&*environment.cast::<Record>(), own(format));
        let with_argument = format == "%s";
        let text = if with_argument { own(argument) } else { format };
        assert_eq!(text.contains('%'), with_argument, "{text}");
        *record.instance.borrow_mut() = own(instance);
        record.hear(status, own(category), text);
    }
}

pub unsafe extern "C" fn log_of_fmi3(
    environment: *mut c_void,
    status: c_int,
    category: *const c_char,
    message: *const c_char,
) {
    unsafe {
        let record = &*environment.cast::<Record>();
        record.hear(status, own(category), own(message));
    }
}

unsafe extern "C" fn update(
    environment: *mut c_void,
    time: f64,
    set: u8,
    get: u8,
    finished: u8,
    can_return: u8,
    requested: *mut u8,
    until: *mut f64,
) {
    assert_eq!((get, finished, set <= 1, can_return <= 1), (1, 1, true, true));
    let now = Update {
        time,
        set: set == 1,
        can_return: can_return == 1,
    };
    unsafe {
        let record = &*environment.cast::<Record>();
        record.updates.borrow_mut().push(now);
        if let Some(time) = record.answer.borrow_mut().as_mut().and_then(|answer| answer(now)) {
            requested.write(1);
            until.write(time);
        }
    }
}

/// Capabilities of an importer of FMI 3.0.
#[derive(Clone, Copy, Default)]
pub struct Handles<'a> {
    pub events: bool,
    pub early_return: bool,
    /// Variables for intermediate update mode; the callback is set if there are any.
    pub required: &'a [u32],
}

impl<'a> Handles<'a> {
    pub const EVENTS: Self = Self {
        events: true,
        ..Self::updates(&[])
    };

    /// Early returns, and intermediate updates with these variables.
    pub const fn updates(required: &'a [u32]) -> Self {
        Self {
            events: false,
            early_return: true,
            required,
        }
    }
}

pub fn experiment(start: f64, stop: Option<f64>) -> Experiment {
    Experiment {
        tolerance: None,
        start,
        stop,
    }
}

pub struct Arguments<'a> {
    /// Name, token, location of the resources.
    pub texts: [Option<&'a CStr>; 3],
    pub debug: bool,
    /// The kind of instance in FMI 2.0: 1 is co-simulation.
    pub kind: c_int,
    pub handles: Handles<'a>,
}

impl<'a> Arguments<'a> {
    pub fn new(texts: [Option<&'a CStr>; 3]) -> Self {
        Self {
            texts,
            debug: false,
            kind: 1,
            handles: Handles::default(),
        }
    }
}

pub fn token<U: Unit>(version: Version) -> CString {
    CString::new(crate::layer::token::<U>(version, None)).expect("no zero inside")
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ended {
    pub status: Status,
    pub event: bool,
    pub early: bool,
    pub time: f64,
}

/// The C function of the instance's version.
macro_rules! call {
    ($instance:expr, $two:ident($($a:expr),*), $three:ident($($b:expr),*)) => {
        unsafe {
            match $instance.version {
                Two => f2::$two::<U>($instance.c $(, $a)*),
                Three => f3::$three::<U>($instance.c $(, $b)*),
            }
        }
    };
}

/// The result of a call that was done, or its status.
fn done<T>(status: Status, found: T) -> Result<T, Status> {
    if status == Done { Ok(found) } else { Err(status) }
}

pub type Stored = *mut c_void;

/// An instance with the importer's data for it.
pub struct Importer<U: Unit> {
    pub version: Version,
    pub c: *mut c_void,
    pub record: Rc<Record>,
    events: bool,
    owned: bool,
    unit: PhantomData<U>,
}

impl<U: Unit> Importer<U> {
    /// An instance, or null, for these arguments.
    pub fn with(version: Version, arguments: &Arguments<'_>) -> Self {
        let record = Rc::new(Record::default());
        let environment = Rc::as_ptr(&record).cast_mut().cast();
        let [name, token, location] = arguments.texts.map(|text| text.map_or(null(), CStr::as_ptr));
        let Handles {
            events,
            early_return,
            required,
        } = arguments.handles;
        let c = unsafe {
            match version {
                Two => {
                    let functions = CallbackFunctions {
                        logger: Some(std::mem::transmute::<*const (), Logger>(log_of_fmi2 as *const ())),
                        allocate_memory: None,
                        free_memory: None,
                        step_finished: None,
                        component_environment: environment,
                    };
                    let (kind, debug) = (arguments.kind, arguments.debug.into());
                    f2::fmi2Instantiate::<U>(name, kind, token, location, &raw const functions, 0, debug)
                }
                Three => f3::fmi3InstantiateCoSimulation::<U>(
                    name,
                    token,
                    location,
                    0,
                    arguments.debug.into(),
                    events.into(),
                    early_return.into(),
                    required.as_ptr(),
                    required.len(),
                    environment,
                    Some(log_of_fmi3),
                    (!required.is_empty()).then_some(update as _),
                ),
            }
        };
        Self {
            version,
            c,
            record,
            events,
            owned: true,
            unit: PhantomData,
        }
    }

    /// An instance without debug logging in FMI 2.0, and with it in FMI 3.0, which has events.
    pub fn new(version: Version) -> Self {
        Self::handling(version, Handles::default())
    }

    /// An instance whose importer handles more.
    pub fn handling(version: Version, handles: Handles<'_>) -> Self {
        let token = token::<U>(version);
        let arguments = Arguments {
            debug: version == Three,
            handles,
            ..Arguments::new([Some(c"instance"), Some(&token), None])
        };
        let importer = Self::with(version, &arguments);
        assert!(!importer.c.is_null(), "{}", importer.last());
        importer
    }

    pub fn start(&self) {
        self.start_at(0.0);
    }

    /// From instantiated to step mode, by way of event mode if the importer handles events.
    pub fn start_at(&self, time: f64) {
        assert_eq!(self.enter(experiment(time, None)), Done, "{}", self.last());
        assert_eq!(self.exit(), Done, "{}", self.last());
        if self.events {
            self.handle_event();
        }
    }

    /// Sets up the experiment and enters initialisation mode.
    pub fn enter(&self, experiment: Experiment) -> Status {
        let defined = |value: Option<f64>| (u8::from(value.is_some()), value.unwrap_or(f64::NAN));
        let ((tolerates, tolerance), start) = (defined(experiment.tolerance), experiment.start);
        let (stops, stop) = defined(experiment.stop);
        unsafe {
            match self.version {
                Two => {
                    let (tolerates, stops) = (tolerates.into(), stops.into());
                    match f2::fmi2SetupExperiment::<U>(self.c, tolerates, tolerance, start, stops, stop) {
                        Done => f2::fmi2EnterInitializationMode::<U>(self.c),
                        refused => refused,
                    }
                }
                Three => {
                    f3::fmi3EnterInitializationMode::<U>(self.c, tolerates, tolerance, start, stops, stop)
                }
            }
        }
    }

    pub fn exit(&self) -> Status {
        call! { self, fmi2ExitInitializationMode(), fmi3ExitInitializationMode() }
    }

    pub fn terminate(&self) -> Status {
        call! { self, fmi2Terminate(), fmi3Terminate() }
    }

    pub fn reset(&self) -> Status {
        call! { self, fmi2Reset(), fmi3Reset() }
    }

    /// Updates discrete states and goes from event mode to step mode.
    pub fn handle_event(&self) {
        let (mut flags, mut time) = ([9; 5], f64::NAN);
        let [a, b, c, d, e] = flags.each_mut().map(std::ptr::from_mut);
        unsafe {
            let updated = f3::fmi3UpdateDiscreteStates::<U>(self.c, a, b, c, d, e, &raw mut time);
            assert_eq!(updated, Done, "{}", self.last());
            assert_eq!(f3::fmi3EnterStepMode::<U>(self.c), Done);
        }
        assert_eq!((flags, time), ([0; 5], 0.0));
    }

    pub fn step(&self, from: f64, size: f64) -> Ended {
        let (mut flags, mut time) = ([9; 3], f64::NAN);
        let [event, terminate, early] = flags.each_mut().map(std::ptr::from_mut);
        let status = unsafe {
            match self.version {
                Two => {
                    let status = f2::fmi2DoStep::<U>(self.c, from, size, 1);
                    if matches!(status, Done | Discard) {
                        assert_eq!(f2::fmi2GetRealStatus::<U>(self.c, 2, &raw mut time), Done);
                    }
                    flags = [0; 3];
                    status
                }
                Three => f3::fmi3DoStep::<U>(self.c, from, size, 1, event, terminate, early, &raw mut time),
            }
        };
        assert_eq!(flags[1], 0, "{}", self.last());
        Ended {
            status,
            event: flags[0] == 1,
            early: flags[2] == 1,
            time,
        }
    }

    pub fn set_reals(&self, references: &[u32], values: &[f64]) -> Status {
        assert_eq!(references.len(), values.len());
        let (vr, nvr, value, n) = (references.as_ptr(), references.len(), values.as_ptr(), values.len());
        call! { self, fmi2SetReal(vr, nvr, value), fmi3SetFloat64(vr, nvr, value, n) }
    }

    pub fn reals(&self, references: &[u32], count: usize) -> Result<Vec<f64>, Status> {
        let (vr, nvr) = (references.as_ptr(), references.len());
        assert!(self.version == Three || nvr == count);
        let mut values = vec![f64::NAN; count];
        let status = call! {
            self, fmi2GetReal(vr, nvr, values.as_mut_ptr()),
            fmi3GetFloat64(vr, nvr, values.as_mut_ptr(), count)
        };
        done(status, values)
    }

    pub fn assert_reals(&self, references: &[u32], values: &[f64]) {
        let found = self.reals(references, values.len());
        assert_eq!(found.as_deref(), Ok(values), "{}", self.last());
    }

    pub fn set(&self, reference: u32, value: f64) -> Status {
        self.set_reals(&[reference], &[value])
    }

    pub fn real(&self, reference: u32) -> f64 {
        self.reals(&[reference], 1)
            .unwrap_or_else(|status| panic!("{status:?}: {}", self.last()))[0]
    }

    /// Writes a whole number, an item of an enumeration or a truth value.
    pub fn set_number(&self, reference: u32, value: i32) -> Status {
        let (byte, wide) = (value as u8, i64::from(value));
        let (vr, number, byte, wide) =
            (&raw const reference, &raw const value, &raw const byte, &raw const wide);
        match U::table().by_reference(reference).map(|one| &one.kind) {
            Some(Kind::Boolean { .. }) => {
                call! { self, fmi2SetBoolean(vr, 1, number), fmi3SetBoolean(vr, 1, byte, 1) }
            }
            Some(Kind::Enumeration { .. }) => {
                call! { self, fmi2SetInteger(vr, 1, number), fmi3SetInt64(vr, 1, wide, 1) }
            }
            _ => call! { self, fmi2SetInteger(vr, 1, number), fmi3SetInt32(vr, 1, number, 1) },
        }
    }

    pub fn number(&self, reference: u32) -> Result<i64, Status> {
        let (vr, mut value, mut byte, mut wide) = (&raw const reference, 0, 0, 0);
        let (number, of_byte, of_wide) = (&raw mut value, &raw mut byte, &raw mut wide);
        let status = match U::table().by_reference(reference).map(|one| &one.kind) {
            Some(Kind::Boolean { .. }) => {
                call! { self, fmi2GetBoolean(vr, 1, number), fmi3GetBoolean(vr, 1, of_byte, 1) }
            }
            Some(Kind::Enumeration { .. }) => {
                call! { self, fmi2GetInteger(vr, 1, number), fmi3GetInt64(vr, 1, of_wide, 1) }
            }
            _ => call! { self, fmi2GetInteger(vr, 1, number), fmi3GetInt32(vr, 1, number, 1) },
        };
        // Two of them are still 0.
        done(status, i64::from(value) + i64::from(byte) + wide)
    }

    pub fn derivatives(&self, references: &[u32], order: i32) -> Result<Vec<f64>, Status> {
        let (vr, nvr, orders) = (references.as_ptr(), references.len(), vec![order; references.len()]);
        let mut values = vec![f64::NAN; nvr];
        let (order, value) = (orders.as_ptr(), values.as_mut_ptr());
        let status = call! {
            self, fmi2GetRealOutputDerivatives(vr, nvr, order, value),
            fmi3GetOutputDerivatives(vr, nvr, order, value, nvr)
        };
        done(status, values)
    }

    /// The derivative of an input in the next step, in FMI 2.0.
    pub fn set_derivative(&self, reference: u32, order: i32, value: f64) -> Status {
        let (vr, order, value) = (&raw const reference, &raw const order, &raw const value);
        unsafe { f2::fmi2SetRealInputDerivatives::<U>(self.c, vr, 1, order, value) }
    }

    pub fn store(&self, state: &mut Stored) -> Status {
        call! { self, fmi2GetFMUstate(state), fmi3GetFMUState(state) }
    }

    pub fn stored(&self) -> Stored {
        let mut state = null_mut();
        assert_eq!(self.store(&mut state), Done, "{}", self.last());
        self.record.states.borrow_mut().push(state);
        state
    }

    pub fn restore(&self, state: Stored) -> Status {
        call! { self, fmi2SetFMUstate(state), fmi3SetFMUState(state) }
    }

    pub fn free(&self, state: &mut Stored) -> Status {
        call! { self, fmi2FreeFMUstate(state), fmi3FreeFMUState(state) }
    }

    pub fn write_bytes(&self, state: Stored, bytes: &mut [u8]) -> Status {
        let (pointer, size) = (bytes.as_mut_ptr(), bytes.len());
        call! {
            self, fmi2SerializeFMUstate(state, pointer.cast(), size),
            fmi3SerializeFMUState(state, pointer, size)
        }
    }

    pub fn bytes(&self) -> Vec<u8> {
        let (state, mut size) = (self.stored(), 0);
        let status = call! {
            self, fmi2SerializedFMUstateSize(state, &raw mut size),
            fmi3SerializedFMUStateSize(state, &raw mut size)
        };
        assert_eq!(status, Done, "{}", self.last());
        let mut bytes = vec![0; size];
        assert_eq!(self.write_bytes(state, &mut bytes), Done, "{}", self.last());
        bytes
    }

    pub fn read_bytes(&self, bytes: &[u8]) -> Result<Stored, Status> {
        let (pointer, size, mut state) = (bytes.as_ptr(), bytes.len(), null_mut());
        let status = call! {
            self, fmi2DeSerializeFMUstate(pointer.cast(), size, &raw mut state),
            fmi3DeserializeFMUState(pointer, size, &raw mut state)
        };
        done(status, state)
    }

    pub fn continue_from(&self, bytes: &[u8]) -> Status {
        match self.read_bytes(bytes) {
            Ok(mut state) => {
                let status = self.restore(state);
                assert_eq!(self.free(&mut state), Done);
                status
            }
            Err(refused) => refused,
        }
    }

    pub fn log(&self, on: bool, categories: &[&CStr]) -> Status {
        let (categories, on): (Vec<_>, _) =
            (categories.iter().map(|name| name.as_ptr()).collect(), u8::from(on));
        call! {
            self, fmi2SetDebugLogging(on.into(), categories.len(), categories.as_ptr()),
            fmi3SetDebugLogging(on, categories.len(), categories.as_ptr())
        }
    }

    pub fn answer(&self, answer: impl FnMut(Update) -> Option<f64> + 'static) {
        *self.record.answer.borrow_mut() = Some(Box::new(answer));
    }

    /// Another handle of the instance, for the importer's callback.
    pub fn alias(&self) -> Self {
        Self {
            record: Rc::clone(&self.record),
            owned: false,
            ..*self
        }
    }

    pub fn enter_event_mode(&self) -> Status {
        unsafe { f3::fmi3EnterEventMode::<U>(self.c) }
    }

    pub fn last(&self) -> String {
        let messages = self.record.messages.borrow();
        messages.last().map_or_else(String::new, |message| message.text.clone())
    }

    /// A call ended like this, and the last message has this part.
    pub fn assert<T: PartialEq + Debug>(&self, found: T, expected: T, part: &str) {
        assert_eq!(found, expected, "{part}");
        self.assert_logged(part);
    }

    pub fn assert_logged(&self, part: &str) {
        assert!(self.last().contains(part), "{part:?} in {:?}", self.last());
    }
}

impl<U: Unit> Drop for Importer<U> {
    fn drop(&mut self) {
        if self.owned {
            for mut state in self.record.states.take() {
                assert_eq!(self.free(&mut state), Done);
                assert!(state.is_null());
            }
            let free: unsafe fn(*mut c_void) = match self.version {
                Two => f2::fmi2FreeInstance::<U>,
                Three => f3::fmi3FreeInstance::<U>,
            };
            unsafe { free(self.c) };
            self.record.answer.take();
            self.record.hears.take();
        }
    }
}
