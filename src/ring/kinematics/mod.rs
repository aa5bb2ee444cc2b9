//! Kinematics of the ALE ring on a mesh that moves with Θ (paper 3, eq. (10) to (12)), and the virtual power conjugate
//! to it.
//!
//! Position r = R(ξ, Θ) + B q_f (10) with A_i = identity and cubic Hermite functions (paper 5.2) on elements whose
//! borders follow the arc borders. The reference curve is planar. The deflection has D components: x and y, and in
//! space w along z, the direction of the binormal. At fixed mesh point η:
//!
//! - ring velocity v = ṙ + w r', w = ṡ − ξ̇_η (12),
//! - ring acceleration Dv/Dt = r̈ + ẇ r' + 2w (r')˙ + w² r'',
//!
//! where a dot is ∂/∂t at fixed η. The nodal degrees of freedom are the deflection `a` and its slope `b` = ∂/∂ξ; the
//! element uses d = (a₁, l b₁, a₂, l b₂), whose shape functions do not depend on the element length l(Θ).
//!
//! | file | content |
//! |---|---|
//! | `vectors` | vectors in the plane of the drive and in space |
//! | `hermite` | shape functions |
//! | `motion` | motion of nodes, elements and the reference degrees of freedom |
//! | `point` | the ring at a mesh point |
//! | `load` | forces at a point, and generalised forces of an element |

mod hermite;
mod load;
mod motion;
mod point;
mod vectors;

pub use hermite::Hermite;
pub use hermite::combine;
pub use load::ElementLoad;
pub use load::LineLoad;
pub use motion::{ElementMotion, Node};
pub use motion::{Motion, ReferenceMotion};
pub use point::RingPoint;
pub use vectors::embed;
pub use vectors::{in_plane, inward_normal};
