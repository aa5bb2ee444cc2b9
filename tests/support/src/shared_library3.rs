//! The functions of FMI 3.0 in the shared library, loaded as by an importer.

#![allow(unsafe_code, reason = "it calls the C functions")]

use std::ffi::{CString, c_char, c_int, c_void};
use std::ptr::{null, null_mut};

use pushbelt::fmi::fmi3::{
    Binary, Boolean, Environment, FmuState, Instance, IntermediateUpdate, LogMessage, Reference, Text,
};
use pushbelt::unit::VariatorUnit;

use crate::c_functions::{OK, functions, reference};

/// Statuses as the library returns them.
type Status = c_int;

pushbelt::fmi::fmi3_functions! { [functions] Functions3: }

/// Intermediate updates of a master.
#[derive(Clone, Copy, Debug, Default)]
pub struct Watches {
    pub events: bool,
    pub early_return: bool,
    /// Callback with this environment, for these variables.
    pub update: Option<(IntermediateUpdate, Environment)>,
}

/// How a communication step ended: event, early return, time reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ended {
    pub status: c_int,
    pub event: Boolean,
    pub early: Boolean,
    pub time: f64,
}

impl Functions3 {
    /// An instance without a function for messages. Intermediate updates are for a torque and a speed.
    #[must_use]
    pub fn instantiate(&self, watches: Watches) -> Instance {
        let token = CString::new(pushbelt::fmi::token::<VariatorUnit>(
            pushbelt::fmi::Version::Three,
            None,
        ))
        .expect("no zero inside");
        let required = ["primary.torque", "primary.speed"].map(reference);
        let (update, environment) = watches
            .update
            .map_or((None, null_mut()), |(update, environment)| (Some(update), environment));
        // SAFETY: valid strings and an array of the given length, and null where it is allowed.
        let c = unsafe {
            (self.fmi3InstantiateCoSimulation)(
                c"variator".as_ptr(),
                token.as_ptr(),
                null(),
                0,
                0,
                watches.events.into(),
                watches.early_return.into(),
                required.as_ptr(),
                required.len(),
                environment,
                None,
                update,
            )
        };
        assert!(!c.is_null());
        c
    }

    /// A coarse reference ring that starts unloaded, to be set before the start.
    ///
    /// # Safety
    /// `c` is an instance that has not been freed.
    pub unsafe fn make_cheap(&self, c: Instance) {
        let cells = ["mesh.primaryArc", "mesh.secondaryArc", "mesh.strand"].map(reference);
        let (model, steady) = (reference("ring.model"), reference("initial.steady"));
        // SAFETY: `c` is an instance, and there are as many values as references.
        unsafe {
            assert_eq!((self.fmi3SetInt64)(c, &model, 1, &1, 1), OK);
            assert_eq!((self.fmi3SetInt32)(c, cells.as_ptr(), 3, [4; 3].as_ptr(), 3), OK);
            assert_eq!((self.fmi3SetBoolean)(c, &steady, 1, &0, 1), OK);
        }
    }

    /// From instantiated to step mode, without event mode.
    ///
    /// # Safety
    /// `c` is an instance that has not been freed.
    pub unsafe fn start(&self, c: Instance) {
        // SAFETY: `c` is an instance.
        unsafe {
            assert_eq!((self.fmi3EnterInitializationMode)(c, 0, 0.0, 0.0, 0, 0.0), OK);
            assert_eq!((self.fmi3ExitInitializationMode)(c), OK);
        }
    }

    /// A communication step.
    ///
    /// # Safety
    /// `c` is null or an instance that has not been freed.
    pub unsafe fn step(&self, c: Instance, from: f64, size: f64) -> Ended {
        let (mut event, mut terminate, mut early, mut time) = (9, 9, 9, f64::NAN);
        // SAFETY: `c` is null or an instance, and there is a place for each result.
        let status = unsafe {
            (self.fmi3DoStep)(
                c,
                from,
                size,
                1,
                &raw mut event,
                &raw mut terminate,
                &raw mut early,
                &raw mut time,
            )
        };
        Ended {
            status,
            event,
            early,
            time,
        }
    }

    /// `count` steps of 1 ms with an oscillating load; the bits of some outputs and of the push forces after each.
    ///
    /// # Safety
    /// `c` is an instance that has not been freed.
    pub unsafe fn run(&self, c: Instance, load: f64, count: u32) -> Vec<Vec<u64>> {
        let torque = reference("secondary.torque");
        let outputs = ["thrustRatio", "energy.residual", "profile.pushForce[1]"].map(reference);
        let step = |k: u32| {
            let mut values = [0.0; 74];
            // SAFETY: `c` is an instance, and there are as many values as the variables have.
            unsafe {
                let load = -49.0 + load * f64::from(k % 7);
                assert_eq!((self.fmi3SetFloat64)(c, &torque, 1, &load, 1), OK);
                assert_eq!(self.step(c, f64::from(k) * 1e-3, 1e-3).status, OK);
                let status = (self.fmi3GetFloat64)(c, outputs.as_ptr(), 3, values.as_mut_ptr(), values.len());
                assert_eq!(status, OK);
            }
            values.map(f64::to_bits).to_vec()
        };
        (0..count).map(step).collect()
    }
}
