//! Why there is no steady state to start from.

use crate::pulley::Pulley;
use crate::solver::continuation::Settled;
use crate::variator::run::at_rest::Unsettled;
use crate::variator::settings::capacity::Demand;

/// Why there is no steady state to start from.
#[derive(Debug, thiserror::Error)]
pub(super) enum NoSteadyState {
    /// The force on a pulley, with the name of its variable, N, does not clamp the belt.
    #[error("no steady state without a clamping force ({}.{} = {} N)", .0.name(), .1, .2)]
    Unclamped(Pulley, &'static str, f64),
    /// A small share of the torques is beyond capacity.
    #[error("no steady state: {0}")]
    Beyond(Demand),
    /// No belt bears the speed, for this reason.
    #[error("no steady state: {0}")]
    TooFast(String),
    /// The search has ended without a result.
    #[error(
        "no steady state was found (pseudo-time step {:.1e} s after {} solves){}",
        .0.step, .0.solves, .1.map(|demand| format!(": {demand}")).unwrap_or_default()
    )]
    NotFound(Settled, Option<Demand>),
    /// The belt was not brought to rest.
    #[error("the belt was not brought to rest: {0}")]
    NotStopped(Unsettled),
}
