//! Why functions are not supported: model exchange, scheduled execution, structural parameters, discrete states, derivatives with
//! respect to inputs.

pub const CO_SIMULATION: &str = "this FMU is for co-simulation only";
pub const STRUCTURE: &str = "there are no structural parameters";
pub const DISCRETE_STATES: &str = "there are no discrete states (providesEvaluateDiscreteStates is false)";
pub const DIRECTIONAL: &str = "no output depends directly on an input, so every such derivative would be zero \
                               (providesDirectionalDerivatives is false)";
pub const ADJOINT: &str = "no output depends directly on an input, so every such derivative would be zero \
                           (providesAdjointDerivatives is false)";
pub const DEPENDENCIES: &str = "the model description lists the dependencies (providesPerElementDependencies is false)";
