//! Friction between the layers of the ring, and in the joints of a pull chain: laws without state.
//!
//! A ring set is a stack of n thin bands. The speed of a band is the same all around the loop. On
//! an arc of radius R, however, bands a thickness t apart would have to differ in speed by v t/R to
//! move together. They do so on the pulley that holds the layers more firmly, and slip by v t
//! |1/R_P − 1/R_S| on the other. There the interface below layer j + 1 carries the normal load of the n − j layers outside it; the sum over all interfaces is (n − 1)/2 of the whole
//! load. T − m_r ṡ² is the part of the tension that causes normal load. The drag along the ring per
//! length of that arc, against its motion v, is
//!
//! f = μ_l t |1/R_P − 1/R_S| (n − 1)/2 · ⟨T − m_r ṡ²⟩₊ κ · v/√(v² + v₀²).
//!
//! Its power, integrated over the arc, is μ_l v t |1/R_P − 1/R_S| (n − 1)/2 (T − m_r ṡ²) α.
//! Parallel ring sets share the tension, so together they dissipate as much as one.
//!
//! The power is exact; the place where it acts is a simplification. In a real ring the friction
//! transfers tension between the layers, which results in a couple on each pulley. The beam model
//! has no layers, so the law is a drag on the ring alone: some newtons, with a tension of
//! kilonewtons. The error of the strands' moment about a pulley is 0.3 N·m in overdrive at 20 kN.
//!
//! The layers slip on the pulley with the smaller wrap, which is the one with the smaller radius.
//! Its share goes from 0 to 1 as the difference of curvatures passes `EVEN`. There the loss is
//! small; at ratio 1 it and its slope are zero.
//!
//! **Joints.** Neighbouring links of a chain turn against each other where its curvature changes:
//! by 1/R per length where it enters an arc, and back where it leaves. Under the tension T a joint
//! whose friction acts at the radius r_j resists with the moment T r_j, so each of the two borders
//! of an arc takes the power T r_j |v|/R. As a drag along the chain per length of the arc, of wrap
//! angle α,
//!
//! f = 2 r_j/(R α) · T κ · v/√(v² + v₀²).
//!
//! The power is exact where the tension is uniform. The drag is spread over the arc, a
//! simplification as for layers.

use crate::scalar::Real;

/// Difference of the curvatures of the two arcs below which they count as equal, 1/m: a ratio of
/// 1.03.
const EVEN: f64 = 0.5;

/// Regularisation speed v₀ of the drag, m/s.
const SPEED_SMOOTHING: f64 = 0.1;

/// Parameters of the layers of the ring sets: of the friction between them, and of their stress.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Layers {
    /// Number n of layers.
    pub count: i32,
    /// Thickness t of a layer, m.
    pub thickness: f64,
    /// Friction coefficient μ_l between layers.
    pub friction: f64,
    /// Width w of a layer, m; for its [stress](super::stress) only.
    pub width: f64,
    /// Curvature κ₀ of a layer that is free of stress, 1/m; for its stress only.
    pub residual_curvature: f64,
}

/// Parameters of the joints of a pull chain.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Joints {
    /// Radius r_j of the friction, m: coefficient times radius of a sliding joint, rolling friction
    /// arm of a rocker joint.
    pub radius: f64,
}

impl Joints {
    /// Drag on the secondary and on the primary arc, 2 r_j/(R α), as a fraction of the chain's
    /// tension. `radii` are those of the arcs in that order, m, `wraps` the wrap angles, rad.
    #[inline(always)]
    pub fn drag_coefficients<T: Real>(&self, radii: [T; 2], wraps: [T; 2]) -> [T; 2] {
        std::array::from_fn(|k| (radii[k] * wraps[k]).recip() * (2.0 * self.radius))
    }
}

impl Layers {
    /// Drag on the secondary and on the primary arc as a fraction of the ring's normal load on
    /// them. `radii` are the pitch radii in that order, m.
    #[inline(always)]
    pub fn drag_coefficients<T: Real>(&self, radii: [T; 2]) -> [T; 2] {
        let [sharper, inverse] = sharper(radii);
        // |x| as x²/√(x² + δ²): relative error ½(δ/x)²; value and slope are zero at x = 0.
        let difference = sharper * sharper * inverse;
        let half = difference * (0.25 * self.friction * self.thickness * f64::from(self.count - 1));
        let lean = sharper * inverse;
        [half * (lean + 1.0), half * (-lean + 1.0)]
    }
}

/// The pulley on which the layers of a ring with this `speed` along itself, m/s, slip: 0 the
/// secondary, 1 the primary; and the fraction of them that slips: 1 except near ratio 1 and near a
/// standstill, where it falls to 0.
pub(super) fn slip(radii: [f64; 2], speed: f64) -> (usize, f64) {
    let [sharper, inverse] = sharper(radii);
    let lean = sharper * inverse;
    (usize::from(lean < 0.0), (lean * direction(speed)).abs())
}

/// Difference of the curvatures of secondary and primary arc, 1/m, and a factor that makes it their
/// lean: from −1 to 1, the pulley on which the layers slip.
#[inline(always)]
fn sharper<T: Real>([secondary, primary]: [T; 2]) -> [T; 2] {
    let sharper = secondary.recip() - primary.recip();
    let (_, inverse) = (sharper * sharper + EVEN * EVEN).root_and_inverse();
    [sharper, inverse]
}

/// Direction of the ring's motion along itself at `speed`, m/s: from −1 to 1, smooth at a
/// standstill.
#[inline(always)]
pub(crate) fn direction<T: Real>(speed: T) -> T {
    let (_, inverse) = (speed * speed + SPEED_SMOOTHING * SPEED_SMOOTHING).root_and_inverse();
    speed * inverse
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drag_is_on_the_smaller_pulley_and_vanishes_at_ratio_1() {
        let layers = Layers {
            count: 9,
            thickness: 1.85e-4,
            friction: 0.05,
            ..Layers::default()
        };
        let [secondary, primary] = layers.drag_coefficients([0.036, 0.072]);
        let expected = 0.05 * 1.85e-4 * 4.0 * (1.0 / 0.036 - 1.0 / 0.072);
        assert!((secondary / expected - 1.0).abs() < 0.005, "{secondary} {expected}");
        assert!(primary >= 0.0 && primary < 0.002 * secondary, "{primary}");
        assert_eq!(layers.drag_coefficients([0.072, 0.036]), [primary, secondary]);
        let near = layers.drag_coefficients([0.058, 0.058 * 1.0001]);
        assert!(near[0] < 1e-4 * secondary, "{near:?}");
    }
}
