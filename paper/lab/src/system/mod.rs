//! The ring alone, free in the plane or in space, as an implicit system: no stack, contact or
//! pulleys (paper 5.3).
//!
//! ∫ m_r Pᵀ Dv/Dt dξ + ∂V/∂q + damping = 0 (25) for any
//! [`RingFormulation`](pushbelt_paper::ring::model::RingFormulation). Unknowns are the rates:
//! blocks of the model around the loop, then ṡ and Θ̇ in the border, so the Jacobian is an arrow
//! matrix for every model.
//!
//! | file | content |
//! |---|---|
//! | `free_ring` | the ring and its unknowns |
//! | `starts` | states to start from |
//! | `readings` | particles, energies, power of damping, mass matrix |
//! | `packs` | neighbouring elements, one in each lane of a register |
//! | `equations` | residual and Jacobian for the solver |

mod equations;
mod free_ring;
mod packs;
mod readings;
mod starts;

pub use free_ring::RingSystem;
