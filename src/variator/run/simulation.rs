//! Equations and state of a run.

use super::tuning::SOFT_START;
use crate::archive::Archive;
use crate::fmi::unit::Message;
use crate::pulley::PerPulley;
use crate::solver::State;
use crate::solver::newton::Counts;
use crate::variator::belt::ring::BeltRing;
use crate::variator::diagnostics::belt::{BeltDiagnostics, BeltSums};
use crate::variator::diagnostics::energy_balance::{EnergyBalance, Problem};
use crate::variator::diagnostics::observe::macro_slip;
use crate::variator::pulleys::loads::{InputProfile, Loads};
use crate::variator::pulleys::rows::Stop;
use crate::variator::settings::{Inputs, Parameters};
use crate::variator::steady::refine::Neighbour;
use crate::variator::system::VariatorSystem;
use std::sync::Arc;

/// Equations with the inputs in force, energy balance, state and time.
#[derive(Clone, Debug)]
pub(super) struct Simulation {
    pub system: VariatorSystem,
    pub energy: EnergyBalance,
    pub state: State,
    /// Present time, s.
    pub time: f64,
    /// Time of a start without load, s; else −∞. Sharp friction on a slack belt at a standstill
    /// makes the cells stick and slide in turn, so the friction velocity is large at first and
    /// falls.
    pub soft_since: f64,
    /// Work of the search for the state to start from, and its inputs.
    pub start_work: Counts,
    pub given: Inputs,
    /// A steady state from which that of the next start is sought first.
    pub near: Option<Neighbour>,
    /// Why the start is not the requested one, and what helps.
    pub other_start: Option<String>,
    pub messages: Vec<Message>,
}

impl Simulation {
    /// A variator with valid parameters and this ring, without a state.
    pub fn new(parameters: &Parameters, ring: Arc<dyn BeltRing>) -> Self {
        let system = VariatorSystem::with_ring(parameters, ring);
        Self {
            state: State::zero(system.belt.layout.len()),
            energy: EnergyBalance::default(),
            system,
            time: 0.0,
            soft_since: f64::NEG_INFINITY,
            start_work: Counts::default(),
            given: Inputs::ZERO,
            near: None,
            other_start: None,
            messages: Vec::new(),
        }
    }

    pub fn log(&mut self, warning: bool, text: String) {
        self.messages.push(Message { warning, text });
    }

    pub fn serialize(&mut self, archive: &mut Archive<'_>) {
        self.state.serialize(archive);
        self.system.serialize(archive);
        archive.real(&mut self.time);
        self.energy.serialize(archive);
        archive.bounded_real(&mut self.soft_since, f64::NEG_INFINITY, f64::MAX);
        self.start_work.serialize(archive);
        self.given.each_mut().into_iter().for_each(|input| archive.real(input));
    }

    pub fn problem(&mut self) -> (Problem<'_>, &mut State) {
        let problem = Problem {
            system: &mut self.system,
            energy: &mut self.energy,
        };
        (problem, &mut self.state)
    }

    /// Time in which the friction velocity is constant from now on, s.
    pub fn friction_lasts(&self) -> f64 {
        if self.time - self.soft_since < SOFT_START.duration {
            SOFT_START.duration / SOFT_START.parts
        } else {
            f64::INFINITY
        }
    }

    /// Sets the friction velocity of the present time: in a soft start, that of the middle of the
    /// part that begins.
    fn regularise(&mut self) {
        let own = self.system.parameters.friction.velocity;
        let middle = self.time - self.soft_since + 0.5 * self.friction_lasts();
        let rest = 1.0 - middle / SOFT_START.duration;
        let velocity = if rest > 0.0 {
            own * (own.max(SOFT_START.velocity) / own).powf(rest)
        } else {
            own
        };
        if self.system.friction_velocity != velocity {
            self.system.friction_velocity = velocity;
            // All kept derivatives are of one law, which a stored state holds.
            self.system.forget_derivatives();
        }
    }

    /// Ends a soft start: its own friction velocity, no kept derivatives.
    pub fn end_soft_start(&mut self) {
        self.soft_since = f64::NEG_INFINITY;
        self.regularise();
        self.system.forget_derivatives();
    }

    /// Applies inputs, with the friction of the present time. The rates jump with the loads.
    pub fn apply(&mut self, inputs: InputProfile) {
        self.regularise();
        let loads = Loads::Inputs(inputs);
        self.system.change_loads(loads, self.time, &mut self.state.y_dot);
    }

    /// The same without a jump of the rates, for outputs or where they acted before in this state.
    pub fn restore(&mut self, inputs: InputProfile) {
        self.regularise();
        self.system.loads = Loads::Inputs(inputs);
    }

    /// Sums over the belt in the present state.
    pub fn sums(&self) -> BeltSums {
        BeltDiagnostics::new(&self.system, self.state.view()).sums
    }

    pub fn inputs(&self) -> Inputs {
        self.system.loads.inputs(self.time)
    }

    /// Whether the belt slips through; `slipped`: it did before.
    pub fn slips(&self, slipped: bool) -> bool {
        macro_slip(&self.system, self.state.view(), &self.energy.last.sums, slipped)
    }

    pub fn stops(&self) -> PerPulley<Option<Stop>> {
        PerPulley::from_fn(|pulley| self.system.pulleys().stop_reached(pulley, self.state.view()))
    }
}
