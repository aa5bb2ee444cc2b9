//! Equations and state of a run: what a stepper advances.

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
use crate::variator::run::tuning::{RAMP, RAMP_PARTS, RAMP_VELOCITY};
use crate::variator::settings::parameters::Parameters;
use crate::variator::settings::signals::Inputs;
use crate::variator::system::VariatorSystem;
use std::sync::Arc;

/// Equations with the inputs in force, energy balance, state and time.
#[derive(Clone, Debug)]
pub(super) struct Simulation {
    pub system: VariatorSystem,
    pub energy: EnergyBalance,
    pub state: State,
    /// s.
    pub time: f64,
    /// Time of a start without load, s; −∞ if it was none. Sharp friction on a slack belt at a
    /// standstill makes one cell after the other stick and slide by turns: half of the Jacobians of
    /// a launch went there. So the friction velocity is large at first and falls.
    pub soft_since: f64,
    /// Work of the search for the state to start from, and the inputs that were given for it.
    pub start_work: Counts,
    pub given: Inputs,
    /// Why the start is another one than was asked for, and what helps.
    pub other_start: Option<String>,
    /// Messages that were not yet taken.
    pub messages: Vec<Message>,
}

impl Simulation {
    /// A variator with parameters that are in their ranges, with this ring, without a state.
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
            other_start: None,
            messages: Vec::new(),
        }
    }

    pub fn log(&mut self, warning: bool, text: String) {
        self.messages.push(Message { warning, text });
    }

    /// Writes to an archive, or reads from it, all values that change in a run.
    pub fn serialize(&mut self, archive: &mut Archive<'_>) {
        self.state.serialize(archive);
        self.system.serialize(archive);
        archive.real(&mut self.time);
        self.energy.serialize(archive);
        archive.bounded_real(&mut self.soft_since, f64::NEG_INFINITY, f64::MAX);
        self.start_work.serialize(archive);
    }

    /// Equations and state for the solver.
    pub fn problem(&mut self) -> (Problem<'_>, &mut State) {
        let problem = Problem {
            system: &mut self.system,
            energy: &mut self.energy,
        };
        (problem, &mut self.state)
    }

    /// Time for which friction is held from now on, s.
    pub fn friction_lasts(&self) -> f64 {
        if self.time - self.soft_since < RAMP {
            RAMP / RAMP_PARTS
        } else {
            f64::INFINITY
        }
    }

    /// Brings the friction velocity of the present time into force: in a ramp, that of the middle
    /// of the part that begins.
    fn regularise(&mut self) {
        let own = self.system.parameters.friction.velocity;
        let rest = 1.0 - (self.time - self.soft_since + 0.5 * self.friction_lasts()) / RAMP;
        let velocity = if rest > 0.0 {
            own * (own.max(RAMP_VELOCITY) / own).powf(rest)
        } else {
            own
        };
        if self.system.friction_velocity != velocity {
            self.system.friction_velocity = velocity;
            // All kept derivatives are of the same law, so a stored state holds one law only.
            self.system.forget_derivatives();
        }
    }

    /// Ends a soft start: its own friction velocity, no kept derivatives.
    pub fn end_soft_start(&mut self) {
        self.soft_since = f64::NEG_INFINITY;
        self.regularise();
        self.system.forget_derivatives();
    }

    /// Brings inputs into force, with the friction of the present time. The rates jump with the
    /// loads.
    pub fn apply(&mut self, inputs: InputProfile) {
        self.regularise();
        let loads = Loads::Inputs(inputs);
        self.system.change_loads(loads, self.time, &mut self.state.y_dot);
    }

    /// The same where they were in force before at this state, or for outputs alone: the rates
    /// stay.
    pub fn restore(&mut self, inputs: InputProfile) {
        self.regularise();
        self.system.loads = Loads::Inputs(inputs);
    }

    /// Sums over the belt in the present state.
    pub fn sums(&self) -> BeltSums {
        BeltDiagnostics::new(&self.system, self.state.view()).sums
    }

    /// Inputs at the present time.
    pub fn inputs(&self) -> Inputs {
        self.system.loads.inputs(self.time)
    }

    /// Whether the belt slips through, where it `slipped` before or not.
    pub fn slips(&self, slipped: bool) -> bool {
        macro_slip(&self.system, self.state.view(), &self.energy.last.sums, slipped)
    }

    /// End stops that the sheaves are at.
    pub fn stops(&self) -> PerPulley<Option<Stop>> {
        PerPulley::from_fn(|pulley| self.system.pulleys().stop_reached(pulley, self.state.view()))
    }
}
