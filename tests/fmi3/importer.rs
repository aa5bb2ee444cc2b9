//! An importer that records the messages of the unit and has a callback for intermediate updates.

use std::cell::RefCell;
use std::ffi::{CStr, CString, c_int};
use std::ptr::null;

use pushbelt::fmi::Unit;
use pushbelt::fmi::fmi3::{Boolean, Environment, Instance, Text, instantiation_token};
use pushbelt::fmi::log::Status::{self, Ok};
use pushbelt::fmi::table::Kind;
use pushbelt::unit::VariatorUnit;
use pushbelt::unit::exports::c_abi3::*;
pub use pushbelt_lab::shared_library::real_outputs;

/// Arguments of the callback in intermediate update mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Update {
    pub time: f64,
    pub set: bool,
    pub get: bool,
    pub finished: bool,
    pub can_return: bool,
}

/// The importer's callback: returns the time of an early return, if it requests one.
type Answer = Box<dyn FnMut(Update) -> Option<f64>>;

/// The importer's data for an instance: messages (status, category, text), updates, its callback.
#[derive(Default)]
pub struct Record {
    pub messages: RefCell<Vec<(c_int, String, String)>>,
    pub updates: RefCell<Vec<Update>>,
    pub answer: RefCell<Option<Answer>>,
}

unsafe extern "C" fn log_message(environment: Environment, status: c_int, category: Text, message: Text) {
    // SAFETY: `environment` is the `Record` of the importer below, the strings are what this test is about.
    unsafe {
        let own = |text| CStr::from_ptr(text).to_str().expect("UTF-8").to_string();
        let record = &*environment.cast::<Record>();
        record.messages.borrow_mut().push((status, own(category), own(message)));
    }
}

unsafe extern "C" fn update(
    environment: Environment,
    time: f64,
    set: Boolean,
    get: Boolean,
    finished: Boolean,
    can_return: Boolean,
    requested: *mut Boolean,
    until: *mut f64,
) {
    // SAFETY: `environment` is the `Record` of the importer below; the places are the unit's.
    unsafe {
        let record = &*environment.cast::<Record>();
        let now = Update {
            time,
            set: set != 0,
            get: get != 0,
            finished: finished != 0,
            can_return: can_return != 0,
        };
        record.updates.borrow_mut().push(now);
        let answer = record.answer.borrow_mut().as_mut().and_then(|answer| answer(now));
        requested.write(answer.is_some().into());
        if let Some(time) = answer {
            until.write(time);
        }
    }
}

pub fn token() -> CString {
    CString::new(instantiation_token::<VariatorUnit>()).expect("no zero inside")
}

/// Capabilities of an importer.
#[derive(Clone, Copy, Default)]
pub struct Handles<'a> {
    pub events: bool,
    pub early_return: bool,
    /// Variables for intermediate update mode; the callback is set if there are any.
    pub required: &'a [&'a str],
}

/// How a communication step ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ended {
    pub status: Status,
    pub event: bool,
    pub early: bool,
    pub time: f64,
}

/// An instance with the importer's data for it.
pub struct Importer {
    pub c: Instance,
    pub record: Box<Record>,
}

impl Importer {
    pub fn new(handles: Handles<'_>) -> Self {
        let record = Box::new(Record::default());
        let required: Vec<u32> = handles.required.iter().map(|name| reference(name)).collect();
        // SAFETY: all pointers are valid.
        let c = unsafe {
            fmi3InstantiateCoSimulation(
                c"variator".as_ptr(),
                token().as_ptr(),
                c"/tmp/a b/resources/".as_ptr(),
                0,
                1,
                handles.events.into(),
                handles.early_return.into(),
                required.as_ptr(),
                required.len(),
                std::ptr::from_ref(&*record).cast_mut().cast(),
                Some(log_message),
                (!required.is_empty()).then_some(update),
            )
        };
        assert!(!c.is_null(), "{:?}", record.messages);
        Self { c, record }
    }

    /// An instance in step mode, of the cheapest variator.
    pub fn running(handles: Handles<'_>) -> Self {
        let importer = Self::new(handles);
        importer.make_cheap();
        importer.start(handles.events);
        importer
    }

    /// A coarse reference ring that starts unloaded: these tests are about the interface.
    pub fn make_cheap(&self) {
        assert_eq!(self.set_choice("ring.model", 1), Ok);
        for name in ["mesh.primaryArc", "mesh.secondaryArc", "mesh.strand"] {
            assert_eq!(self.set_integer(name, 4), Ok);
        }
        assert_eq!(self.set_boolean("initial.steady", 0), Ok);
    }

    pub fn start(&self, events: bool) {
        // SAFETY: `c` is an instance, here and below.
        unsafe {
            assert_eq!(
                fmi3EnterInitializationMode(self.c, 1, 1e-4, 0.0, 0, 0.0),
                Ok,
                "{}",
                self.last()
            );
            assert_eq!(fmi3ExitInitializationMode(self.c), Ok, "{}", self.last());
        }
        if events {
            self.handle_event(false);
        }
    }

