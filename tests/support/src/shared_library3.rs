//! The functions of FMI 3.0 in the shared library, loaded as by an importer.

#![allow(unsafe_code, reason = "it calls the C functions")]

use crate::shared_library::functions;
use pushbelt::fmi::fmi3::{
    Binary, Boolean, Environment, FmuState, Instance, IntermediateUpdate, LogMessage, Reference, Text,
};
use pushbelt::unit::VariatorUnit;
use std::ffi::{CString, c_char, c_int, c_void};
use std::ptr::{null, null_mut};

/// Statuses as the library returns them.
type Status = c_int;

pushbelt::fmi::fmi3_functions! { [functions] Functions3: }

impl Functions3 {
    /// An instance without a function for messages.
    #[must_use]
    pub fn instantiate(&self) -> Instance {
        let token = pushbelt::fmi::token::<VariatorUnit>(pushbelt::fmi::Version::Three, None);
        let token = CString::new(token).expect("no zero inside");
        let (name, create) = (c"variator".as_ptr(), self.fmi3InstantiateCoSimulation);
        // SAFETY: valid strings, and null where it is allowed.
        let c = unsafe {
            create(
                name,
                token.as_ptr(),
                null(),
                0,
                0,
                0,
                0,
                null(),
                0,
                null_mut(),
                None,
                None,
            )
        };
        assert!(!c.is_null());
        c
    }
}
