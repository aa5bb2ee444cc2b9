//! Steady states, with the fields along the belt.

use crate::load_cases::{LoadCase, given, pair, ratio, speeds, transmitted};
use crate::variators::SPEED;
use pushbelt::pulley::{PerPulley, Pulley};
use pushbelt::solver::State;
use pushbelt::solver::newton::{Counts, Newton};
use pushbelt::variator::cell::sample::Sample;
use pushbelt::variator::diagnostics::belt::BeltDiagnostics;
use pushbelt::variator::diagnostics::observe::Observer;
use pushbelt::variator::pulleys::loads::ShaftMode;
use pushbelt::variator::ring_models::BeltRing;
use pushbelt::variator::settings::{Outputs, Parameters};
use pushbelt::variator::steady::solve::{SteadySolver, SteadyTask};
use pushbelt::variator::steady::start::{Start, kinematic_state};
use pushbelt::variator::system::VariatorSystem;
use std::sync::Arc;

#[derive(Clone, Debug)]
pub struct Steady {
    /// The system with its boundary conditions.
    pub system: VariatorSystem,
    pub state: State,
    pub outputs: Outputs,
    /// Work that it took.
    pub counts: Counts,
}

#[derive(Clone, Copy, Debug)]
pub struct At {
    /// Segment: half secondary arc, upper strand, primary arc, lower strand, half secondary arc.
    pub segment: usize,
    pub element: usize,
    /// The nearer pulley.
    pub pulley: Pulley,
    pub sample: Sample,
}

/// Every station around the loop.
pub fn stations(system: &VariatorSystem, state: &State) -> Vec<At> {
    let mesh = &system.belt.mesh;
    let diagnostics = BeltDiagnostics::new(system, state.view());
    diagnostics
        .stations(mesh)
        .map(|(cell, sample)| At {
            segment: mesh.elements[cell.element].segment,
            element: cell.element,
            pulley: cell.pulley,
            sample,
        })
        .collect()
}

impl Steady {
    /// Every station around the loop.
    pub fn stations(&self) -> Vec<At> {
        stations(&self.system, &self.state)
    }

    /// External torques that hold the state, N·m.
    pub fn external_torques(&self) -> PerPulley<f64> {
        let sums = BeltDiagnostics::new(&self.system, self.state.view()).sums;
        sums.shaft_torque.map(|torque| -torque)
    }

    /// Power into the belt less its losses, W.
    pub fn power_residual(&self) -> f64 {
        let o = &self.outputs;
        o.primary.power + o.secondary.power - (o.losses.total() - o.losses.shafts)
    }

    /// The same as a share of the driving power.
    pub fn power_defect(&self) -> f64 {
        let o = &self.outputs;
        self.power_residual() / o.primary.power.max(o.secondary.power)
    }

    /// Wrap angles of the belt's own radii, rad. (Θ is the radius at one point of S: a stretched
    /// ring is larger than its reference curve.)
    pub fn wrap(&self) -> PerPulley<f64> {
        let difference = self.outputs.primary.radius - self.outputs.secondary.radius;
        let half = (difference / self.system.parameters.geometry.center_distance).acos();
        PerPulley {
            secondary: 2.0 * half,
            primary: std::f64::consts::TAU - 2.0 * half,
        }
    }
}

/// The steady state of a task. `speeds` are those of the shafts, rad/s; a speed that the task
/// leaves free is a first guess.
pub fn steady(parameters: &Parameters, task: &SteadyTask, speeds: PerPulley<f64>) -> Steady {
    steady_with(parameters, parameters.ring_of_model(), task, speeds)
}

/// At a ratio that the primary sheave holds, under a secondary clamping force, N: both shafts have
/// given speeds, rad/s.
pub fn turning(parameters: &Parameters, ratio: f64, force: f64, speeds: PerPulley<f64>) -> Steady {
    steady(parameters, &given(ratio, Pulley::Primary, force), speeds)
}

/// The same at a primary speed, rad/s, without load at the secondary shaft.
pub fn idling(parameters: &Parameters, ratio: f64, force: f64, speed: f64) -> Steady {
    let task = SteadyTask {
        shaft: pair(ShaftMode::Torque(0.0), ShaftMode::Fixed),
        ..given(ratio, Pulley::Primary, force)
    };
    steady(parameters, &task, speeds(ratio, speed))
}

/// The same with a torque, N·m, on the primary shaft, and the secondary speed without slip at a
/// primary one, rad/s.
pub fn transmitting(parameters: &Parameters, ratio: f64, force: f64, torque: f64, speed: f64) -> Steady {
    steady(parameters, &transmitted(ratio, force, torque), speeds(ratio, speed))
}

/// [`steady`] with a ring other than that of the parameters.
pub fn steady_with(
    parameters: &Parameters,
    ring: Arc<dyn BeltRing>,
    task: &SteadyTask,
    speeds: PerPulley<f64>,
) -> Steady {
    parameters.validate().expect("valid parameters");
    ring.check(parameters).expect("parameters that fit the ring");
    let mut system = VariatorSystem::with_ring(parameters, ring);
    let start = Start {
        ratio: task.ratio,
        primary_speed: speeds.primary,
        clamping: task.clamping,
    };
    let mut state = kinematic_state(&system.belt, &start).expect("the belt closes");
    for pulley in Pulley::BOTH {
        state.y[system.belt.layout.shaft_speed(pulley)] = speeds[pulley];
    }
    let mut newton = Newton::new(&system);
    let mut solver = SteadySolver {
        system: &mut system,
        newton: &mut newton,
    };
    if let Err(report) = solver.solve(&mut state, task) {
        panic!("no steady state of {task:?} at {speeds:?} rad/s: {report:?}");
    }
    let mut outputs = Outputs::default();
    let diagnostics = BeltDiagnostics::new(&system, state.view());
    Observer::default().observe(&system, 0.0, state.view(), &diagnostics, &mut outputs);
    Steady {
        system,
        state,
        outputs,
        counts: newton.counts,
    }
}

/// The steady state of a load case.
pub fn load_case(parameters: &Parameters, case: &LoadCase) -> Steady {
    load_case_with(parameters, parameters.ring_of_model(), case)
}

/// [`load_case`] with a ring other than that of the parameters.
pub fn load_case_with(parameters: &Parameters, ring: Arc<dyn BeltRing>, case: &LoadCase) -> Steady {
    steady_with(parameters, ring, &case.task(), speeds(ratio(case.theta), SPEED))
}
