//! Steady states, with the fields along the belt.

use pushbelt::solver::State;
use pushbelt::solver::newton::{Counts, Newton};
use pushbelt::variator::layout::Global;
use pushbelt::variator::mesh::{P, S};
use pushbelt::variator::observe::{Context, Observer};
use pushbelt::variator::parameters::Parameters;
use pushbelt::variator::sample::Sample;
use pushbelt::variator::signals::{Outputs, StartState};
use pushbelt::variator::start::{Start, kinematic_state};
use pushbelt::variator::steady::{self, SteadyTask};
use pushbelt::variator::system::VariatorSystem;

use crate::load_cases::{LoadCase, ratio};
use crate::variators::SPEED;

/// Most solves a steady state may take here.
const MAX_SOLVES: usize = 600;

/// A steady state.
#[derive(Clone, Debug)]
pub struct Steady {
    /// The system with its boundary conditions.
    pub system: VariatorSystem,
    /// The state.
    pub state: State,
    /// What it tells.
    pub outputs: Outputs,
    /// What it took.
    pub counts: Counts,
}

/// A station with its cell.
#[derive(Clone, Copy, Debug)]
pub struct At {
    /// Segment: half secondary arc, upper strand, primary arc, lower strand, half secondary arc.
    pub segment: usize,
    /// Ring element.
    pub element: usize,
    /// What is there.
    pub sample: Sample,
}

impl Steady {
    /// Every station around the loop.
    pub fn stations(&self) -> Vec<At> {
        let mesh = &self.system.mesh;
        let survey = self.system.surveyed(self.state.view());
        survey
            .stations(mesh)
            .map(|(cell, sample)| At {
                segment: mesh.elements[cell.element].segment,
                element: cell.element,
                sample,
            })
            .collect()
    }

    /// Sum of supplied powers less losses as a share of the driving power.
    pub fn power_defect(&self) -> f64 {
        let o = &self.outputs;
        let driving = o.primary.power.max(o.secondary.power);
        (o.primary.power + o.secondary.power - o.losses.total()) / driving
    }

    /// Wrap angles α_S, α_P of the belt's own radii, rad. (Θ is the radius at one point of S: a stretched ring is
    /// larger than its reference curve.)
    pub fn wrap(&self) -> [f64; 2] {
        let difference = self.outputs.primary.radius - self.outputs.secondary.radius;
        let half = (difference / self.system.law.parameters.geometry.center_distance).acos();
        [2.0 * half, std::f64::consts::TAU - 2.0 * half]
    }
}

/// The steady state of a task. `speeds` are ω_S and ω_P; a speed that the task leaves free is a first guess.
pub fn steady(parameters: &Parameters, task: &SteadyTask, speeds: [f64; 2]) -> Steady {
    parameters.validate().expect("valid parameters");
    let mut system = VariatorSystem::new(parameters);
    let start = Start {
        ratio: task.ratio,
        primary_speed: speeds[P],
        clamping: task.clamping,
    };
    let mut state = kinematic_state(&system, &start).expect("the belt closes");
    for j in [S, P] {
        state.y[system.layout.global(Global::Speed, j)] = speeds[j];
    }
    let mut newton = Newton::new(&system);
    if let Err(report) = steady::solve(&mut system, &mut newton, &mut state, task, MAX_SOLVES) {
        panic!("no steady state of {task:?} at {speeds:?} rad/s: {report:?}");
    }
    let context = Context {
        external_torque: [0.0; 2],
        macro_slip: false,
        initial_energy: 0.0,
        start_state: StartState::Steady,
    };
    let mut outputs = Outputs::default();
    let survey = system.surveyed(state.view());
    Observer::default().observe(&system, state.view(), &survey, &context, &mut outputs);
    Steady {
        system,
        state,
        outputs,
        counts: newton.counts,
    }
}

/// The steady state of a load case.
pub fn load_case(parameters: &Parameters, case: &LoadCase) -> Steady {
    steady(parameters, &case.task(), [SPEED / ratio(case.theta), SPEED])
}
