//! An importer that records the messages of the unit.

use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char, c_int, c_void};

use pushbelt::fmi::Unit;
use pushbelt::fmi::fmi2::{CallbackFunctions, Component, Logger};
use pushbelt::fmi::log::Status::{self, Ok};
use pushbelt::fmi::table::Kind;
use pushbelt::unit::VariatorUnit;
use pushbelt::unit::exports::c_abi::*;
pub use pushbelt_lab::shared_library::{real_outputs, reference};

/// Messages that the logger received: instance, status, category, text.
#[derive(Debug, Default)]
pub struct Record(pub RefCell<Vec<(String, c_int, String, String)>>);

/// The standard's logger is variadic. This one takes the one argument that belongs to "%s"; on the platforms of the
/// tests both are called the same way.
unsafe extern "C" fn log_message(
    environment: *mut c_void,
    instance: *const c_char,
    status: c_int,
    category: *const c_char,
    format: *const c_char,
    argument: *const c_char,
) {
    // SAFETY: `environment` is the `Record` of the importer below, the strings are what this test is about.
    unsafe {
        let own = |text| CStr::from_ptr(text).to_str().expect("UTF-8").to_string();
        assert_eq!(own(format), "%s");
        let record = &*environment.cast::<Record>();
        record
            .0
            .borrow_mut()
            .push((own(instance), status, own(category), own(argument)));
    }
}

pub fn guid() -> CString {
    CString::new(pushbelt::fmi::guid::<VariatorUnit>()).expect("no zero inside")
}

/// An instance with the importer's data for it.
pub struct Importer {
    pub c: Component,
    pub record: Box<Record>,
}

impl Importer {
    pub fn new(name: &CStr) -> Self {
        let importer = Self::with_resources(name, c"file:///tmp/a%20b/resources");
        assert!(!importer.c.is_null(), "{:?}", importer.record);
        importer
    }

    /// An instance with its resources at `location`; null if the unit refuses.
    pub fn with_resources(name: &CStr, location: &CStr) -> Self {
        let record = Box::new(Record::default());
        // SAFETY: see `log_message`.
        let logger = unsafe { std::mem::transmute::<*const (), Logger>(log_message as *const ()) };
        let functions = CallbackFunctions {
            logger: Some(logger),
            allocate_memory: None,
            free_memory: None,
            step_finished: None,
            component_environment: std::ptr::from_ref(&*record).cast_mut().cast(),
        };
        // SAFETY: all pointers are valid.
        let c = unsafe { fmi2Instantiate(name.as_ptr(), 1, guid().as_ptr(), location.as_ptr(), &functions, 0, 0) };
        Self { c, record }
    }

    /// An instance in step mode, of the cheapest variator.
    pub fn running(name: &CStr) -> Self {
        let importer = Self::new(name);
        importer.make_cheap();
        importer.start();
        importer
    }

    /// A coarse reference ring that starts unloaded: these tests are about the interface.
    pub fn make_cheap(&self) {
        assert_eq!(self.set_integer("ring.model", 1), Ok);
        for name in ["mesh.primaryArc", "mesh.secondaryArc", "mesh.strand"] {
            assert_eq!(self.set_integer(name, 4), Ok);
        }
        assert_eq!(self.set_boolean("initial.steady", 0), Ok);
    }

    pub fn start(&self) {
        // SAFETY: `c` is an instance, here and below.
        unsafe {
            assert_eq!(
                fmi2SetupExperiment(self.c, 1, 1e-4, 0.0, 0, 0.0),
                Ok,
                "{:?}",
                self.record
            );
            assert_eq!(fmi2EnterInitializationMode(self.c), Ok, "{:?}", self.record);
            assert_eq!(fmi2ExitInitializationMode(self.c), Ok, "{:?}", self.record);
        }
    }

    pub fn step(&self, from: f64, step: f64) -> Status {
        unsafe { fmi2DoStep(self.c, from, step, 1) }
    }

    pub fn set_real(&self, name: &str, value: f64) -> Status {
        unsafe { fmi2SetReal(self.c, &reference(name), 1, &value) }
    }

    pub fn set_integer(&self, name: &str, value: c_int) -> Status {
        unsafe { fmi2SetInteger(self.c, &reference(name), 1, &value) }
    }

    pub fn set_boolean(&self, name: &str, value: c_int) -> Status {
        unsafe { fmi2SetBoolean(self.c, &reference(name), 1, &value) }
    }

    pub fn set_derivative(&self, name: &str, value: f64) -> Status {
        // SAFETY: an instance and valid pointers.
        unsafe { fmi2SetRealInputDerivatives(self.c, &reference(name), 1, &1, &value) }
    }

    /// Time derivatives of all real outputs.
    pub fn derivatives(&self) -> Vec<u64> {
        let references = real_outputs();
        let orders = vec![1; references.len()];
        let mut values = vec![f64::NAN; references.len()];
        // SAFETY: an instance, and as many orders and values as references.
        let status = unsafe {
            fmi2GetRealOutputDerivatives(
                self.c,
                references.as_ptr(),
                references.len(),
                orders.as_ptr(),
                values.as_mut_ptr(),
            )
        };
        assert_eq!(status, Ok, "{:?}", self.record);
        values.into_iter().map(f64::to_bits).collect()
    }

    pub fn real(&self, name: &str) -> f64 {
        let mut value = f64::NAN;
        let status = unsafe { fmi2GetReal(self.c, &reference(name), 1, &mut value) };
        assert_eq!(status, Ok, "{name} {:?}", self.record);
        value
    }

    pub fn integer(&self, name: &str) -> c_int {
        let mut value = -1;
        let status = unsafe { fmi2GetInteger(self.c, &reference(name), 1, &mut value) };
        assert_eq!(status, Ok, "{name} {:?}", self.record);
        value
    }

    pub fn boolean(&self, name: &str) -> c_int {
        let mut value = -1;
        let status = unsafe { fmi2GetBoolean(self.c, &reference(name), 1, &mut value) };
        assert_eq!(status, Ok, "{name} {:?}", self.record);
        value
    }

    /// The bits of all real outputs and locals.
    pub fn readings(&self) -> Vec<u64> {
        let table = VariatorUnit::table();
        let calculated = table.variables().iter().filter(|v| !v.causality.is_setting());
        let references: Vec<u32> = calculated
            .filter(|v| matches!(v.kind, Kind::Real { .. }))
            .map(|v| v.reference)
            .collect();
        let mut values = vec![f64::NAN; references.len()];
        // SAFETY: an instance, and as many values as references.
        let status = unsafe { fmi2GetReal(self.c, references.as_ptr(), references.len(), values.as_mut_ptr()) };
        assert_eq!(status, Ok, "{:?}", self.record);
        values.into_iter().map(f64::to_bits).collect()
    }

    /// Ten steps of 1 ms with a step of torque; readings after each.
    pub fn run(&self) -> Vec<Vec<u64>> {
        let step = |k: u32| {
            assert_eq!(self.set_real("secondary.torque", -f64::from(k)), Ok);
            assert_eq!(self.step(f64::from(k) * 1e-3, 1e-3), Ok, "{:?}", self.record);
            self.readings()
        };
        (0..10).map(step).collect()
    }

    pub fn last(&self) -> String {
        self.record.0.borrow().last().expect("a message").3.clone()
    }
}

impl Drop for Importer {
    fn drop(&mut self) {
        // SAFETY: the instance is not used any more.
        unsafe { fmi2FreeInstance(self.c) };
    }
}
