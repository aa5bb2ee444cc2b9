//! The steady state about which a model is linear, and the loads that hold it.

use super::STEADY;
use crate::pulley::Pulley;
use crate::solver::arrow::{Arrow, ArrowLu, Singular};
use crate::solver::{State, System};
use crate::variator::diagnostics::belt::BeltDiagnostics;
use crate::variator::pulleys::loads::Loads;
use crate::variator::run::tuning::STANDSTILL;
use crate::variator::run::{InitialisationError, Variator};
use crate::variator::settings::{Axial, Drive, Inputs, Outputs, ParameterError, Parameters, StartState};
use crate::variator::system::VariatorSystem;

/// Why there is no linear model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LinearError {
    /// A parameter is out of its range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// There is no state to start from.
    #[error(transparent)]
    Start(#[from] InitialisationError),
    /// The state is not steady.
    #[error("this is not a steady working point: {0}")]
    Unsteady(String),
    /// The eigenvalues were not found, or right and left ones differ because they are too close to
    /// each other.
    #[error("the eigenvalues were not found: slow modes are too close to each other")]
    Eigenvalues,
    /// No eigenvalue is below the frequency.
    #[error("no mode is slower than {0} Hz")]
    NoMode(f64),
}

/// A steady state, and the system under the loads that hold it, which do not change with time.
pub(super) struct WorkingPoint {
    pub system: VariatorSystem,
    pub state: State,
    /// Specified inputs.
    pub given: Inputs,
    /// Inputs that hold the state.
    pub inputs: Inputs,
    pub outputs: Box<Outputs>,
}

impl WorkingPoint {
    /// The steady state at the initial ratio and speed.
    pub fn new(parameters: &Parameters, inputs: &Inputs) -> Result<Self, LinearError> {
        let mut parameters = parameters.clone();
        parameters.initial.steady = true;
        let mut variator = Variator::new(parameters)?;
        refuse_unsteady(&variator)?;
        variator.initialise(0.0, inputs)?;
        if variator.outputs().start_state != StartState::Steady {
            let warning = variator.take_messages().into_iter().find(|message| message.warning);
            let why = warning.map_or_else(|| STANDS_STILL.to_string(), |warning| warning.text);
            return Err(LinearError::Unsteady(why));
        }
        Self::find(&mut variator, inputs)
    }

    /// The present state of `variator`, under `inputs`.
    pub fn find(variator: &mut Variator, inputs: &Inputs) -> Result<Self, LinearError> {
        refuse_unsteady(variator)?;
        let (mut system, mut state) = (variator.system().clone(), variator.state().clone());
        if system.friction_velocity != system.parameters.friction.velocity {
            let why = "the run has just started without load, and friction is still soft";
            return Err(LinearError::Unsteady(why.to_string()));
        }
        if system.belt.shaft_speeds(state.view()).primary.abs() <= STANDSTILL {
            return Err(LinearError::Unsteady(STANDS_STILL.to_string()));
        }
        refuse_change(state.y[system.belt.layout.theta()])?;
        state.y_dot.fill(0.0);
        let held = hold(&mut system, &state, inputs)?;
        Ok(Self {
            system,
            state,
            given: *inputs,
            inputs: held,
            outputs: Box::new(variator.outputs().clone()),
        })
    }
}

const STANDS_STILL: &str = "the primary pulley stands still";

fn refuse_unsteady(variator: &Variator) -> Result<(), LinearError> {
    let belt = &variator.system().belt;
    if belt.material_mesh.is_none() {
        return Ok(());
    }
    let why = format!("the ring model {} has no steady state; ALE has one", belt.ring.name());
    Err(LinearError::Unsteady(why))
}

/// Refuses a state in which Θ changes at `rate`, 1/s.
fn refuse_change(rate: f64) -> Result<(), LinearError> {
    if rate.abs() <= STEADY {
        return Ok(());
    }
    let why = format!("the ratio coordinate Θ changes by {:.1e} per second", rate.abs());
    Err(LinearError::Unsteady(why))
}

/// Sets the loads that hold the state. Returns them as inputs.
fn hold(system: &mut VariatorSystem, state: &State, inputs: &Inputs) -> Result<Inputs, LinearError> {
    let mut held = *inputs;
    let sums = BeltDiagnostics::new(system, state.view()).sums;
    for (j, values) in [
        (Pulley::Primary, &mut held.primary),
        (Pulley::Secondary, &mut held.secondary),
    ] {
        let pulley = system.parameters.pulley(j);
        if pulley.axial == Axial::Force {
            let force = system.pulleys().holding_force(j, state.view(), sums.axial[j]);
            if pulley.cylinder.area > 0.0 {
                values.pressure = (force - values.clamping_force) / pulley.cylinder.area;
            } else {
                values.clamping_force = force;
            }
        }
        match pulley.drive {
            Drive::Torque => values.torque = -sums.shaft_torque[j],
            Drive::Speed => values.speed_setpoint = state.y[system.belt.layout.shaft_speed(j)],
        }
    }
    system.loads = Loads::held(&held);
    refuse_change(change_of_theta(system, state)?)?;
    Ok(held)
}

/// Change of Θ that Newton's method would make over a second.
fn change_of_theta(system: &mut VariatorSystem, state: &State) -> Result<f64, LinearError> {
    let mut residual = vec![0.0; system.belt.layout.len()];
    system.residual(0.0, state.view(), &mut residual);
    let mut matrix = Arrow::new(system.shape());
    system.jacobian(0.0, state.view(), 1.0, 1.0, &mut matrix);
    let mut factors = ArrowLu::new(system.shape());
    let singular = |error: Singular| LinearError::Unsteady(error.to_string());
    factors.factor(&matrix).map_err(singular)?;
    factors.solve(&mut residual);
    Ok(residual[system.belt.layout.theta()])
}
