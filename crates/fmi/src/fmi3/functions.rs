//! The C functions of FMI 3.0: signatures (`fmi3FunctionTypes.h`) and bodies.

use libc::{c_char, c_int, c_void};
use std::ptr::null_mut;

use super::creation::{Callbacks, Modes, instantiate, processor_suffices, refuse_instance};
use super::steps::{Results, do_step};
use super::{
    Binary, Boolean, Environment, FmuState, Instance, IntermediateUpdate, LogMessage, Reference, Text,
};
use crate::c::creation::{Texts, free_instance};
use crate::c::entry::{
    CO_SIMULATION_ONLY, NULL_RESULT, array, array_mut, enter, set_debug_logging, unsupported,
};
use crate::c::{define, stored};
use crate::instance::{FmuInstance, Type, refused};
use crate::log::Status;
use crate::state::{Call, State};
use crate::unit::{Experiment, Unit};

/// Why functions are not supported.
const STRUCTURE: &str = "there are no structural parameters";
const DISCRETE_STATES: &str = "there are no discrete states (providesEvaluateDiscreteStates is false)";
const DIRECTIONAL: &str = "no output depends directly on an input, so every such derivative would be zero \
                               (providesDirectionalDerivatives is false)";
const ADJOINT: &str = "no output depends directly on an input, so every such derivative would be zero \
                           (providesAdjointDerivatives is false)";
const DEPENDENCIES: &str =
    "the model description lists the dependencies (providesPerElementDependencies is false)";

