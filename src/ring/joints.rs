//! Friction in the joints of a pull chain: a law without state.
//!
//! Neighbouring links turn against each other where the curvature of the chain changes: by 1/R per length where it enters
//! an arc, and back where it leaves. Under the tension T a joint whose friction acts at the radius r_j resists with the
//! moment T r_j, so each of the two borders of an arc takes the power T r_j |v|/R. As a drag along the chain per length of
//! the arc, of wrap angle α,
//!
//! f = 2 r_j/(R α) · T κ · v/√(v² + v₀²).
//!
//! The power is exact where the tension is uniform; the place where it acts is a simplification, as for
//! [layers](super::layers): the drag is spread over the arc.

use crate::scalar::Real;

/// Parameters of the joints.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Joints {
    /// Radius r_j of the friction, m: coefficient times radius of a sliding joint, rolling friction arm of a rocker joint.
    pub radius: f64,
}

impl Joints {
    /// Drag on the secondary and on the primary arc, 2 r_j/(R α), as a share of the chain's tension. `radii` are those of the
    /// arcs in that order, m, `wraps` the wrap angles, rad.
    #[inline(always)]
    pub fn drag_shares<T: Real>(&self, radii: [T; 2], wraps: [T; 2]) -> [T; 2] {
        std::array::from_fn(|k| (radii[k] * wraps[k]).recip() * (2.0 * self.radius))
    }
}
