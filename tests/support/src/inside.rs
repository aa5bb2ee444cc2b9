//! Internal quantities of the variator for tests and benchmarks: unknowns, equations and fields that are not outputs.

use nalgebra::DMatrix;
use pushbelt::pulley::PerPulley;
use pushbelt::solver::arrow::Arrow;
use pushbelt::solver::{State, System};
use pushbelt::variator::cell::sample::Sample;
use pushbelt::variator::diagnostics::belt::BeltDiagnostics;
use pushbelt::variator::run::Variator;
use pushbelt::variator::system::VariatorSystem;

use crate::steady::Steady;

/// s and Θ of a variator.
#[must_use]
pub fn reference_motion(variator: &Variator) -> [f64; 2] {
    let layout = &variator.system().belt.layout;
    [layout.drift(), layout.theta()].map(|at| variator.state().q[at])
}

/// Smallest net force T − Q in a strand, N: negative if it would buckle.
#[must_use]
pub fn strand_force(variator: &Variator) -> f64 {
    variator.energy_balance().last.sums.strand_force
}

/// Sliding of the loaded stations of a pulley.
#[derive(Clone, Copy, Debug)]
pub struct Sliding {
    /// Mean tangential sliding speed, m/s, weighted by load.
    pub mean: f64,
    /// Share of the load that slides forward.
    pub forward: f64,
}

/// Sliding on both pulleys.
#[must_use]
pub fn sliding(variator: &Variator) -> PerPulley<Sliding> {
    variator.energy_balance().last.sums.sliding.map(|sums| Sliding {
        mean: sums.weighted / sums.load,
        forward: sums.forward / sums.load,
    })
}

/// Axial force of the belt on the primary sheave over that on the secondary one.
#[must_use]
pub fn thrust_ratio(system: &VariatorSystem, state: &State) -> f64 {
    let axial = BeltDiagnostics::of(system, state.view()).sums.axial;
    axial.primary / axial.secondary
}

/// Every station around the loop in a state of a variator.
#[must_use]
pub fn stations(variator: &Variator, state: &State) -> Vec<Sample> {
    let system = variator.system();
    let diagnostics = BeltDiagnostics::of(system, state.view());
    diagnostics
        .stations(&system.belt.mesh)
        .map(|(_, sample)| sample)
        .collect()
}

/// Indices of the overlay's unknowns in the state of a planar ring, with the order of the derivative: 0 for a deflection, 1
/// for a slope.
#[must_use]
pub fn overlay(variator: &Variator) -> Vec<(usize, u32)> {
    let layout = variator.system().belt.layout;
    (0..layout.elements)
        .flat_map(|node| [0, 1, 2, 3].map(|k| (layout.node(node, k as usize), k % 2)))
        .collect()
}

impl Steady {
    /// Indices of s and Θ.
    #[must_use]
    pub fn reference_places(&self) -> Vec<usize> {
        let layout = &self.system.belt.layout;
        vec![layout.drift(), layout.theta()]
    }

    /// Indices of the overlay, including the multipliers of its gauge.
    #[must_use]
    pub fn overlay_places(&self) -> Vec<usize> {
        let layout = &self.system.belt.layout;
        (0..layout.elements)
            .flat_map(|node| (0..2 * layout.components).map(move |k| layout.node(node, k)))
            .chain([0, 1].map(|condition| layout.gauge(condition)))
            .collect()
    }

    /// The Jacobian of a stage, in full; `alpha` = 1/(γh) of a step h.
    pub fn jacobian(&mut self, alpha: f64) -> DMatrix<f64> {
        let n = self.state.y.len();
        let mut arrow = Arrow::new(self.system.shape());
        self.system
            .jacobian(0.0, self.state.view(), alpha, 1.0 / alpha, &mut arrow);
        let (mut matrix, mut unit) = (DMatrix::zeros(n, n), vec![0.0; n]);
        for (k, mut column) in matrix.column_iter_mut().enumerate() {
            unit[k] = 1.0;
            arrow.multiply(&unit, column.as_mut_slice());
            unit[k] = 0.0;
        }
        matrix
    }

    /// Whether an element of the ring lies on an arc.
    #[must_use]
    pub fn on_arc(&self) -> Vec<bool> {
        let elements = self.system.belt.mesh.elements.iter();
        elements.map(|element| element.segment.is_multiple_of(2)).collect()
    }

    /// Axes of the pulleys along x, m.
    #[must_use]
    pub fn axes(&self) -> PerPulley<f64> {
        self.system.belt.law.axes
    }

    /// Distance of the belt planes due to the pitch radii alone, m.
    #[must_use]
    pub fn geometric_misalignment(&self) -> f64 {
        let (law, o) = (&self.system.belt.law, &self.outputs);
        -(o.primary.radius + o.secondary.radius - 2.0 * law.r0) * law.wedge[2]
    }
}