/// Passes the 75 C functions of FMI 3.0 to another macro, after its own arguments. States are
/// stored on request only, so `noSetFMUStatePriorToCurrentPoint` of `fmi3DoStep` has no effect.
#[doc(hidden)]
#[macro_export]
macro_rules! fmi3_functions {
    ([$($then:tt)*] $($own:tt)*) => { $($then)* ! { $($own)*
        fmi3GetVersion() -> *const c_char = c"3.0".as_ptr();
        fmi3SetDebugLogging(c: Instance, logging_on: Boolean, n_categories: usize, categories: *const Text) -> Status =>
            c, |instance| set_debug_logging(instance, logging_on != 0, categories, n_categories);
        fmi3InstantiateModelExchange(
            instance_name: Text, instantiation_token: Text, resource_path: Text, visible: Boolean, logging_on: Boolean,
            environment: Environment, log_message: Option<LogMessage>
        ) -> Instance = refuse_instance(FUNCTION, CO_SIMULATION_ONLY, environment, log_message);
        fmi3InstantiateCoSimulation(
            instance_name: Text, instantiation_token: Text, resource_path: Text, visible: Boolean, logging_on: Boolean,
            event_mode_used: Boolean, early_return_allowed: Boolean, required_intermediate_variables: *const Reference,
            n_required_intermediate_variables: usize, environment: Environment, log_message: Option<LogMessage>,
            intermediate_update: Option<IntermediateUpdate>
        ) -> Instance, creates = if processor_suffices(environment, log_message) {
            let texts = Texts { name: instance_name, token: instantiation_token, location: resource_path };
            let modes = Modes {
                logging: logging_on != 0, events: event_mode_used != 0, early_return: early_return_allowed != 0,
            };
            let callbacks = Callbacks { environment, log_message, intermediate_update };
            instantiate::<U>(texts, modes, required_intermediate_variables, n_required_intermediate_variables, callbacks)
        } else {
            null_mut()
        };
        fmi3InstantiateScheduledExecution(
            instance_name: Text, instantiation_token: Text, resource_path: Text, visible: Boolean, logging_on: Boolean,
            environment: Environment, log_message: Option<LogMessage>, clock_update: *const c_void,
            lock_preemption: *const c_void, unlock_preemption: *const c_void
        ) -> Instance = refuse_instance(FUNCTION, CO_SIMULATION_ONLY, environment, log_message);
        fmi3FreeInstance(c: Instance), free c = free_instance::<U>(c);
        fmi3EnterInitializationMode(
            c: Instance, tolerance_defined: Boolean, tolerance: f64, start_time: f64, stop_time_defined: Boolean,
            stop_time: f64
        ) -> Status => c, |instance| {
            let tolerance = (tolerance_defined != 0).then_some(tolerance);
            let stop = (stop_time_defined != 0).then_some(stop_time);
            instance.setup_experiment(Experiment { tolerance, start: start_time, stop })?;
            instance.enter(State::Initialisation, Call::EnterInitializationMode)
        };
        fmi3ExitInitializationMode(c: Instance) -> Status => c, FmuInstance::exit_initialization_mode;
        fmi3EnterEventMode(c: Instance) -> Status => c, FmuInstance::enter_event_mode;
        fmi3Terminate(c: Instance) -> Status => c, |instance| instance.enter(State::Terminated, Call::Terminate);
        fmi3Reset(c: Instance) -> Status => c, FmuInstance::reset;
        fmi3GetFloat32(c: Instance, vr: *const Reference, nvr: usize, values: *mut f32, n_values: usize) -> Status =>
            c, |instance| instance.no_such_type(Call::Get, array(vr, nvr)?, "32-bit real");
        fmi3GetFloat64(c: Instance, vr: *const Reference, nvr: usize, values: *mut f64, n_values: usize) -> Status =>
            c, |instance| instance.get(Type::Real, array(vr, nvr)?, array_mut(values, n_values)?);
        fmi3GetInt8(c: Instance, vr: *const Reference, nvr: usize, values: *mut i8, n_values: usize) -> Status =>
            c, |instance| instance.no_such_type(Call::Get, array(vr, nvr)?, "8-bit whole number");
        fmi3GetUInt8(c: Instance, vr: *const Reference, nvr: usize, values: *mut u8, n_values: usize) -> Status =>
            c, |instance| instance.no_such_type(Call::Get, array(vr, nvr)?, "8-bit natural number");
        fmi3GetInt16(c: Instance, vr: *const Reference, nvr: usize, values: *mut i16, n_values: usize) -> Status =>
            c, |instance| instance.no_such_type(Call::Get, array(vr, nvr)?, "16-bit whole number");
        fmi3GetUInt16(c: Instance, vr: *const Reference, nvr: usize, values: *mut u16, n_values: usize) -> Status =>
            c, |instance| instance.no_such_type(Call::Get, array(vr, nvr)?, "16-bit natural number");
        fmi3GetInt32(c: Instance, vr: *const Reference, nvr: usize, values: *mut i32, n_values: usize) -> Status =>
            c, |instance| instance.get(Type::Integer, array(vr, nvr)?, array_mut(values, n_values)?);
        fmi3GetUInt32(c: Instance, vr: *const Reference, nvr: usize, values: *mut u32, n_values: usize) -> Status =>
            c, |instance| instance.no_such_type(Call::Get, array(vr, nvr)?, "32-bit natural number");
        fmi3GetInt64(c: Instance, vr: *const Reference, nvr: usize, values: *mut i64, n_values: usize) -> Status =>
            c, |instance| instance.get(Type::Enumeration, array(vr, nvr)?, array_mut(values, n_values)?);
        fmi3GetUInt64(c: Instance, vr: *const Reference, nvr: usize, values: *mut u64, n_values: usize) -> Status =>
            c, |instance| instance.no_such_type(Call::Get, array(vr, nvr)?, "64-bit natural number");
        fmi3GetBoolean(c: Instance, vr: *const Reference, nvr: usize, values: *mut Boolean, n_values: usize) -> Status =>
            c, |instance| instance.get(Type::Boolean, array(vr, nvr)?, array_mut(values, n_values)?);
        fmi3GetString(c: Instance, vr: *const Reference, nvr: usize, values: *mut Text, n_values: usize) -> Status =>
            c, |instance| instance.no_such_type(Call::Get, array(vr, nvr)?, "string");
        fmi3GetBinary(
            c: Instance, vr: *const Reference, nvr: usize, value_sizes: *mut usize, values: *mut Binary, n_values: usize
        ) -> Status => c, |instance| instance.no_such_type(Call::Get, array(vr, nvr)?, "binary");
        fmi3GetClock(c: Instance, vr: *const Reference, nvr: usize, values: *mut Boolean) -> Status =>
            c, |instance| instance.no_such_type(Call::Get, array(vr, nvr)?, "clock");
        fmi3SetFloat32(c: Instance, vr: *const Reference, nvr: usize, values: *const f32, n_values: usize) -> Status =>
            c, |instance| instance.no_such_type(Call::Set, array(vr, nvr)?, "32-bit real");
        fmi3SetFloat64(c: Instance, vr: *const Reference, nvr: usize, values: *const f64, n_values: usize) -> Status =>
            c, |instance| instance.set(Type::Real, array(vr, nvr)?, array(values, n_values)?);
        fmi3SetInt8(c: Instance, vr: *const Reference, nvr: usize, values: *const i8, n_values: usize) -> Status =>
            c, |instance| instance.no_such_type(Call::Set, array(vr, nvr)?, "8-bit whole number");
        fmi3SetUInt8(c: Instance, vr: *const Reference, nvr: usize, values: *const u8, n_values: usize) -> Status =>
            c, |instance| instance.no_such_type(Call::Set, array(vr, nvr)?, "8-bit natural number");
        fmi3SetInt16(c: Instance, vr: *const Reference, nvr: usize, values: *const i16, n_values: usize) -> Status =>
            c, |instance| instance.no_such_type(Call::Set, array(vr, nvr)?, "16-bit whole number");
        fmi3SetUInt16(c: Instance, vr: *const Reference, nvr: usize, values: *const u16, n_values: usize) -> Status =>
            c, |instance| instance.no_such_type(Call::Set, array(vr, nvr)?, "16-bit natural number");
        fmi3SetInt32(c: Instance, vr: *const Reference, nvr: usize, values: *const i32, n_values: usize) -> Status =>
            c, |instance| instance.set(Type::Integer, array(vr, nvr)?, array(values, n_values)?);
        fmi3SetUInt32(c: Instance, vr: *const Reference, nvr: usize, values: *const u32, n_values: usize) -> Status =>
            c, |instance| instance.no_such_type(Call::Set, array(vr, nvr)?, "32-bit natural number");
        fmi3SetInt64(c: Instance, vr: *const Reference, nvr: usize, values: *const i64, n_values: usize) -> Status =>
            c, |instance| instance.set(Type::Enumeration, array(vr, nvr)?, array(values, n_values)?);
        fmi3SetUInt64(c: Instance, vr: *const Reference, nvr: usize, values: *const u64, n_values: usize) -> Status =>
            c, |instance| instance.no_such_type(Call::Set, array(vr, nvr)?, "64-bit natural number");
        fmi3SetBoolean(c: Instance, vr: *const Reference, nvr: usize, values: *const Boolean, n_values: usize) -> Status =>
            c, |instance| instance.set(Type::Boolean, array(vr, nvr)?, array(values, n_values)?);
        fmi3SetString(c: Instance, vr: *const Reference, nvr: usize, values: *const Text, n_values: usize) -> Status =>
            c, |instance| instance.no_such_type(Call::Set, array(vr, nvr)?, "string");
        fmi3SetBinary(
            c: Instance, vr: *const Reference, nvr: usize, value_sizes: *const usize, values: *const Binary,
            n_values: usize
        ) -> Status => c, |instance| instance.no_such_type(Call::Set, array(vr, nvr)?, "binary");
        fmi3SetClock(c: Instance, vr: *const Reference, nvr: usize, values: *const Boolean) -> Status =>
            c, |instance| instance.no_such_type(Call::Set, array(vr, nvr)?, "clock");
        fmi3GetNumberOfVariableDependencies(c: Instance, value_reference: Reference, n_dependencies: *mut usize) -> Status =>
            c, |_| unsupported(DEPENDENCIES);
        fmi3GetVariableDependencies(
            c: Instance, dependent: Reference, element_indices_of_dependent: *mut usize, independents: *mut Reference,
            element_indices_of_independents: *mut usize, dependency_kinds: *mut c_int, n_dependencies: usize
        ) -> Status => c, |_| unsupported(DEPENDENCIES);
        fmi3GetFMUState(c: Instance, state: *mut FmuState) -> Status => c, |instance| stored::get(instance, state);
        fmi3SetFMUState(c: Instance, state: FmuState) -> Status => c, |instance| stored::set(instance, state);
        fmi3FreeFMUState(c: Instance, state: *mut FmuState) -> Status => c, |instance| stored::free(instance, state);
        fmi3SerializedFMUStateSize(c: Instance, state: FmuState, size: *mut usize) -> Status =>
            c, |instance| stored::size(instance, state, size);
        fmi3SerializeFMUState(c: Instance, state: FmuState, bytes: *mut u8, size: usize) -> Status =>
            c, |instance| stored::serialize(instance, state, bytes, size);
        fmi3DeserializeFMUState(c: Instance, bytes: *const u8, size: usize, state: *mut FmuState) -> Status =>
            c, |instance| stored::deserialize(instance, bytes, size, state);
        fmi3GetDirectionalDerivative(
            c: Instance, unknowns: *const Reference, n_unknowns: usize, knowns: *const Reference, n_knowns: usize,
            seed: *const f64, n_seed: usize, sensitivity: *mut f64, n_sensitivity: usize
        ) -> Status => c, |_| unsupported(DIRECTIONAL);
        fmi3GetAdjointDerivative(
            c: Instance, unknowns: *const Reference, n_unknowns: usize, knowns: *const Reference, n_knowns: usize,
            seed: *const f64, n_seed: usize, sensitivity: *mut f64, n_sensitivity: usize
        ) -> Status => c, |_| unsupported(ADJOINT);
        fmi3EnterConfigurationMode(c: Instance) -> Status => c, |_| unsupported(STRUCTURE);
        fmi3ExitConfigurationMode(c: Instance) -> Status => c, |_| unsupported(STRUCTURE);
        fmi3GetIntervalDecimal(
            c: Instance, vr: *const Reference, nvr: usize, intervals: *mut f64, qualifiers: *mut i32
        ) -> Status => c, |instance| instance.no_such_type(Call::Get, array(vr, nvr)?, "clock");
        fmi3GetIntervalFraction(
            c: Instance, vr: *const Reference, nvr: usize, counters: *mut u64, resolutions: *mut u64, qualifiers: *mut i32
        ) -> Status => c, |instance| instance.no_such_type(Call::Get, array(vr, nvr)?, "clock");
        fmi3GetShiftDecimal(c: Instance, vr: *const Reference, nvr: usize, shifts: *mut f64) -> Status =>
            c, |instance| instance.no_such_type(Call::Get, array(vr, nvr)?, "clock");
        fmi3GetShiftFraction(
            c: Instance, vr: *const Reference, nvr: usize, counters: *mut u64, resolutions: *mut u64
        ) -> Status => c, |instance| instance.no_such_type(Call::Get, array(vr, nvr)?, "clock");
        fmi3SetIntervalDecimal(c: Instance, vr: *const Reference, nvr: usize, intervals: *const f64) -> Status =>
            c, |instance| instance.no_such_type(Call::Set, array(vr, nvr)?, "clock");
        fmi3SetIntervalFraction(
            c: Instance, vr: *const Reference, nvr: usize, counters: *const u64, resolutions: *const u64
        ) -> Status => c, |instance| instance.no_such_type(Call::Set, array(vr, nvr)?, "clock");
        fmi3SetShiftDecimal(c: Instance, vr: *const Reference, nvr: usize, shifts: *const f64) -> Status =>
            c, |instance| instance.no_such_type(Call::Set, array(vr, nvr)?, "clock");
        fmi3SetShiftFraction(
            c: Instance, vr: *const Reference, nvr: usize, counters: *const u64, resolutions: *const u64
        ) -> Status => c, |instance| instance.no_such_type(Call::Set, array(vr, nvr)?, "clock");
        fmi3EvaluateDiscreteStates(c: Instance) -> Status => c, |_| unsupported(DISCRETE_STATES);
        fmi3UpdateDiscreteStates(
            c: Instance, discrete_states_need_update: *mut Boolean, terminate_simulation: *mut Boolean,
            nominals_of_continuous_states_changed: *mut Boolean, values_of_continuous_states_changed: *mut Boolean,
            next_event_time_defined: *mut Boolean, next_event_time: *mut f64
        ) -> Status => c, |instance| {
            let flags = [
                discrete_states_need_update, terminate_simulation, nominals_of_continuous_states_changed,
                values_of_continuous_states_changed, next_event_time_defined,
            ];
            if flags.iter().any(|flag| flag.is_null()) || next_event_time.is_null() {
                return refused(NULL_RESULT);
            }
            // There are no discrete states and no time events.
            instance.allow(Call::HandleEvent)?;
            // Not by references: an importer may pass the same pointer several times.
            flags.into_iter().for_each(|flag| flag.write(0));
            next_event_time.write(0.0);
            Ok(())
        };
        fmi3EnterContinuousTimeMode(c: Instance) -> Status => c, |_| unsupported(CO_SIMULATION_ONLY);
        fmi3CompletedIntegratorStep(
            c: Instance, no_set_fmu_state_prior_to_current_point: Boolean, enter_event_mode: *mut Boolean,
            terminate_simulation: *mut Boolean
        ) -> Status => c, |_| unsupported(CO_SIMULATION_ONLY);
        fmi3SetTime(c: Instance, time: f64) -> Status => c, |_| unsupported(CO_SIMULATION_ONLY);
        fmi3SetContinuousStates(c: Instance, continuous_states: *const f64, n_continuous_states: usize) -> Status =>
            c, |_| unsupported(CO_SIMULATION_ONLY);
        fmi3GetContinuousStateDerivatives(c: Instance, derivatives: *mut f64, n_continuous_states: usize) -> Status =>
            c, |_| unsupported(CO_SIMULATION_ONLY);
        fmi3GetEventIndicators(c: Instance, event_indicators: *mut f64, n_event_indicators: usize) -> Status =>
            c, |_| unsupported(CO_SIMULATION_ONLY);
        fmi3GetContinuousStates(c: Instance, continuous_states: *mut f64, n_continuous_states: usize) -> Status =>
            c, |_| unsupported(CO_SIMULATION_ONLY);
        fmi3GetNominalsOfContinuousStates(c: Instance, nominals: *mut f64, n_continuous_states: usize) -> Status =>
            c, |_| unsupported(CO_SIMULATION_ONLY);
        fmi3GetNumberOfEventIndicators(c: Instance, n_event_indicators: *mut usize) -> Status =>
            c, |_| unsupported(CO_SIMULATION_ONLY);
        fmi3GetNumberOfContinuousStates(c: Instance, n_continuous_states: *mut usize) -> Status =>
            c, |_| unsupported(CO_SIMULATION_ONLY);
        fmi3EnterStepMode(c: Instance) -> Status => c, |instance| instance.enter(State::StepComplete, Call::HandleEvent);
        fmi3GetOutputDerivatives(
            c: Instance, vr: *const Reference, nvr: usize, orders: *const i32, values: *mut f64, n_values: usize
        ) -> Status =>
            c, |instance| instance.get_output_derivatives(array(vr, nvr)?, array(orders, nvr)?, array_mut(values, n_values)?);
        fmi3DoStep(
            c: Instance, current_communication_point: f64, communication_step_size: f64,
            no_set_fmu_state_prior_to_current_point: Boolean, event_handling_needed: *mut Boolean,
            terminate_simulation: *mut Boolean, early_return: *mut Boolean, last_successful_time: *mut f64
        ) -> Status, on c = {
            let results = Results { event_handling_needed, terminate_simulation, early_return, last_successful_time };
            do_step::<U>(c, FUNCTION, current_communication_point, communication_step_size, results)
        };
        fmi3ActivateModelPartition(c: Instance, clock_reference: Reference, activation_time: f64) -> Status =>
            c, |_| unsupported(CO_SIMULATION_ONLY);
    } };
}

fmi3_functions!([define]);
