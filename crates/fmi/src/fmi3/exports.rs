//! The names under which a shared library exports the functions for one unit.

/// Exports the 75 C functions of FMI 3.0, for the given unit with [its own steps](crate::stepping::OwnSteps).
///
/// To be called once in a library, in a module of its own that allows `unsafe` code and the standard's names.
#[macro_export]
macro_rules! export_fmi3 {
    ($unit:ty) => {
        use libc::{c_char, c_int, c_void, size_t};

        use $crate::fmi3::{
            Binary, Boolean, Environment, FmuState, Instance, IntermediateUpdate, LogMessage, Reference, Text,
        };
        use $crate::log::Status;

        /// Version of the standard.
        #[cfg_attr(not(test), unsafe(no_mangle))]
        pub extern "C" fn fmi3GetVersion() -> *const c_char {
            c"3.0".as_ptr()
        }

        $crate::__forward_fmi3! {
            $unit:
            fmi3SetDebugLogging = setup::set_debug_logging(
                c: Instance, logging_on: Boolean, n_categories: size_t, categories: *const Text
            ) -> Status;
            fmi3InstantiateModelExchange = creation::instantiate_model_exchange(
                instance_name: Text, instantiation_token: Text, resource_path: Text, visible: Boolean,
                logging_on: Boolean, instance_environment: Environment, log_message: Option<LogMessage>
            ) -> Instance;
            fmi3InstantiateCoSimulation = creation::instantiate_co_simulation(
                instance_name: Text, instantiation_token: Text, resource_path: Text, visible: Boolean,
                logging_on: Boolean, event_mode_used: Boolean, early_return_allowed: Boolean,
                required_intermediate_variables: *const Reference, n_required_intermediate_variables: size_t,
                instance_environment: Environment, log_message: Option<LogMessage>,
                intermediate_update: Option<IntermediateUpdate>
            ) -> Instance;
            fmi3InstantiateScheduledExecution = creation::instantiate_scheduled_execution(
                instance_name: Text, instantiation_token: Text, resource_path: Text, visible: Boolean,
                logging_on: Boolean, instance_environment: Environment, log_message: Option<LogMessage>,
                clock_update: *const c_void, lock_preemption: *const c_void, unlock_preemption: *const c_void
            ) -> Instance;
            fmi3FreeInstance = creation::free_instance(c: Instance);
            fmi3EnterInitializationMode = setup::enter_initialization_mode(
                c: Instance, tolerance_defined: Boolean, tolerance: f64, start_time: f64, stop_time_defined: Boolean,
                stop_time: f64
            ) -> Status;
            fmi3ExitInitializationMode = setup::exit_initialization_mode(c: Instance) -> Status;
            fmi3EnterEventMode = setup::enter_event_mode(c: Instance) -> Status;
            fmi3Terminate = setup::terminate(c: Instance) -> Status;
            fmi3Reset = setup::reset(c: Instance) -> Status;
            fmi3GetFloat32 = values::get_float32(
                c: Instance, vr: *const Reference, nvr: size_t, values: *mut f32,
                n_values: size_t
            ) -> Status;
            fmi3GetFloat64 = values::get_float64(
                c: Instance, vr: *const Reference, nvr: size_t, values: *mut f64,
                n_values: size_t
            ) -> Status;
            fmi3GetInt8 = values::get_int8(
                c: Instance, vr: *const Reference, nvr: size_t, values: *mut i8,
                n_values: size_t
            ) -> Status;
            fmi3GetUInt8 = values::get_uint8(
                c: Instance, vr: *const Reference, nvr: size_t, values: *mut u8,
                n_values: size_t
            ) -> Status;
            fmi3GetInt16 = values::get_int16(
                c: Instance, vr: *const Reference, nvr: size_t, values: *mut i16,
                n_values: size_t
            ) -> Status;
            fmi3GetUInt16 = values::get_uint16(
                c: Instance, vr: *const Reference, nvr: size_t, values: *mut u16,
                n_values: size_t
            ) -> Status;
            fmi3GetInt32 = values::get_int32(
                c: Instance, vr: *const Reference, nvr: size_t, values: *mut i32,
                n_values: size_t
            ) -> Status;
            fmi3GetUInt32 = values::get_uint32(
                c: Instance, vr: *const Reference, nvr: size_t, values: *mut u32,
                n_values: size_t
            ) -> Status;
            fmi3GetInt64 = values::get_int64(
                c: Instance, vr: *const Reference, nvr: size_t, values: *mut i64,
                n_values: size_t
            ) -> Status;
            fmi3GetUInt64 = values::get_uint64(
                c: Instance, vr: *const Reference, nvr: size_t, values: *mut u64,
                n_values: size_t
            ) -> Status;
            fmi3GetBoolean = values::get_boolean(
                c: Instance, vr: *const Reference, nvr: size_t, values: *mut Boolean,
                n_values: size_t
            ) -> Status;
            fmi3GetString = values::get_string(
                c: Instance, vr: *const Reference, nvr: size_t, values: *mut Text,
                n_values: size_t
            ) -> Status;
            fmi3GetBinary = values::get_binary(
                c: Instance, vr: *const Reference, nvr: size_t, value_sizes: *mut size_t,
                values: *mut Binary, n_values: size_t
            ) -> Status;
            fmi3GetClock = values::get_clock(
                c: Instance, vr: *const Reference, nvr: size_t, values: *mut Boolean
            ) -> Status;
            fmi3SetFloat32 = values::set_float32(
                c: Instance, vr: *const Reference, nvr: size_t, values: *const f32,
                n_values: size_t
            ) -> Status;
            fmi3SetFloat64 = values::set_float64(
                c: Instance, vr: *const Reference, nvr: size_t, values: *const f64,
                n_values: size_t
            ) -> Status;
            fmi3SetInt8 = values::set_int8(
                c: Instance, vr: *const Reference, nvr: size_t, values: *const i8,
                n_values: size_t
            ) -> Status;
            fmi3SetUInt8 = values::set_uint8(
                c: Instance, vr: *const Reference, nvr: size_t, values: *const u8,
                n_values: size_t
            ) -> Status;
            fmi3SetInt16 = values::set_int16(
                c: Instance, vr: *const Reference, nvr: size_t, values: *const i16,
                n_values: size_t
            ) -> Status;
            fmi3SetUInt16 = values::set_uint16(
                c: Instance, vr: *const Reference, nvr: size_t, values: *const u16,
                n_values: size_t
            ) -> Status;
            fmi3SetInt32 = values::set_int32(
                c: Instance, vr: *const Reference, nvr: size_t, values: *const i32,
                n_values: size_t
            ) -> Status;
            fmi3SetUInt32 = values::set_uint32(
                c: Instance, vr: *const Reference, nvr: size_t, values: *const u32,
                n_values: size_t
            ) -> Status;
            fmi3SetInt64 = values::set_int64(
                c: Instance, vr: *const Reference, nvr: size_t, values: *const i64,
                n_values: size_t
            ) -> Status;
            fmi3SetUInt64 = values::set_uint64(
                c: Instance, vr: *const Reference, nvr: size_t, values: *const u64,
                n_values: size_t
            ) -> Status;
            fmi3SetBoolean = values::set_boolean(
                c: Instance, vr: *const Reference, nvr: size_t, values: *const Boolean,
                n_values: size_t
            ) -> Status;
            fmi3SetString = values::set_string(
                c: Instance, vr: *const Reference, nvr: size_t, values: *const Text,
                n_values: size_t
            ) -> Status;
            fmi3SetBinary = values::set_binary(
                c: Instance, vr: *const Reference, nvr: size_t,
                value_sizes: *const size_t, values: *const Binary, n_values: size_t
            ) -> Status;
            fmi3SetClock = values::set_clock(
                c: Instance, vr: *const Reference, nvr: size_t, values: *const Boolean
            ) -> Status;
            fmi3GetNumberOfVariableDependencies = elsewhere::get_number_of_variable_dependencies(
                c: Instance, value_reference: Reference, n_dependencies: *mut size_t
            ) -> Status;
            fmi3GetVariableDependencies = elsewhere::get_variable_dependencies(
                c: Instance, dependent: Reference, element_indices_of_dependent: *mut size_t,
                independents: *mut Reference, element_indices_of_independents: *mut size_t,
                dependency_kinds: *mut c_int, n_dependencies: size_t
            ) -> Status;
            fmi3GetFMUState = states::get_fmu_state(c: Instance, f_mustate: *mut FmuState) -> Status;
            fmi3SetFMUState = states::set_fmu_state(c: Instance, f_mustate: FmuState) -> Status;
            fmi3FreeFMUState = states::free_fmu_state(c: Instance, f_mustate: *mut FmuState) -> Status;
            fmi3SerializedFMUStateSize = states::serialized_fmu_state_size(
                c: Instance, f_mustate: FmuState, size: *mut size_t
            ) -> Status;
            fmi3SerializeFMUState = states::serialize_fmu_state(
                c: Instance, f_mustate: FmuState, serialized_state: *mut u8, size: size_t
            ) -> Status;
            fmi3DeserializeFMUState = states::deserialize_fmu_state(
                c: Instance, serialized_state: *const u8, size: size_t, f_mustate: *mut FmuState
            ) -> Status;
            fmi3GetDirectionalDerivative = elsewhere::get_directional_derivative(
                c: Instance, unknowns: *const Reference, n_unknowns: size_t, knowns: *const Reference,
                n_knowns: size_t, seed: *const f64, n_seed: size_t, sensitivity: *mut f64, n_sensitivity: size_t
            ) -> Status;
            fmi3GetAdjointDerivative = elsewhere::get_adjoint_derivative(
                c: Instance, unknowns: *const Reference, n_unknowns: size_t, knowns: *const Reference,
                n_knowns: size_t, seed: *const f64, n_seed: size_t, sensitivity: *mut f64, n_sensitivity: size_t
            ) -> Status;
            fmi3EnterConfigurationMode = elsewhere::enter_configuration_mode(c: Instance) -> Status;
            fmi3ExitConfigurationMode = elsewhere::exit_configuration_mode(c: Instance) -> Status;
            fmi3GetIntervalDecimal = values::get_interval_decimal(
                c: Instance, vr: *const Reference, nvr: size_t, intervals: *mut f64,
                qualifiers: *mut i32
            ) -> Status;
            fmi3GetIntervalFraction = values::get_interval_fraction(
                c: Instance, vr: *const Reference, nvr: size_t, counters: *mut u64,
                resolutions: *mut u64, qualifiers: *mut i32
            ) -> Status;
            fmi3GetShiftDecimal = values::get_shift_decimal(
                c: Instance, vr: *const Reference, nvr: size_t, shifts: *mut f64
            ) -> Status;
            fmi3GetShiftFraction = values::get_shift_fraction(
                c: Instance, vr: *const Reference, nvr: size_t, counters: *mut u64,
                resolutions: *mut u64
            ) -> Status;
            fmi3SetIntervalDecimal = values::set_interval_decimal(
                c: Instance, vr: *const Reference, nvr: size_t, intervals: *const f64
            ) -> Status;
            fmi3SetIntervalFraction = values::set_interval_fraction(
                c: Instance, vr: *const Reference, nvr: size_t, counters: *const u64,
                resolutions: *const u64
            ) -> Status;
            fmi3SetShiftDecimal = values::set_shift_decimal(
                c: Instance, vr: *const Reference, nvr: size_t, shifts: *const f64
            ) -> Status;
            fmi3SetShiftFraction = values::set_shift_fraction(
                c: Instance, vr: *const Reference, nvr: size_t, counters: *const u64,
                resolutions: *const u64
            ) -> Status;
            fmi3EvaluateDiscreteStates = elsewhere::evaluate_discrete_states(c: Instance) -> Status;
            fmi3UpdateDiscreteStates = setup::update_discrete_states(
                c: Instance, discrete_states_need_update: *mut Boolean, terminate_simulation: *mut Boolean,
                nominals_of_continuous_states_changed: *mut Boolean, values_of_continuous_states_changed: *mut Boolean,
                next_event_time_defined: *mut Boolean, next_event_time: *mut f64
            ) -> Status;
            fmi3EnterContinuousTimeMode = elsewhere::enter_continuous_time_mode(c: Instance) -> Status;
            fmi3CompletedIntegratorStep = elsewhere::completed_integrator_step(
                c: Instance, no_set_fmu_state_prior_to_current_point: Boolean, enter_event_mode: *mut Boolean,
                terminate_simulation: *mut Boolean
            ) -> Status;
            fmi3SetTime = elsewhere::set_time(c: Instance, time: f64) -> Status;
            fmi3SetContinuousStates = elsewhere::set_continuous_states(
                c: Instance, continuous_states: *const f64, n_continuous_states: size_t
            ) -> Status;
            fmi3GetContinuousStateDerivatives = elsewhere::get_continuous_state_derivatives(
                c: Instance, derivatives: *mut f64, n_continuous_states: size_t
            ) -> Status;
            fmi3GetEventIndicators = elsewhere::get_event_indicators(
                c: Instance, event_indicators: *mut f64, n_event_indicators: size_t
            ) -> Status;
            fmi3GetContinuousStates = elsewhere::get_continuous_states(
                c: Instance, continuous_states: *mut f64, n_continuous_states: size_t
            ) -> Status;
            fmi3GetNominalsOfContinuousStates = elsewhere::get_nominals_of_continuous_states(
                c: Instance, nominals: *mut f64, n_continuous_states: size_t
            ) -> Status;
            fmi3GetNumberOfEventIndicators = elsewhere::get_number_of_event_indicators(
                c: Instance, n_event_indicators: *mut size_t
            ) -> Status;
            fmi3GetNumberOfContinuousStates = elsewhere::get_number_of_continuous_states(
                c: Instance, n_continuous_states: *mut size_t
            ) -> Status;
            fmi3EnterStepMode = setup::enter_step_mode(c: Instance) -> Status;
            fmi3GetOutputDerivatives = derivatives::get_output_derivatives(
                c: Instance, vr: *const Reference, nvr: size_t, orders: *const i32,
                values: *mut f64, n_values: size_t
            ) -> Status;
            fmi3DoStep = steps::do_step(
                c: Instance, current_communication_point: f64, communication_step_size: f64,
                no_set_fmu_state_prior_to_current_point: Boolean, event_handling_needed: *mut Boolean,
                terminate_simulation: *mut Boolean, early_return: *mut Boolean, last_successful_time: *mut f64
            ) -> Status;
            fmi3ActivateModelPartition = elsewhere::activate_model_partition(
                c: Instance, clock_reference: Reference, activation_time: f64
            ) -> Status;
        }
    };
}

/// Defines each exported function by the generic one that does its work.
#[doc(hidden)]
#[macro_export]
macro_rules! __forward_fmi3 {
    (
        $unit:ty:
        $($name:ident = $file:ident::$body:ident($($argument:ident: $type:ty),* $(,)?) $(-> $result:ty)?;)*
    ) => {$(
        /// The standard's function of this name.
        ///
        /// # Safety
        /// The caller grants what [the room of these functions](crate::fmi3) lists.
        #[allow(clippy::too_many_arguments, reason = "the standard's")]
        #[cfg_attr(not(test), unsafe(no_mangle))]
        pub unsafe extern "C" fn $name($($argument: $type),*) $(-> $result)? {
            // SAFETY: the caller grants what the function that is called asks for.
            unsafe { $crate::fmi3::$file::$body::<$unit>($($argument),*) }
        }
    )*};
}
