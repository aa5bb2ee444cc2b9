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
    CO_SIMULATION_ONLY, NULL_RESULT, array, array_mut, co_simulation_only, enter, no_direct_derivatives,
    set_debug_logging, unsupported,
};
use crate::c::{define, stored};
use crate::instance::{FmuInstance, Type, refused};
use crate::log::Status;
use crate::state::{Call, State};
use crate::unit::{Experiment, Unit};

/// Why functions are not supported.
const STRUCTURE: &str = "there are no structural parameters";
const DISCRETE_STATES: &str = "there are no discrete states (providesEvaluateDiscreteStates is false)";
const DEPENDENCIES: &str =
    "the model description lists the dependencies (providesPerElementDependencies is false)";

/// Passes the 75 C functions of FMI 3.0 to another macro, after its own arguments. States are
/// stored on request only, so `noSetFMUStatePriorToCurrentPoint` of `fmi3DoStep` has no effect.
#[doc(hidden)]
#[macro_export]
macro_rules! fmi3_functions {
    ([$($then:tt)*] $($own:tt)*) => { $crate::fmi3_functions! { @ [$($then)*] [$($own)*]
        // Functions that read and write variables of a type, with the type of the table, or with its
        // name where no variable has it.
        fmi3GetFloat32 fmi3SetFloat32 f32 without "32-bit real";
        fmi3GetFloat64 fmi3SetFloat64 f64 = Real;
        fmi3GetInt8 fmi3SetInt8 i8 without "8-bit whole number";
        fmi3GetUInt8 fmi3SetUInt8 u8 without "8-bit natural number";
        fmi3GetInt16 fmi3SetInt16 i16 without "16-bit whole number";
        fmi3GetUInt16 fmi3SetUInt16 u16 without "16-bit natural number";
        fmi3GetInt32 fmi3SetInt32 i32 = Integer;
        fmi3GetUInt32 fmi3SetUInt32 u32 without "32-bit natural number";
        fmi3GetInt64 fmi3SetInt64 i64 = Enumeration;
        fmi3GetUInt64 fmi3SetUInt64 u64 without "64-bit natural number";
        fmi3GetBoolean fmi3SetBoolean Boolean = Boolean;
        fmi3GetString fmi3SetString Text without "string";
    } };
    (
        @ [$($then:tt)*] [$($own:tt)*]
        $($get:ident $set:ident $type:ident $(= $of:ident)? $(without $none:literal)?;)*
    ) => { $($then)* ! { $($own)*
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
        $(
            $get(c: Instance, vr: *const Reference, nvr: usize, values: *mut $type, n_values: usize) -> Status =>
                c, |instance| $(instance.no_such_type(Call::Get, array(vr, nvr)?, $none))?
                    $(instance.get(Type::$of, array(vr, nvr)?, array_mut(values, n_values)?))?;
        )*
        fmi3GetBinary(
            c: Instance, vr: *const Reference, nvr: usize, value_sizes: *mut usize, values: *mut Binary, n_values: usize
        ) -> Status => c, |instance| instance.no_such_type(Call::Get, array(vr, nvr)?, "binary");
        fmi3GetClock(c: Instance, vr: *const Reference, nvr: usize, values: *mut Boolean) -> Status =>
            c, |instance| instance.no_such_type(Call::Get, array(vr, nvr)?, "clock");
        $(
            $set(c: Instance, vr: *const Reference, nvr: usize, values: *const $type, n_values: usize) -> Status =>
                c, |instance| $(instance.no_such_type(Call::Set, array(vr, nvr)?, $none))?
                    $(instance.set(Type::$of, array(vr, nvr)?, array(values, n_values)?))?;
        )*
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
        ) -> Status => c, |_| no_direct_derivatives("providesDirectionalDerivatives");
        fmi3GetAdjointDerivative(
            c: Instance, unknowns: *const Reference, n_unknowns: usize, knowns: *const Reference, n_knowns: usize,
            seed: *const f64, n_seed: usize, sensitivity: *mut f64, n_sensitivity: usize
        ) -> Status => c, |_| no_direct_derivatives("providesAdjointDerivatives");
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
        fmi3EnterContinuousTimeMode(c: Instance) -> Status => c, co_simulation_only;
        fmi3CompletedIntegratorStep(
            c: Instance, no_set_fmu_state_prior_to_current_point: Boolean, enter_event_mode: *mut Boolean,
            terminate_simulation: *mut Boolean
        ) -> Status => c, co_simulation_only;
        fmi3SetTime(c: Instance, time: f64) -> Status => c, co_simulation_only;
        fmi3SetContinuousStates(c: Instance, continuous_states: *const f64, n_continuous_states: usize) -> Status =>
            c, co_simulation_only;
        fmi3GetContinuousStateDerivatives(c: Instance, derivatives: *mut f64, n_continuous_states: usize) -> Status =>
            c, co_simulation_only;
        fmi3GetEventIndicators(c: Instance, event_indicators: *mut f64, n_event_indicators: usize) -> Status =>
            c, co_simulation_only;
        fmi3GetContinuousStates(c: Instance, continuous_states: *mut f64, n_continuous_states: usize) -> Status =>
            c, co_simulation_only;
        fmi3GetNominalsOfContinuousStates(c: Instance, nominals: *mut f64, n_continuous_states: usize) -> Status =>
            c, co_simulation_only;
        fmi3GetNumberOfEventIndicators(c: Instance, n_event_indicators: *mut usize) -> Status =>
            c, co_simulation_only;
        fmi3GetNumberOfContinuousStates(c: Instance, n_continuous_states: *mut usize) -> Status =>
            c, co_simulation_only;
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
            c, co_simulation_only;
    } };
}

fmi3_functions!([define]);
