//! Functions of what this FMU is not or has not: model exchange, scheduled execution, structural parameters, discrete states,
//! derivatives by inputs. Each answers with an error and says why.

use libc::{c_int, size_t};

use super::boundary::with;
use super::types::{Boolean, Instance, Reference};
use crate::log::Status;
use crate::stepping::OwnSteps;

const CO_SIMULATION: &str = "this FMU is for co-simulation only";
const STRUCTURE: &str = "there are no structural parameters";
const DISCRETE_STATES: &str = "there are no discrete states (providesEvaluateDiscreteStates is false)";
const DIRECTIONAL: &str = "no output depends directly on an input, so every such derivative would be zero \
                           (providesDirectionalDerivatives is false)";
const ADJOINT: &str = "no output depends directly on an input, so every such derivative would be zero \
                       (providesAdjointDerivatives is false)";
const DEPENDENCIES: &str = "the model description says what depends on what (providesPerElementDependencies is false)";

macro_rules! refused {
    ($($name:ident, $function:literal, $why:ident, ($($argument:ident: $type:ty),*);)*) => {$(
        #[doc = concat!("`", $function, "`: not offered.")]
        ///
        /// # Safety
        /// The caller grants what [the head of this room](super) lists.
        #[allow(clippy::too_many_arguments, reason = "the standard's")]
        pub unsafe fn $name<U: OwnSteps>(c: Instance, $($argument: $type),*) -> Status {
            // SAFETY: as the caller grants.
            unsafe { with::<U>(c, $function, |instance| instance.slave.not_offered($function, $why)) }
        }
    )*};
}

refused! {
    enter_configuration_mode, "fmi3EnterConfigurationMode", STRUCTURE, ();
    exit_configuration_mode, "fmi3ExitConfigurationMode", STRUCTURE, ();
    evaluate_discrete_states, "fmi3EvaluateDiscreteStates", DISCRETE_STATES, ();
    enter_continuous_time_mode, "fmi3EnterContinuousTimeMode", CO_SIMULATION, ();
    completed_integrator_step, "fmi3CompletedIntegratorStep", CO_SIMULATION,
        (_no_set: Boolean, _enter_event_mode: *mut Boolean, _terminate: *mut Boolean);
    set_time, "fmi3SetTime", CO_SIMULATION, (_time: f64);
    set_continuous_states, "fmi3SetContinuousStates", CO_SIMULATION, (_states: *const f64, _n: size_t);
    get_continuous_state_derivatives, "fmi3GetContinuousStateDerivatives", CO_SIMULATION,
        (_derivatives: *mut f64, _n: size_t);
    get_event_indicators, "fmi3GetEventIndicators", CO_SIMULATION, (_indicators: *mut f64, _n: size_t);
    get_continuous_states, "fmi3GetContinuousStates", CO_SIMULATION, (_states: *mut f64, _n: size_t);
    get_nominals_of_continuous_states, "fmi3GetNominalsOfContinuousStates", CO_SIMULATION,
        (_nominals: *mut f64, _n: size_t);
    get_number_of_event_indicators, "fmi3GetNumberOfEventIndicators", CO_SIMULATION, (_n: *mut size_t);
    get_number_of_continuous_states, "fmi3GetNumberOfContinuousStates", CO_SIMULATION, (_n: *mut size_t);
    activate_model_partition, "fmi3ActivateModelPartition", CO_SIMULATION, (_clock: Reference, _time: f64);
    get_directional_derivative, "fmi3GetDirectionalDerivative", DIRECTIONAL,
        (_unknowns: *const Reference, _n_unknowns: size_t, _knowns: *const Reference, _n_knowns: size_t,
         _seed: *const f64, _n_seed: size_t, _sensitivity: *mut f64, _n_sensitivity: size_t);
    get_adjoint_derivative, "fmi3GetAdjointDerivative", ADJOINT,
        (_unknowns: *const Reference, _n_unknowns: size_t, _knowns: *const Reference, _n_knowns: size_t,
         _seed: *const f64, _n_seed: size_t, _sensitivity: *mut f64, _n_sensitivity: size_t);
    get_number_of_variable_dependencies, "fmi3GetNumberOfVariableDependencies", DEPENDENCIES,
        (_dependent: Reference, _n_dependencies: *mut size_t);
    get_variable_dependencies, "fmi3GetVariableDependencies", DEPENDENCIES,
        (_dependent: Reference, _element_indices_of_dependent: *mut size_t, _independents: *mut Reference,
         _element_indices_of_independents: *mut size_t, _dependency_kinds: *mut c_int, _n_dependencies: size_t);
}
