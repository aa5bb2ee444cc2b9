//! The names under which a shared library exports the functions for one unit.

/// Exports the 34 C functions of FMI 2.0 for co-simulation, for the given [`Unit`](crate::Unit).
///
/// To be called once in a library, in a module of its own that allows `unsafe` code and the standard's names.
#[macro_export]
macro_rules! export_fmi2 {
    ($unit:ty) => {
        use libc::{c_char, c_int, c_uint, size_t};

        use $crate::fmi2::{CallbackFunctions, Component, FmuState};
        use $crate::log::Status;

        /// Sizes of the types of the interface.
        #[cfg_attr(not(test), unsafe(no_mangle))]
        pub extern "C" fn fmi2GetTypesPlatform() -> *const c_char {
            c"default".as_ptr()
        }

        /// Version of the standard.
        #[cfg_attr(not(test), unsafe(no_mangle))]
        pub extern "C" fn fmi2GetVersion() -> *const c_char {
            c"2.0".as_ptr()
        }

        $crate::__forward_fmi2! {
            $unit:
            fmi2SetDebugLogging = setup::set_debug_logging(
                c: Component, logging_on: c_int, n_categories: size_t, categories: *const *const c_char
            ) -> Status;
            fmi2Instantiate = creation::instantiate(
                instance_name: *const c_char, fmu_type: c_int, guid: *const c_char, resource_location: *const c_char,
                functions: *const CallbackFunctions, visible: c_int, logging_on: c_int
            ) -> Component;
            fmi2FreeInstance = creation::free_instance(c: Component);
            fmi2SetupExperiment = setup::setup_experiment(
                c: Component, tolerance_defined: c_int, tolerance: f64, start_time: f64, stop_time_defined: c_int,
                stop_time: f64
            ) -> Status;
            fmi2EnterInitializationMode = setup::enter_initialization_mode(c: Component) -> Status;
            fmi2ExitInitializationMode = setup::exit_initialization_mode(c: Component) -> Status;
            fmi2Terminate = setup::terminate(c: Component) -> Status;
            fmi2Reset = setup::reset(c: Component) -> Status;
            fmi2GetReal = values::get_real(c: Component, vr: *const c_uint, nvr: size_t, value: *mut f64) -> Status;
            fmi2GetInteger = values::get_integer(
                c: Component, vr: *const c_uint, nvr: size_t, value: *mut c_int
            ) -> Status;
            fmi2GetBoolean = values::get_boolean(
                c: Component, vr: *const c_uint, nvr: size_t, value: *mut c_int
            ) -> Status;
            fmi2GetString = values::get_string(
                c: Component, vr: *const c_uint, nvr: size_t, value: *mut *const c_char
            ) -> Status;
            fmi2SetReal = values::set_real(c: Component, vr: *const c_uint, nvr: size_t, value: *const f64) -> Status;
            fmi2SetInteger = values::set_integer(
                c: Component, vr: *const c_uint, nvr: size_t, value: *const c_int
            ) -> Status;
            fmi2SetBoolean = values::set_boolean(
                c: Component, vr: *const c_uint, nvr: size_t, value: *const c_int
            ) -> Status;
            fmi2SetString = values::set_string(
                c: Component, vr: *const c_uint, nvr: size_t, value: *const *const c_char
            ) -> Status;
            fmi2GetFMUstate = states::get_fmu_state(c: Component, state: *mut FmuState) -> Status;
            fmi2SetFMUstate = states::set_fmu_state(c: Component, state: FmuState) -> Status;
            fmi2FreeFMUstate = states::free_fmu_state(c: Component, state: *mut FmuState) -> Status;
            fmi2SerializedFMUstateSize = states::serialized_fmu_state_size(
                c: Component, state: FmuState, size: *mut size_t
            ) -> Status;
            fmi2SerializeFMUstate = states::serialize_fmu_state(
                c: Component, state: FmuState, bytes: *mut c_char, size: size_t
            ) -> Status;
            fmi2DeSerializeFMUstate = states::deserialize_fmu_state(
                c: Component, bytes: *const c_char, size: size_t, state: *mut FmuState
            ) -> Status;
            fmi2GetDirectionalDerivative = derivatives::get_directional_derivative(
                c: Component, unknown: *const c_uint, n_unknown: size_t, known: *const c_uint, n_known: size_t,
                dv_known: *const f64, dv_unknown: *mut f64
            ) -> Status;
            fmi2SetRealInputDerivatives = derivatives::set_real_input_derivatives(
                c: Component, vr: *const c_uint, nvr: size_t, order: *const c_int, value: *const f64
            ) -> Status;
            fmi2GetRealOutputDerivatives = derivatives::get_real_output_derivatives(
                c: Component, vr: *const c_uint, nvr: size_t, order: *const c_int, value: *mut f64
            ) -> Status;
            fmi2DoStep = steps::do_step(
                c: Component, current_communication_point: f64, communication_step_size: f64,
                no_set_fmu_state_prior_to_current_point: c_int
            ) -> Status;
            fmi2CancelStep = steps::cancel_step(c: Component) -> Status;
            fmi2GetStatus = steps::get_status(c: Component, kind: c_int, value: *mut c_int) -> Status;
            fmi2GetRealStatus = steps::get_real_status(c: Component, kind: c_int, value: *mut f64) -> Status;
            fmi2GetIntegerStatus = steps::get_integer_status(c: Component, kind: c_int, value: *mut c_int) -> Status;
            fmi2GetBooleanStatus = steps::get_boolean_status(c: Component, kind: c_int, value: *mut c_int) -> Status;
            fmi2GetStringStatus = steps::get_string_status(
                c: Component, kind: c_int, value: *mut *const c_char
            ) -> Status;
        }
    };
}

/// Defines each exported function by the generic one that does its work.
#[doc(hidden)]
#[macro_export]
macro_rules! __forward_fmi2 {
    (
        $unit:ty:
        $($name:ident = $file:ident::$body:ident($($argument:ident: $type:ty),* $(,)?) $(-> $result:ty)?;)*
    ) => {$(
        /// The standard's function of this name.
        ///
        /// # Safety
        /// The caller grants what [`c_abi`](crate::fmi2) lists.
        #[cfg_attr(not(test), unsafe(no_mangle))]
        pub unsafe extern "C" fn $name($($argument: $type),*) $(-> $result)? {
            // SAFETY: the caller grants what the function that is called asks for.
            unsafe { $crate::fmi2::$file::$body::<$unit>($($argument),*) }
        }
    )*};
}
