//! Friction between the layers of the ring, and in the joints of a pull chain: laws without state.
//!
//! n layers of thickness t, each of one speed around the loop, hold together on one pulley and slip
//! on the other, the one with the smaller radius and wrap. There the interface below layer j + 1
//! carries the normal load of the n − j layers outside it. The drag along the ring per length of
//! that arc, against its motion v (`docs/theory.md`, (3.10)), is
//!
//! f = μ_l t |1/R_P − 1/R_S| (n − 1)/2 · ⟨T − m_r ṡ²⟩₊ κ · v/√(v² + v₀²).
//!
//! The share of a pulley goes from 0 to 1 as the difference of curvatures passes `EVEN`. The power
//! is exact; that the drag acts on the ring alone is a simplification (`docs/limits.md`).
//!
//! **Joints.** Links of a chain turn against each other by 1/R per length at both borders of an
//! arc, against the moment T r_j of a joint. As a drag along the chain per length of the arc, of
//! wrap angle α (3.11),
//!
//! f = 2 r_j/(R α) · T κ · v/√(v² + v₀²).

use crate::pulley::{PerPulley, Pulley};
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
    /// Width w of a layer, m; for its [stress](super::stress).
    pub width: f64,
    /// Curvature κ₀ of a layer that is free of stress, 1/m; for its stress.
    pub residual_curvature: f64,
}

/// Parameters of the joints of a pull chain.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Joints {
    /// Radius r_j of the friction, m: coefficient times radius of a sliding joint, arm of rolling
    /// friction of a rocker joint.
    pub radius: f64,
}

impl Joints {
    /// Drag on each arc, 2 r_j/(R α), as a fraction of the chain's tension, with radii, m, and wrap
    /// angles, rad.
    #[inline(always)]
    pub fn drag_coefficients<T: Real>(&self, radii: PerPulley<T>, wraps: PerPulley<T>) -> PerPulley<T> {
        PerPulley::from_fn(|arc| (radii[arc] * wraps[arc]).recip() * (2.0 * self.radius))
    }
}

impl Layers {
    /// Drag on each arc as a fraction of the ring's normal load on it, with the pitch radii, m.
    #[inline(always)]
    pub fn drag_coefficients<T: Real>(&self, radii: PerPulley<T>) -> PerPulley<T> {
        let difference = curvature_difference(radii);
        let inverse = inverse_magnitude(difference);
        // |x| as x²/√(x² + δ²): relative error ½(δ/x)²; value and slope are zero at x = 0.
        let magnitude = difference * difference * inverse;
        let half = magnitude * (0.25 * self.friction * self.thickness * f64::from(self.count - 1));
        let lean = difference * inverse;
        PerPulley {
            secondary: half * (lean + 1.0),
            primary: half * (-lean + 1.0),
        }
    }
}

/// The pulley on which the layers of a ring with this `speed` along itself, m/s, slip, and the
/// fraction of them that slips: 1 except near ratio 1 and near a standstill, where it falls to 0.
pub(super) fn slip(radii: PerPulley<f64>, speed: f64) -> (Pulley, f64) {
    let difference = curvature_difference(radii);
    let lean = difference * inverse_magnitude(difference);
    let pulley = if lean < 0.0 { Pulley::Primary } else { Pulley::Secondary };
    (pulley, (lean * direction(speed)).abs())
}

/// Curvature of the secondary arc less that of the primary arc, 1/m.
#[inline(always)]
fn curvature_difference<T: Real>(radii: PerPulley<T>) -> T {
    radii.secondary.recip() - radii.primary.recip()
}

/// 1/√(x² + δ²), m, of the [`curvature_difference`] x.
#[inline(always)]
fn inverse_magnitude<T: Real>(difference: T) -> T {
    let (_, inverse) = (difference * difference + EVEN * EVEN).root_and_inverse();
    inverse
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
        let drag = |secondary: f64, primary: f64| layers.drag_coefficients(PerPulley { secondary, primary });
        let PerPulley { secondary, primary } = drag(0.036, 0.072);
        let expected = 0.05 * 1.85e-4 * 4.0 * (1.0 / 0.036 - 1.0 / 0.072);
        assert!((secondary / expected - 1.0).abs() < 0.005, "{secondary} {expected}");
        assert!(primary >= 0.0 && primary < 0.002 * secondary, "{primary}");
        let swapped = drag(0.072, 0.036);
        assert_eq!((swapped.secondary, swapped.primary), (primary, secondary));
        let near = drag(0.058, 0.058 * 1.0001);
        assert!(near.secondary < 1e-4 * secondary, "{near:?}");
    }
}
