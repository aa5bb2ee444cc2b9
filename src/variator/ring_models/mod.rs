//! The interface between a variator and its ring: [`BeltRing`], and the parts of a user-defined
//! ring model.
//!
//! [`Variator::with_ring`](crate::variator::Variator::with_ring) accepts any ring. A ring on an
//! Eulerian mesh has three parts:
//!
//! 1. [`EulerianRing`] is the ring inside one cell, generic over the scalar. It may wrap
//!    [`Deflecting`], the ring of `ALE`.
//! 2. [`RingKind`] constructs it from the unknowns of the cell, as numbered by [`Degrees`]. A value
//!    of it holds parameters.
//! 3. [`BeltRing`] is the ring of a whole belt. [`eulerian_equations`] evaluates and differentiates
//!    the cells.
//!
//! Other rings implement [`Assembly`] and call [`balance`] for elements, flanks and friction of a
//! cell.
//!
//! `examples/own_ring.rs` is a ring model in one file.

mod standard;

pub use crate::reference_curve::MeshCurve;
pub use crate::ring::ale::RingDensity;
pub use crate::stack::Transport;
pub use crate::variator::assembly::kinds::{RingKind, nodes};
pub use crate::variator::assembly::packed::{deflecting_equations, eulerian_equations, guided_equations};
pub use crate::variator::assembly::transports::{Face, Transports};
pub use crate::variator::belt::equations::{Assembly, InForce};
pub use crate::variator::belt::ring::{BeltRing, StartsOn};
pub use crate::variator::belt::sums::{PulleyLoad, ResultantDerivatives};
pub use crate::variator::belt::{Belt, CONSTRAINT_SCALE};
pub use crate::variator::cell::balance::balance;
pub use crate::variator::cell::degrees::{Degrees, DegreesOfFreedom};
pub use crate::variator::cell::sample::{AtStation, Sample};
pub use crate::variator::cell::state::CellPoints;
pub use crate::variator::law::arguments::{
    CellBalance, CellGeometry, CellInput, CellLaw, CellMotion, Extent, FirstUnknowns, PulleyMotion,
    SheavePlane, StateComponent,
};
pub use crate::variator::mesh::belt_mesh::{BeltMesh, CELL_POINTS, Cell, CellDivision};
pub use crate::variator::mesh::layout::Layout;
pub use crate::variator::rings::deflecting::Deflecting;
pub use crate::variator::rings::ring::{CellRing, EulerianRing, RingForces, StationLoad};
pub use standard::{Ale, Ale0};
