//! The seam between a variator and its ring: [`BeltRing`], and what a ring model of one's own is built from.
//!
//! [`Variator::with_ring`](crate::variator::Variator::with_ring) takes any ring. A ring whose mesh stands still in space has
//! three parts:
//!
//! 1. [`EulerianRing`] is the ring inside one cell, generic over the scalar. It may wrap [`Deflecting`], the ring of `ALE`.
//! 2. [`RingKind`] makes it from the unknowns of the cell, which [`Directions`] counts. A value of it holds parameters.
//! 3. [`BeltRing`] puts it into a belt. [`eulerian_equations`] evaluates and differentiates the cells.
//!
//! A ring of another kind implements [`Assembly`] itself, with the balance of a cell, [`balance`], for elements, flanks and
//! friction.
//!
//! `examples/own_ring.rs` is a ring model in one file.

use crate::reference_curve::{TwoPulley, TwoPulleyFrame};
use crate::solver::State;
use crate::variator::settings::parameters::{Mesh, Parameters};
use crate::variator::settings::validation::ParameterError;
use nalgebra::Vector2;
use std::fmt::Debug;
use std::sync::Arc;

pub use crate::chain::Transport;
pub use crate::variator::assembly::equations::{Assembly, InForce};
pub use crate::variator::assembly::kinds::{MeshCurve, RingKind};
pub use crate::variator::assembly::packed::{deflecting_equations, eulerian_equations, guided_equations};
pub use crate::variator::assembly::sums::{PulleyLoad, ResultantSlopes};
pub use crate::variator::assembly::transports::{Face, Transports};
pub use crate::variator::assembly::unknowns::{Part, ReadUnknowns, nodes};
pub use crate::variator::belt::{Belt, HOLD};
pub use crate::variator::cell::balance::balance;
pub use crate::variator::cell::directions::{Direction, Directions};
pub use crate::variator::cell::probe::{NoProbe, Probe, Sampler};
pub use crate::variator::cell::sample::Sample;
pub use crate::variator::cell::state::CellInput;
pub use crate::variator::law::place::{CellBalance, CellLaw, CellMotion, Place, PulleyMotion, SheavePlane};
pub use crate::variator::mesh::belt_mesh::{BeltMesh, Cell, CellDivision, SLOTS};
pub use crate::variator::mesh::layout::{Layout, RingUnknowns};
pub use crate::variator::rings::deflecting::Deflecting;
pub use crate::variator::rings::ring::{Action, CellRing, EulerianRing, RingDensity, RingForces};
pub use crate::variator::rings::standard::{Ale, Ale0, cells_of_deflecting};

/// A model of a belt's ring.
pub trait BeltRing: Debug + Send + Sync {
    /// Name for messages.
    fn name(&self) -> &'static str;

    /// Checks the parameters that this ring restricts further than [`Parameters::validate`].
    ///
    /// # Errors
    /// The first parameter that does not fit the ring.
    fn check(&self, _parameters: &Parameters) -> Result<(), ParameterError> {
        Ok(())
    }

    /// Cells of an element of the mesh.
    fn cells(&self, mesh: &Mesh) -> CellDivision;

    /// Whether element borders follow the arc borders. If not, elements are spaced evenly along the belt.
    fn is_aligned(&self) -> bool {
        true
    }

    /// Unknowns of the ring beside drift and Θ.
    fn unknowns(&self, parameters: &Parameters, mesh: &BeltMesh, curve: &TwoPulley) -> RingUnknowns;

    /// Equations of ring, elements and contact of a belt with this ring.
    fn equations(&self, belt: &Belt) -> Box<dyn Assembly>;

    /// Directions A_i in (10) along which the deflection at a node is counted in the plane; x and y if there are none.
    fn directions(&self, _belt: &Belt, _frame: &TwoPulleyFrame<f64>, _node: usize) -> Option<[Vector2<f64>; 2]> {
        None
    }

    /// Absolute error, m/s, that does not matter in a speed of the ring's nodes: `of_place` if their places matter over a
    /// step, `of_sliding` if they slide on the elements.
    fn speed_error(&self, of_place: f64, _of_sliding: f64) -> f64 {
        of_place
    }

    /// Longest distance that the ring may drift in a step, m.
    fn longest_drift(&self, _belt: &Belt) -> f64 {
        f64::INFINITY
    }

    /// The ring, on the same mesh, whose start state this one takes over by [`BeltRing::start_from`]; none if this ring
    /// has a steady state of its own.
    fn starts_on(&self) -> Option<Arc<dyn BeltRing>> {
        None
    }

    /// The state of `belt`, which has this ring, in which it starts from the `state` of `other`, which has the ring of
    /// [`BeltRing::starts_on`].
    fn start_from(&self, _belt: &Belt, _other: &Belt, state: &State) -> State {
        state.clone()
    }
}
