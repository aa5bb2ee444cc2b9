//! The interface between a variator and its ring.
//! [`Variator::with_ring`](crate::variator::Variator::with_ring) accepts any [`BeltRing`].
//!
//! | trait | what it is |
//! |---|---|
//! | [`BeltRing`] | a model: mesh, unknowns and equations of a belt |
//! | [`Assembly`] | equations of a belt; of a ring on an Eulerian mesh [`eulerian_equations`] |
//! | [`RingKind`] | a ring on an Eulerian mesh: from its unknowns, that inside a cell |
//! | [`CellRing`] | a ring inside a cell; it may wrap [`Deflecting`], that of `ALE` |
//! | [`VaryingRing`] | its derivatives by hand, instead of forward differentiation |
//!
//! A ring on an Eulerian mesh implements `BeltRing`, `RingKind` and `CellRing`:
//! `examples/own_ring.rs` is one in one file. A ring with elements of its own implements `BeltRing`
//! and `Assembly`, and `CellRing` for [`balance`], which adds elements, flanks and friction of a
//! cell; if its nodes move with the material, it has a [`MaterialMesh`].

mod standard;

pub use crate::ring::ale::RingDensity;
pub use crate::stack::Transport;
pub use crate::variator::assembly::packed::eulerian_equations;
pub use crate::variator::assembly::transports::{Face, Transports};
pub use crate::variator::belt::equations::{Assembly, InForce, PulleyLoad, ResultantDerivatives, RingEnergy};
pub use crate::variator::belt::ring::{BeltRing, MaterialMesh};
pub use crate::variator::belt::{Belt, CONSTRAINT_SCALE};
pub use crate::variator::cell::balance::balance;
pub use crate::variator::cell::sample::{AtStation, Sample};
pub use crate::variator::cell::state::CellPoints;
pub use crate::variator::law::arguments::{
    CellBalance, CellGeometry, CellInput, CellLaw, CellMotion, Extent, FirstUnknowns, PulleyMotion,
    SheavePlane, StateComponent,
};
pub use crate::variator::mesh::belt_mesh::{BeltMesh, CELL_POINTS, Cell, CellDivision};
pub use crate::variator::mesh::layout::{Layout, NodeUnknown};
pub use crate::variator::rings::deflecting::{Ale, Deflecting, nodes};
pub use crate::variator::rings::guided::{Ale0, Guided};
pub use crate::variator::rings::{
    CellRing, Degrees, RingForces, RingInput, RingKind, StationLoad, VaryingRing,
};
