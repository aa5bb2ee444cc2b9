//! The shared library that cargo builds with these tests, loaded as by an importer.

#![allow(unsafe_code, reason = "it calls the C functions")]

use libloading::Library as Loaded;
use pushbelt::fmi::Version::{Three, Two};
use pushbelt::fmi::fmi2::{CallbackFunctions, Component};
use pushbelt::fmi::fmi3::{
    Binary, Boolean, Environment, FmuState, Instance, IntermediateUpdate, LogMessage, Reference, Text,
};
use pushbelt::fmi::table::{Causality, Kind};
use pushbelt::fmi::{Unit, Version};
use pushbelt::unit::VariatorUnit;
use std::ffi::{CString, c_char, c_int, c_uint, c_void};
use std::path::{Path, PathBuf};
use std::ptr::{null, null_mut};

pub const OK: c_int = 0;
pub const WARNING: c_int = 1;
pub const ERROR: c_int = 3;

/// The exported functions of a table of C functions, each with a list of arguments, a result and a
/// body.
macro_rules! functions {
    (
        $all:ident:
        $(
            $name:ident($($argument:ident: $type:ty),* $(,)?) $(-> $result:ty)?
                $(, $use:ident $($instance:ident)?)? $(= $body:expr)? $(=> $c:ident, $call:expr)?;
        )*
    ) => {
        #[allow(non_snake_case, reason = "names of the standard and of the header")]
        #[derive(Clone, Copy)]
        pub struct $all {
            $(pub $name: unsafe extern "C" fn($($type),*) $(-> $result)?,)*
        }

        impl $all {
            fn of(library: &libloading::Library) -> Self {
                // SAFETY: these are the types with which the library exports them; a status is an
                // `int`.
                unsafe {
                    Self {
                        $($name: *library.get(stringify!($name).as_bytes()).expect(stringify!($name)),)*
                    }
                }
            }
        }
    };
}

/// Value reference of a variable.
pub fn reference(name: &str) -> u32 {
    let table = VariatorUnit::table();
    let variable = table.by_name(name).unwrap_or_else(|| panic!("{name} is missing"));
    variable.reference
}

pub fn real_outputs() -> Vec<u32> {
    let table = VariatorUnit::table();
    let outputs = table.variables().iter().filter(|v| v.causality == Causality::Output);
    let real = outputs.filter(|v| matches!(v.kind, Kind::Real { .. }));
    real.map(|v| v.reference).collect()
}

type Status = c_int;

pushbelt::fmi::fmi2_functions! { [functions] Functions:
    pushbeltLinearize(c: Component, frequency: f64, json: *mut *mut c_char) -> Status = ();
    pushbeltGradient(c: Component, vr: *const u32, nvr: usize, json: *mut *mut c_char) -> Status = ();
    pushbeltResetNear(c: Component) -> Status = ();
    pushbeltFreeText(text: *mut c_char) = ();
}
pushbelt::fmi::fmi3_functions! { [functions] Functions3: }

/// GUID or instantiation token of the library.
pub fn token(version: Version) -> CString {
    let token = pushbelt::fmi::token::<VariatorUnit>(version, None);
    CString::new(token).expect("no zero inside")
}

/// The loaded library. It is unloaded when this is dropped.
pub struct Library {
    _loaded: Loaded,
    pub functions: Functions,
    pub functions3: Functions3,
}

/// Path of the library that cargo builds for the tests, in their folder.
pub fn path() -> PathBuf {
    let test = std::env::current_exe().expect("a test has a path");
    let folder = test.parent().expect("a test lies in a folder");
    let (prefix, suffix) = (std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    let name = format!("{prefix}pushbelt_library{suffix}");
    let path = folder.join(name);
    assert!(path.is_file(), "{} is missing", path.display());
    path
}

impl Library {
    pub fn load() -> Self {
        Self::load_from(&path())
    }

    /// The library, or a copy of it, in this file.
    pub fn load_from(path: &Path) -> Self {
        // SAFETY: the library runs no code when it is loaded.
        let loaded = unsafe { Loaded::new(path) }.expect("the library loads");
        let (functions, functions3) = (Functions::of(&loaded), Functions3::of(&loaded));
        Self {
            _loaded: loaded,
            functions,
            functions3,
        }
    }
}

impl Functions {
    /// An instance without a logger.
    pub fn instantiate(&self) -> Component {
        let guid = token(Two);
        // SAFETY: valid strings, and null where it is allowed.
        let c =
            unsafe { (self.fmi2Instantiate)(c"variator".as_ptr(), 1, guid.as_ptr(), null(), null(), 0, 0) };
        assert!(!c.is_null());
        c
    }

    /// A coarse reference ring that starts unloaded, to be set before the start.
    ///
    /// # Safety
    /// `c` is an instance that has not been freed.
    pub unsafe fn make_cheap(&self, c: Component) {
        let integers = ["ring.model", "mesh.primaryArc", "mesh.secondaryArc", "mesh.strand"].map(reference);
        let steady = reference("initial.steady");
        // SAFETY: `c` is an instance, and there are as many values as references.
        unsafe {
            let status = (self.fmi2SetInteger)(c, integers.as_ptr(), 4, [1, 4, 4, 4].as_ptr());
            assert_eq!(status, OK);
            assert_eq!((self.fmi2SetBoolean)(c, &steady, 1, &0), OK);
        }
    }

    /// From instantiated to step mode.
    ///
    /// # Safety
    /// `c` is an instance that has not been freed.
    pub unsafe fn start(&self, c: Component) {
        // SAFETY: `c` is an instance.
        unsafe {
            assert_eq!((self.fmi2SetupExperiment)(c, 0, 0.0, 0.0, 0, 0.0), OK);
            assert_eq!((self.fmi2EnterInitializationMode)(c), OK);
            assert_eq!((self.fmi2ExitInitializationMode)(c), OK);
        }
    }

    /// `count` steps of 1 ms from 0 with an oscillating load.
    ///
    /// # Safety
    /// `c` is an instance that has not been freed.
    pub unsafe fn run(&self, c: Component, count: u32) {
        let torque = reference("secondary.torque");
        for k in 0..count {
            // SAFETY: `c` is an instance, and there is a value for the reference.
            unsafe {
                let load = -49.0 + f64::from(k % 7);
                assert_eq!((self.fmi2SetReal)(c, &torque, 1, &load), OK);
                assert_eq!((self.fmi2DoStep)(c, f64::from(k) * 1e-3, 1e-3, 1), OK);
            }
        }
    }
}

impl Functions3 {
    /// An instance without a function for messages.
    pub fn instantiate(&self) -> Instance {
        let token = token(Three);
        let (name, token, create) = (c"variator".as_ptr(), token.as_ptr(), self.fmi3InstantiateCoSimulation);
        // SAFETY: valid strings, and null where it is allowed.
        let c = unsafe { create(name, token, null(), 0, 0, 0, 0, null(), 0, null_mut(), None, None) };
        assert!(!c.is_null());
        c
    }
}

/// A number from the environment, for long runs.
pub fn count(variable: &str, otherwise: u32) -> u32 {
    std::env::var(variable).map_or(otherwise, |text| text.parse().expect("a number"))
}
