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

mod standard;

pub use crate::chain::Transport;
pub use crate::variator::assembly::kinds::{MeshCurve, RingKind};
#[doc(hidden)]
pub use crate::variator::assembly::packed::{deflecting_derivative_error, guided_derivative_error};
pub use crate::variator::assembly::packed::{deflecting_equations, eulerian_equations, guided_equations};
pub use crate::variator::assembly::transports::{Face, Transports};
pub use crate::variator::assembly::unknowns::{Part, ReadUnknowns, nodes};
pub use crate::variator::belt::equations::{Assembly, InForce};
pub use crate::variator::belt::ring::BeltRing;
pub use crate::variator::belt::sums::{PulleyLoad, ResultantSlopes};
pub use crate::variator::belt::{Belt, HOLD};
pub use crate::variator::cell::balance::balance;
pub use crate::variator::cell::directions::{Direction, Directions};
pub use crate::variator::cell::observer::{NoObserver, Observer, Sampler};
pub use crate::variator::cell::sample::Sample;
pub use crate::variator::cell::state::CellInput;
pub use crate::variator::law::place::{CellBalance, CellLaw, CellMotion, Place, PulleyMotion, SheavePlane};
pub use crate::variator::mesh::belt_mesh::{BeltMesh, Cell, CellDivision, SLOTS};
pub use crate::variator::mesh::layout::{Layout, RingUnknowns};
pub use crate::variator::rings::deflecting::Deflecting;
pub use crate::variator::rings::ring::{Action, CellRing, EulerianRing, RingDensity, RingForces};
pub use standard::{Ale, Ale0, cells_of_deflecting};
