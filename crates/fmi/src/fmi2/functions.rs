//! The C functions of FMI 2.0: signatures (`fmi2FunctionTypes.h`) and bodies.

use libc::{c_char, c_int, c_uint, c_void};
use std::mem::MaybeUninit;
use std::ptr::null_mut;

use super::creation::{instantiate, processor_suffices};
use super::{CallbackFunctions, Component, FmuState};
use crate::c::creation::{Texts, free_instance};
use crate::c::entry::{
    array, array_mut, co_simulation_only, enter, no_direct_derivatives, result, set_debug_logging,
};
use crate::c::{define, stored};
use crate::instance::{FmuInstance, Type};
use crate::log::Status;
use crate::state::{Call, State};
use crate::unit::{Experiment, Unit};

/// Kinds of `fmi2StatusKind` that have a value, and one that no function has.
const DO_STEP: c_int = 0;
const LAST_SUCCESSFUL_TIME: c_int = 2;
const TERMINATED: c_int = 3;
const NONE: c_int = -1;

/// Passes the 44 C functions of FMI 2.0 to another macro, after its own
/// arguments.
#[doc(hidden)]
#[macro_export]
macro_rules! fmi2_functions {
    ([$($then:tt)*] $($own:tt)*) => { $crate::fmi2_functions! { @ [$($then)*] [$($own)*]
        // Functions that read and write variables of a type, with the type of the table.
        fmi2GetReal fmi2SetReal f64 = Real;
        fmi2GetInteger fmi2SetInteger c_int = IntegerOrEnumeration;
        fmi2GetBoolean fmi2SetBoolean c_int = Boolean;
    } };
    (
        @ [$($then:tt)*] [$($own:tt)*] $($get:ident $set:ident $type:ident = $of:ident;)*
    ) => { $($then)* ! { $($own)*
        fmi2GetTypesPlatform() -> *const c_char = c"default".as_ptr();
        fmi2GetVersion() -> *const c_char = c"2.0".as_ptr();
        fmi2SetDebugLogging(
            c: Component, logging_on: c_int, n_categories: usize, categories: *const *const c_char
        ) -> Status => c, |instance| set_debug_logging(instance, logging_on != 0, categories, n_categories);
        fmi2Instantiate(
            instance_name: *const c_char, fmu_type: c_int, guid: *const c_char, resource_location: *const c_char,
            functions: *const CallbackFunctions, visible: c_int, logging_on: c_int
        ) -> Component, creates = if processor_suffices(instance_name, functions) {
            let texts = Texts { name: instance_name, token: guid, location: resource_location };
            instantiate::<U>(texts, fmu_type, functions, logging_on != 0)
        } else {
            null_mut()
        };
        fmi2FreeInstance(c: Component), free c = free_instance::<U>(c);

        // Set-up, initialisation, end.
        fmi2SetupExperiment(
            c: Component, tolerance_defined: c_int, tolerance: f64, start_time: f64, stop_time_defined: c_int, stop_time: f64
        ) -> Status => c, |instance| {
            let tolerance = (tolerance_defined != 0).then_some(tolerance);
            let stop = (stop_time_defined != 0).then_some(stop_time);
            instance.setup_experiment(Experiment { tolerance, start: start_time, stop })
        };
        fmi2EnterInitializationMode(c: Component) -> Status =>
            c, |instance| instance.enter(State::Initialisation, Call::EnterInitializationMode);
        fmi2ExitInitializationMode(c: Component) -> Status => c, FmuInstance::exit_initialization_mode;
        fmi2Terminate(c: Component) -> Status => c, |instance| instance.enter(State::Terminated, Call::Terminate);
        fmi2Reset(c: Component) -> Status => c, FmuInstance::reset;

        // Variables.
        $(
            $get(c: Component, vr: *const c_uint, nvr: usize, value: *mut $type) -> Status =>
                c, |instance| instance.get(Type::$of, array(vr, nvr)?, array_mut(value, nvr)?);
        )*
        fmi2GetString(c: Component, vr: *const c_uint, nvr: usize, value: *mut *const c_char) -> Status =>
            c, |instance| instance.no_such_type(Call::Get, array(vr, nvr)?, "string");
        $(
            $set(c: Component, vr: *const c_uint, nvr: usize, value: *const $type) -> Status =>
                c, |instance| instance.set(Type::$of, array(vr, nvr)?, array(value, nvr)?);
        )*
        fmi2SetString(c: Component, vr: *const c_uint, nvr: usize, value: *const *const c_char) -> Status =>
            c, |instance| instance.no_such_type(Call::Set, array(vr, nvr)?, "string");

        // Stored states.
        fmi2GetFMUstate(c: Component, state: *mut FmuState) -> Status => c, |instance| stored::get(instance, state);
        fmi2SetFMUstate(c: Component, state: FmuState) -> Status => c, |instance| stored::set(instance, state);
        fmi2FreeFMUstate(c: Component, state: *mut FmuState) -> Status => c, |instance| stored::free(instance, state);
        fmi2SerializedFMUstateSize(c: Component, state: FmuState, size: *mut usize) -> Status =>
            c, |instance| stored::size(instance, state, size);
        fmi2SerializeFMUstate(c: Component, state: FmuState, bytes: *mut c_char, size: usize) -> Status =>
            c, |instance| stored::serialize(instance, state, bytes.cast(), size);
        fmi2DeSerializeFMUstate(c: Component, bytes: *const c_char, size: usize, state: *mut FmuState) -> Status =>
            c, |instance| stored::deserialize(instance, bytes.cast(), size, state);

        // Derivatives.
        fmi2GetDirectionalDerivative(
            c: Component, unknown: *const c_uint, n_unknown: usize, known: *const c_uint, n_known: usize,
            dv_known: *const f64, dv_unknown: *mut f64
        ) -> Status => c, |_| no_direct_derivatives("providesDirectionalDerivative");
        fmi2SetRealInputDerivatives(
            c: Component, vr: *const c_uint, nvr: usize, order: *const c_int, value: *const f64
        ) -> Status =>
            c, |instance| instance.set_input_derivatives(array(vr, nvr)?, array(order, nvr)?, array(value, nvr)?);
        fmi2GetRealOutputDerivatives(
            c: Component, vr: *const c_uint, nvr: usize, order: *const c_int, value: *mut f64
        ) -> Status =>
            c, |instance| instance.get_output_derivatives(array(vr, nvr)?, array(order, nvr)?, array_mut(value, nvr)?);

        // Communication steps. States are stored on request only, so the last argument of
        // `fmi2DoStep` does not matter.
        fmi2DoStep(
            c: Component, current_communication_point: f64, communication_step_size: f64,
            no_set_fmu_state_prior_to_current_point: c_int
        ) -> Status => c, |instance| instance.begin_step(current_communication_point, communication_step_size).map(drop);
        // No step is ever pending.
        fmi2CancelStep(c: Component) -> Status => c, |instance| instance.allow(Call::CancelStep);
        fmi2GetStatus(c: Component, kind: c_int, value: *mut c_int) -> Status =>
            c, |instance| instance.status(kind, DO_STEP, result(value)?, |instance| instance.step_status() as c_int);
        fmi2GetRealStatus(c: Component, kind: c_int, value: *mut f64) -> Status =>
            c, |instance| instance.status(kind, LAST_SUCCESSFUL_TIME, result(value)?, FmuInstance::time);
        fmi2GetIntegerStatus(c: Component, kind: c_int, value: *mut c_int) -> Status =>
            c, |instance| instance.status(kind, NONE, &mut MaybeUninit::uninit(), |_| ());
        // The instance never requests the end of the run.
        fmi2GetBooleanStatus(c: Component, kind: c_int, value: *mut c_int) -> Status =>
            c, |instance| instance.status(kind, TERMINATED, result(value)?, |_| 0);
        fmi2GetStringStatus(c: Component, kind: c_int, value: *mut *const c_char) -> Status =>
            c, |instance| instance.status(kind, NONE, &mut MaybeUninit::uninit(), |_| ());

        // Model exchange: hosts may look up all functions.
        fmi2EnterEventMode(c: Component) -> Status => c, co_simulation_only;
        fmi2NewDiscreteStates(c: Component, event_info: *mut c_void) -> Status => c, co_simulation_only;
        fmi2EnterContinuousTimeMode(c: Component) -> Status => c, co_simulation_only;
        fmi2CompletedIntegratorStep(
            c: Component, no_set_fmu_state_prior_to_current_point: c_int, enter_event_mode: *mut c_int,
            terminate_simulation: *mut c_int
        ) -> Status => c, co_simulation_only;
        fmi2SetTime(c: Component, time: f64) -> Status => c, co_simulation_only;
        fmi2SetContinuousStates(c: Component, x: *const f64, nx: usize) -> Status => c, co_simulation_only;
        fmi2GetDerivatives(c: Component, derivatives: *mut f64, nx: usize) -> Status => c, co_simulation_only;
        fmi2GetEventIndicators(c: Component, event_indicators: *mut f64, ni: usize) -> Status =>
            c, co_simulation_only;
        fmi2GetContinuousStates(c: Component, x: *mut f64, nx: usize) -> Status => c, co_simulation_only;
        fmi2GetNominalsOfContinuousStates(c: Component, x_nominal: *mut f64, nx: usize) -> Status =>
            c, co_simulation_only;
    } };
}

fmi2_functions!([define]);

/// Exports the 44 C functions of FMI 2.0 for the given [`Unit`](crate::Unit).
///
/// To be called once in a library, in a module of its own that allows `unsafe` code and the
/// standard's names; [`export!`](crate::export) does so for both versions.
#[macro_export]
macro_rules! export_fmi2 {
    ($unit:ty) => {
        use $crate::libc::{c_char, c_int, c_uint, c_void};

        use $crate::fmi2::{CallbackFunctions, Component, FmuState};
        use $crate::log::Status;

        $crate::fmi2_functions! { [$crate::__export_for] fmi2 $unit; }
    };
}
