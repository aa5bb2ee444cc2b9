//! The functions of FMI 3.0 in the shared library, as an importer loads them.

#![allow(unsafe_code, reason = "it calls the C functions")]

use std::ffi::{CString, c_char, c_int, c_void};
use std::ptr::{null, null_mut};

use pushbelt::fmi::fmi3::{
    Binary, Boolean, Environment, FmuState, Instance, IntermediateUpdate, LogMessage, Reference, Text,
    instantiation_token,
};
use pushbelt::unit::VariatorUnit;

use crate::c_functions::{OK, functions, reference};

functions! {
    Functions3:
    fmi3GetVersion() -> *const c_char;
    fmi3SetDebugLogging(Instance, Boolean, usize, *const Text) -> c_int;
    fmi3InstantiateModelExchange(Text, Text, Text, Boolean, Boolean, Environment, Option<LogMessage>) -> Instance;
    fmi3InstantiateCoSimulation(
        Text, Text, Text, Boolean, Boolean, Boolean, Boolean, *const Reference, usize, Environment,
        Option<LogMessage>, Option<IntermediateUpdate>
    ) -> Instance;
    fmi3InstantiateScheduledExecution(
        Text, Text, Text, Boolean, Boolean, Environment, Option<LogMessage>, *const c_void, *const c_void,
        *const c_void
    ) -> Instance;
    fmi3FreeInstance(Instance);
    fmi3EnterInitializationMode(Instance, Boolean, f64, f64, Boolean, f64) -> c_int;
    fmi3ExitInitializationMode(Instance) -> c_int;
    fmi3EnterEventMode(Instance) -> c_int;
    fmi3Terminate(Instance) -> c_int;
    fmi3Reset(Instance) -> c_int;
    fmi3GetFloat32(Instance, *const Reference, usize, *mut f32, usize) -> c_int;
    fmi3GetFloat64(Instance, *const Reference, usize, *mut f64, usize) -> c_int;
    fmi3GetInt8(Instance, *const Reference, usize, *mut i8, usize) -> c_int;
    fmi3GetUInt8(Instance, *const Reference, usize, *mut u8, usize) -> c_int;
    fmi3GetInt16(Instance, *const Reference, usize, *mut i16, usize) -> c_int;
    fmi3GetUInt16(Instance, *const Reference, usize, *mut u16, usize) -> c_int;
    fmi3GetInt32(Instance, *const Reference, usize, *mut i32, usize) -> c_int;
    fmi3GetUInt32(Instance, *const Reference, usize, *mut u32, usize) -> c_int;
    fmi3GetInt64(Instance, *const Reference, usize, *mut i64, usize) -> c_int;
    fmi3GetUInt64(Instance, *const Reference, usize, *mut u64, usize) -> c_int;
    fmi3GetBoolean(Instance, *const Reference, usize, *mut Boolean, usize) -> c_int;
    fmi3GetString(Instance, *const Reference, usize, *mut Text, usize) -> c_int;
    fmi3GetBinary(Instance, *const Reference, usize, *mut usize, *mut Binary, usize) -> c_int;
    fmi3GetClock(Instance, *const Reference, usize, *mut Boolean) -> c_int;
    fmi3SetFloat32(Instance, *const Reference, usize, *const f32, usize) -> c_int;
    fmi3SetFloat64(Instance, *const Reference, usize, *const f64, usize) -> c_int;
    fmi3SetInt8(Instance, *const Reference, usize, *const i8, usize) -> c_int;
    fmi3SetUInt8(Instance, *const Reference, usize, *const u8, usize) -> c_int;
    fmi3SetInt16(Instance, *const Reference, usize, *const i16, usize) -> c_int;
    fmi3SetUInt16(Instance, *const Reference, usize, *const u16, usize) -> c_int;
    fmi3SetInt32(Instance, *const Reference, usize, *const i32, usize) -> c_int;
    fmi3SetUInt32(Instance, *const Reference, usize, *const u32, usize) -> c_int;
    fmi3SetInt64(Instance, *const Reference, usize, *const i64, usize) -> c_int;
    fmi3SetUInt64(Instance, *const Reference, usize, *const u64, usize) -> c_int;
    fmi3SetBoolean(Instance, *const Reference, usize, *const Boolean, usize) -> c_int;
    fmi3SetString(Instance, *const Reference, usize, *const Text, usize) -> c_int;
    fmi3SetBinary(Instance, *const Reference, usize, *const usize, *const Binary, usize) -> c_int;
    fmi3SetClock(Instance, *const Reference, usize, *const Boolean) -> c_int;
    fmi3GetNumberOfVariableDependencies(Instance, Reference, *mut usize) -> c_int;
    fmi3GetVariableDependencies(
        Instance, Reference, *mut usize, *mut Reference, *mut usize, *mut c_int, usize
    ) -> c_int;
    fmi3GetFMUState(Instance, *mut FmuState) -> c_int;
    fmi3SetFMUState(Instance, FmuState) -> c_int;
    fmi3FreeFMUState(Instance, *mut FmuState) -> c_int;
    fmi3SerializedFMUStateSize(Instance, FmuState, *mut usize) -> c_int;
    fmi3SerializeFMUState(Instance, FmuState, *mut u8, usize) -> c_int;
    fmi3DeserializeFMUState(Instance, *const u8, usize, *mut FmuState) -> c_int;
    fmi3GetDirectionalDerivative(
        Instance, *const Reference, usize, *const Reference, usize, *const f64, usize, *mut f64, usize
    ) -> c_int;
    fmi3GetAdjointDerivative(
        Instance, *const Reference, usize, *const Reference, usize, *const f64, usize, *mut f64, usize
    ) -> c_int;
    fmi3EnterConfigurationMode(Instance) -> c_int;
    fmi3ExitConfigurationMode(Instance) -> c_int;
    fmi3GetIntervalDecimal(Instance, *const Reference, usize, *mut f64, *mut i32) -> c_int;
    fmi3GetIntervalFraction(Instance, *const Reference, usize, *mut u64, *mut u64, *mut i32) -> c_int;
    fmi3GetShiftDecimal(Instance, *const Reference, usize, *mut f64) -> c_int;
    fmi3GetShiftFraction(Instance, *const Reference, usize, *mut u64, *mut u64) -> c_int;
    fmi3SetIntervalDecimal(Instance, *const Reference, usize, *const f64) -> c_int;
    fmi3SetIntervalFraction(Instance, *const Reference, usize, *const u64, *const u64) -> c_int;
    fmi3SetShiftDecimal(Instance, *const Reference, usize, *const f64) -> c_int;
    fmi3SetShiftFraction(Instance, *const Reference, usize, *const u64, *const u64) -> c_int;
    fmi3EvaluateDiscreteStates(Instance) -> c_int;
    fmi3UpdateDiscreteStates(
        Instance, *mut Boolean, *mut Boolean, *mut Boolean, *mut Boolean, *mut Boolean, *mut f64
    ) -> c_int;
    fmi3EnterContinuousTimeMode(Instance) -> c_int;
    fmi3CompletedIntegratorStep(Instance, Boolean, *mut Boolean, *mut Boolean) -> c_int;
    fmi3SetTime(Instance, f64) -> c_int;
    fmi3SetContinuousStates(Instance, *const f64, usize) -> c_int;
    fmi3GetContinuousStateDerivatives(Instance, *mut f64, usize) -> c_int;
    fmi3GetEventIndicators(Instance, *mut f64, usize) -> c_int;
    fmi3GetContinuousStates(Instance, *mut f64, usize) -> c_int;
    fmi3GetNominalsOfContinuousStates(Instance, *mut f64, usize) -> c_int;
    fmi3GetNumberOfEventIndicators(Instance, *mut usize) -> c_int;
    fmi3GetNumberOfContinuousStates(Instance, *mut usize) -> c_int;
    fmi3EnterStepMode(Instance) -> c_int;
    fmi3GetOutputDerivatives(Instance, *const Reference, usize, *const i32, *mut f64, usize) -> c_int;
    fmi3DoStep(Instance, f64, f64, Boolean, *mut Boolean, *mut Boolean, *mut Boolean, *mut f64) -> c_int;
    fmi3ActivateModelPartition(Instance, Reference, f64) -> c_int;
}

/// What a master watches.
#[derive(Clone, Copy, Debug, Default)]
pub struct Watches {
    pub events: bool,
    pub early_return: bool,
    /// Called back with this environment, for these variables.
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
        let token = CString::new(instantiation_token::<VariatorUnit>()).expect("no zero inside");
        let required = ["primary.torque", "primary.speed"].map(reference);
        let (update, environment) = watches
            .update
            .map_or((None, null_mut()), |(update, environment)| (Some(update), environment));
        // SAFETY: valid strings and an array as long as said, and null where it is allowed.
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

    /// `count` steps of 1 ms with a load that swings; the bits of some outputs and of the push forces after each.
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
