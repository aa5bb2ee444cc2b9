//! The state before a communication step, to which a step that can't be done goes back.

use crate::contact::Friction;
use crate::pulley::PerPulley;
use crate::solver::State;
use crate::variator::pulleys::loads::Loads;
use crate::variator::pulleys::rows::External;
use crate::variator::run::plant::Plant;

/// A plant's state, loads and energies, and the loads as held over the last step. Its memory is allocated once.
#[derive(Clone, Debug)]
pub(super) struct Checkpoint {
    state: State,
    time: f64,
    loads: Loads,
    friction: Friction,
    friction_velocity: f64,
    /// Supplied, lost and moved, J.
    energies: [f64; 3],
    external: PerPulley<External>,
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
            loads: system.loads,
            friction: system.parameters.friction.clone(),
            friction_velocity: system.friction_velocity,
            energies: [energy.supplied, energy.lost, energy.moved],
            external: PerPulley::default(),
        }
    }

    /// Stores the state of a plant, and the loads as held over the last step.
    pub fn save(&mut self, plant: &Plant, external: PerPulley<External>) {
        let Plant {
            system, energy, state, ..
        } = plant;
        self.state.copy_from(state);
        self.time = plant.time;
        self.loads = system.loads;
        self.friction.clone_from(&system.parameters.friction);
        self.friction_velocity = system.friction_velocity;
        self.energies = [energy.supplied, energy.lost, energy.moved];
        self.external = external;
    }

    /// Brings a plant back to the state that was stored last, without what the solver reuses from step to step. Returns the loads as
    /// held over the last step.
    pub fn restore(&self, plant: &mut Plant) -> PerPulley<External> {
        let Plant {
            system, energy, state, ..
        } = plant;
        state.copy_from(&self.state);
        system.loads = self.loads;
        system.parameters.friction.clone_from(&self.friction);
        system.friction_velocity = self.friction_velocity;
        system.forget_derivatives();
        [energy.supplied, energy.lost, energy.moved] = self.energies;
        energy.last.update(system, state.view());
        plant.time = self.time;
        self.external
    }
}
