//! The state before a communication step, to which a step that can't be done goes back.

use crate::contact::Friction;
use crate::pulley::PerPulley;
use crate::solver::State;
use crate::variator::pulleys::loads::Loads;
use crate::variator::run::inputs::InputSegment;
use crate::variator::run::plant::Plant;
use crate::variator::run::variator::Variator;

/// A plant's state, loads and energies, and the external torques. Its memory is allocated once.
#[derive(Clone, Debug)]
pub(super) struct Checkpoint {
    state: State,
    time: f64,
    inputs: InputSegment,
    loads: Loads,
    friction: Friction,
    friction_velocity: f64,
    /// Supplied, lost and moved, J.
    energies: [f64; 3],
    external_torque: PerPulley<f64>,
}

impl Checkpoint {
    /// Memory for the states of a plant.
    pub fn new(plant: &Plant) -> Self {
        let Plant {
            system, energy, state, ..
        } = plant;
        Self {
            state: State::zero(state.y.len()),
            time: plant.time,
            inputs: plant.inputs,
            loads: system.loads,
            friction: system.parameters.friction.clone(),
            friction_velocity: system.friction_velocity,
            energies: [energy.supplied, energy.lost, energy.moved],
            external_torque: PerPulley::default(),
        }
    }
}

impl Variator {
    /// Stores the present state.
    pub(super) fn save_checkpoint(&mut self) {
        let Self { plant, checkpoint, .. } = self;
        let Plant {
            system, energy, state, ..
        } = plant;
        checkpoint.state.copy_from(state);
        checkpoint.time = plant.time;
        checkpoint.inputs = plant.inputs;
        checkpoint.loads = system.loads;
        checkpoint.friction.clone_from(&system.parameters.friction);
        checkpoint.friction_velocity = system.friction_velocity;
        checkpoint.energies = [energy.supplied, energy.lost, energy.moved];
        checkpoint.external_torque = self.external_torque;
    }

    /// Goes back to the state that was stored last. Outputs have the same bits as there. What the solver reuses from step to step is left
    /// out, and the work done since then remains counted.
    pub(super) fn roll_back(&mut self) {
        let Self { plant, checkpoint, .. } = self;
        let Plant {
            system, energy, state, ..
        } = plant;
        state.copy_from(&checkpoint.state);
        plant.time = checkpoint.time;
        plant.inputs = checkpoint.inputs;
        system.loads = checkpoint.loads;
        system.parameters.friction.clone_from(&checkpoint.friction);
        system.friction_velocity = checkpoint.friction_velocity;
        system.forget_derivatives();
        [energy.supplied, energy.lost, energy.moved] = checkpoint.energies;
        energy.last.update(system, state.view());
        self.external_torque = checkpoint.external_torque;
        self.stepper.start_again(&self.plant);
        self.stale = true;
    }
}