    /// Through event mode and back to step mode.
    pub fn handle_event(&self, enter: bool) {
        let mut flags = [9; 5];
        let mut time = f64::NAN;
        let [a, b, c, d, e] = flags.each_mut().map(std::ptr::from_mut);
        // SAFETY: an instance, and a place for each result.
        unsafe {
            if enter {
                assert_eq!(fmi3EnterEventMode(self.c), Ok, "{}", self.last());
            }
            assert_eq!(fmi3UpdateDiscreteStates(self.c, a, b, c, d, e, &raw mut time), Ok);
            assert_eq!(fmi3EnterStepMode(self.c), Ok);
        }
        assert_eq!((flags, time), ([0; 5], 0.0));
    }

    pub fn step(&self, from: f64, size: f64) -> Ended {
        let mut flags = [9; 3];
        let mut time = f64::NAN;
        let [event, terminate, early] = flags.each_mut().map(std::ptr::from_mut);
        // SAFETY: an instance, and a place for each result.
        let status = unsafe { fmi3DoStep(self.c, from, size, 1, event, terminate, early, &raw mut time) };
        assert!(status == Status::Error || flags[1] == 0);
        Ended {
            status,
            event: flags[0] == 1,
            early: flags[2] == 1,
            time,
        }
    }

    pub fn set_real(&self, name: &str, value: f64) -> Status {
        unsafe { fmi3SetFloat64(self.c, &reference(name), 1, &value, 1) }
    }

    pub fn set_integer(&self, name: &str, value: i32) -> Status {
        unsafe { fmi3SetInt32(self.c, &reference(name), 1, &value, 1) }
    }

    pub fn set_choice(&self, name: &str, value: i64) -> Status {
        unsafe { fmi3SetInt64(self.c, &reference(name), 1, &value, 1) }
    }

    pub fn set_boolean(&self, name: &str, value: u8) -> Status {
        unsafe { fmi3SetBoolean(self.c, &reference(name), 1, &value, 1) }
    }

    pub fn real(&self, name: &str) -> f64 {
        read(self.c, name)
    }

    pub fn boolean(&self, name: &str) -> u8 {
        let mut value = 9;
        let status = unsafe { fmi3GetBoolean(self.c, &reference(name), 1, &raw mut value, 1) };
        assert_eq!(status, Ok, "{name} {}", self.last());
        value
    }

    /// The bits of all real outputs and locals, fields along the belt included.
    pub fn readings(&self) -> Vec<u64> {
        let table = VariatorUnit::table();
        let real = |reference: u32| {
            let variable = table.by_reference(reference).expect("listed");
            !variable.causality.is_setting() && matches!(variable.kind, Kind::Real { .. })
        };
        let first = |reference: u32| table.array_of(reference).is_none_or(|array| array.first == reference);
        let all = table.variables().iter().map(|variable| variable.reference);
        let references: Vec<u32> = all.clone().filter(|r| real(*r) && first(*r)).collect();
        let mut values = vec![f64::NAN; all.filter(|r| real(*r)).count()];
        // SAFETY: an instance, and as many values as the variables have.
        let status = unsafe {
            fmi3GetFloat64(
                self.c,
                references.as_ptr(),
                references.len(),
                values.as_mut_ptr(),
                values.len(),
            )
        };
        assert_eq!(status, Ok, "{}", self.last());
        values.into_iter().map(f64::to_bits).collect()
    }

    /// Time derivatives of all real outputs.
    pub fn derivatives(&self) -> Vec<u64> {
        let references = real_outputs();
        let orders = vec![1; references.len()];
        let mut values = vec![f64::NAN; references.len()];
        // SAFETY: an instance, and as many orders and values as references.
        let status = unsafe {
            fmi3GetOutputDerivatives(
                self.c,
                references.as_ptr(),
                references.len(),
                orders.as_ptr(),
                values.as_mut_ptr(),
                values.len(),
            )
        };
        assert_eq!(status, Ok, "{}", self.last());
        values.into_iter().map(f64::to_bits).collect()
    }

    pub fn answer(&self, answer: impl FnMut(Update) -> Option<f64> + 'static) {
        *self.record.answer.borrow_mut() = Some(Box::new(answer));
    }

    pub fn last(&self) -> String {
        let messages = self.record.messages.borrow();
        messages.last().map_or_else(String::new, |message| message.2.clone())
    }
}

impl Drop for Importer {
    fn drop(&mut self) {
        // SAFETY: the instance is not used any more.
        unsafe { fmi3FreeInstance(self.c) };
    }
}

/// A real variable of an instance.
pub fn read(c: Instance, name: &str) -> f64 {
    let mut value = f64::NAN;
    let wanted = if name == "time" { 0 } else { reference(name) };
    // SAFETY: an instance and a place for the value.
    assert_eq!(
        unsafe { fmi3GetFloat64(c, &wanted, 1, &raw mut value, 1) },
        Ok,
        "{name}"
    );
    value
}

/// Value reference of a variable or of an array.
pub fn reference(name: &str) -> u32 {
    let table = VariatorUnit::table();
    let array = table.arrays().iter().find(|array| array.name == name);
    array.map_or_else(|| pushbelt_lab::shared_library::reference(name), |array| array.first)
}

/// An instance without callbacks, or null, for these arguments.
pub fn instantiate(name: Text, token: Text, required: &[u32]) -> Instance {
    // SAFETY: null or valid pointers.
    unsafe {
        fmi3InstantiateCoSimulation(
            name,
            token,
            null(),
            0,
            0,
            1,
            1,
            required.as_ptr(),
            required.len(),
            std::ptr::null_mut(),
            None,
            None,
        )
    }
}
