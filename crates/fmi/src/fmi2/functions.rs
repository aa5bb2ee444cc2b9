//! The C functions of FMI 2.0: signatures (`fmi2FunctionTypes.h`) and bodies.

use libc::{c_char, c_int, c_uint};

use super::creation::instantiate;
use super::types::{CallbackFunctions, Component, FmuState};
use crate::c::creation::free_instance;
use crate::c::entry::{array, array_mut, enter, get, no_such_type, result, set, set_debug_logging, unsupported};
use crate::c::{define, stored};
use crate::log::Status;
use crate::slave::{Slave, Type};
use crate::state::Call;
use crate::unit::{Experiment, Unit};

const DIRECTIONAL: &str = "no output depends directly on an input, so every such derivative would be zero \
                           (providesDirectionalDerivative is false)";

/// Passes the 34 C functions of FMI 2.0 for co-simulation to another macro, after its own arguments.
#[doc(hidden)]
#[macro_export]
macro_rules! fmi2_functions {
    ([$($then:tt)*] $($own:tt)*) => { $($then)* ! { $($own)*
        fmi2GetTypesPlatform() -> *const c_char = c"default".as_ptr();
        fmi2GetVersion() -> *const c_char = c"2.0".as_ptr();
        fmi2SetDebugLogging(
            c: Component, logging_on: c_int, n_categories: usize, categories: *const *const c_char
        ) -> Status = set_debug_logging::<U>(c, FUNCTION, logging_on != 0, (categories, n_categories));
        fmi2Instantiate(
            instance_name: *const c_char, fmu_type: c_int, guid: *const c_char, resource_location: *const c_char,
            functions: *const CallbackFunctions, visible: c_int, logging_on: c_int
        ) -> Component = instantiate::<U>(instance_name, fmu_type, guid, resource_location, functions, logging_on != 0);
        fmi2FreeInstance(c: Component) = free_instance::<U>(c);

        // Set-up, initialisation, end.
        fmi2SetupExperiment(
            c: Component, tolerance_defined: c_int, tolerance: f64, start_time: f64, stop_time_defined: c_int, stop_time: f64
        ) -> Status = {
            let (tolerance, stop) = ((tolerance_defined != 0, tolerance), (stop_time_defined != 0, stop_time));
            let experiment = Experiment::from_arguments(tolerance, start_time, stop);
            enter(c, FUNCTION, |slave: &mut Slave<U>| slave.setup_experiment(experiment))
        };
        fmi2EnterInitializationMode(c: Component) -> Status = enter(c, FUNCTION, Slave::<U>::enter_initialization_mode);
        fmi2ExitInitializationMode(c: Component) -> Status = enter(c, FUNCTION, Slave::<U>::exit_initialization_mode);
        fmi2Terminate(c: Component) -> Status = enter(c, FUNCTION, Slave::<U>::terminate);
        fmi2Reset(c: Component) -> Status = enter(c, FUNCTION, Slave::<U>::reset);

        // Variables.
        fmi2GetReal(c: Component, vr: *const c_uint, nvr: usize, value: *mut f64) -> Status =
            get::<U, _>(c, FUNCTION, Type::Real, (vr, nvr), (value, nvr));
        fmi2GetInteger(c: Component, vr: *const c_uint, nvr: usize, value: *mut c_int) -> Status =
            get::<U, _>(c, FUNCTION, Type::IntegerOrEnumeration, (vr, nvr), (value, nvr));
        fmi2GetBoolean(c: Component, vr: *const c_uint, nvr: usize, value: *mut c_int) -> Status =
            get::<U, _>(c, FUNCTION, Type::Boolean, (vr, nvr), (value, nvr));
        fmi2GetString(c: Component, vr: *const c_uint, nvr: usize, value: *mut *const c_char) -> Status =
            no_such_type::<U>(c, FUNCTION, Call::Get, (vr, nvr), "string");
        fmi2SetReal(c: Component, vr: *const c_uint, nvr: usize, value: *const f64) -> Status =
            set::<U, _>(c, FUNCTION, Type::Real, (vr, nvr), (value, nvr));
        fmi2SetInteger(c: Component, vr: *const c_uint, nvr: usize, value: *const c_int) -> Status =
            set::<U, _>(c, FUNCTION, Type::IntegerOrEnumeration, (vr, nvr), (value, nvr));
        fmi2SetBoolean(c: Component, vr: *const c_uint, nvr: usize, value: *const c_int) -> Status =
            set::<U, _>(c, FUNCTION, Type::Boolean, (vr, nvr), (value, nvr));
        fmi2SetString(c: Component, vr: *const c_uint, nvr: usize, value: *const *const c_char) -> Status =
            no_such_type::<U>(c, FUNCTION, Call::Set, (vr, nvr), "string");

        // Stored states.
        fmi2GetFMUstate(c: Component, state: *mut FmuState) -> Status = stored::get::<U>(c, FUNCTION, state);
        fmi2SetFMUstate(c: Component, state: FmuState) -> Status = stored::set::<U>(c, FUNCTION, state);
        fmi2FreeFMUstate(c: Component, state: *mut FmuState) -> Status = stored::free::<U>(c, FUNCTION, state);
        fmi2SerializedFMUstateSize(c: Component, state: FmuState, size: *mut usize) -> Status =
            stored::size::<U>(c, FUNCTION, state, size);
        fmi2SerializeFMUstate(c: Component, state: FmuState, bytes: *mut c_char, size: usize) -> Status =
            stored::serialize::<U>(c, FUNCTION, state, (bytes.cast(), size));
        fmi2DeSerializeFMUstate(c: Component, bytes: *const c_char, size: usize, state: *mut FmuState) -> Status =
            stored::deserialize::<U>(c, FUNCTION, (bytes.cast(), size), state);

        // Derivatives.
        fmi2GetDirectionalDerivative(
            c: Component, unknown: *const c_uint, n_unknown: usize, known: *const c_uint, n_known: usize,
            dv_known: *const f64, dv_unknown: *mut f64
        ) -> Status = unsupported::<U>(c, FUNCTION, DIRECTIONAL);
        fmi2SetRealInputDerivatives(
            c: Component, vr: *const c_uint, nvr: usize, order: *const c_int, value: *const f64
        ) -> Status = enter(c, FUNCTION, |slave: &mut Slave<U>| {
            slave.set_input_derivatives(array((vr, nvr))?, array((order, nvr))?, array((value, nvr))?)
        });
        fmi2GetRealOutputDerivatives(
            c: Component, vr: *const c_uint, nvr: usize, order: *const c_int, value: *mut f64
        ) -> Status = enter(c, FUNCTION, |slave: &mut Slave<U>| {
            slave.get_output_derivatives(array((vr, nvr))?, array((order, nvr))?, array_mut((value, nvr))?)
        });

        // Communication steps. States are stored on request only, so the last argument of `fmi2DoStep` does not matter.
        fmi2DoStep(
            c: Component, current_communication_point: f64, communication_step_size: f64,
            no_set_fmu_state_prior_to_current_point: c_int
        ) -> Status = enter(c, FUNCTION, |slave: &mut Slave<U>| {
            slave.do_step(current_communication_point, communication_step_size)
        });
        fmi2CancelStep(c: Component) -> Status = enter(c, FUNCTION, Slave::<U>::cancel_step);
        fmi2GetStatus(c: Component, kind: c_int, value: *mut c_int) -> Status =
            enter(c, FUNCTION, |slave: &mut Slave<U>| {
                let value = result(value)?;
                *value = slave.step_status(kind)? as c_int;
                Ok(())
            });
        fmi2GetRealStatus(c: Component, kind: c_int, value: *mut f64) -> Status =
            enter(c, FUNCTION, |slave: &mut Slave<U>| {
                let value = result(value)?;
                *value = slave.last_successful_time(kind)?;
                Ok(())
            });
        fmi2GetIntegerStatus(c: Component, kind: c_int, value: *mut c_int) -> Status =
            enter(c, FUNCTION, |slave: &mut Slave<U>| slave.no_status(kind));
        fmi2GetBooleanStatus(c: Component, kind: c_int, value: *mut c_int) -> Status =
            enter(c, FUNCTION, |slave: &mut Slave<U>| {
                let value = result(value)?;
                *value = slave.requests_termination(kind)?.into();
                Ok(())
            });
        fmi2GetStringStatus(c: Component, kind: c_int, value: *mut *const c_char) -> Status =
            enter(c, FUNCTION, |slave: &mut Slave<U>| slave.no_status(kind));
    } };
}

fmi2_functions!([define]);

/// Exports the 34 C functions of FMI 2.0 for co-simulation, for the given [`Unit`](crate::Unit).
///
/// To be called once in a library, in a module of its own that allows `unsafe` code and the standard's names;
/// [`export!`](crate::export) does so for both versions. A library with a variant for newer processors passes
/// `Some(&Dispatch)` after the unit.
#[macro_export]
macro_rules! export_fmi2 {
    ($unit:ty) => {
        $crate::export_fmi2!($unit, None);
    };
    ($unit:ty, $dispatch:expr) => {
        use $crate::libc::{c_char, c_int, c_uint};

        use $crate::fmi2::{CallbackFunctions, Component, FmuState};
        use $crate::log::Status;

        $crate::fmi2_functions! { [$crate::__export_for] fmi2 $unit, $dispatch; }
    };
}
