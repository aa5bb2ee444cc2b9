//! Drag of elements that start and stop turning.
//!
//! An element turns at V/R about its rocking edge on an arc of pitch radius R, and not at all on a
//! strand. Spinning it up and stopping it, both plastic, costs I (V/R)²: an upper bound. With the
//! wrap angle α and the thickness h the drag per dξ against V (`docs/theory.md`, (4.12)) is
//!
//! f = I/(h R² α) κ ν |J| V.
//!
//! |J| is smooth at a standstill: J²/√(J² + v₀²). The power over the arc is exact; the drag is
//! spread over the arc, which holds for every mesh, and has no reaction on ring or pulleys.

use crate::pulley::PerPulley;
use crate::scalar::Real;
use crate::stack::PushElements;

/// Regularisation speed v₀ of |J|, m/s.
const FLOW_SMOOTHING: f64 = 0.1;

/// I/(h R² α) of each arc, kg/m, with the pitch radii, m, and the wrap angles, rad.
#[inline(always)]
pub fn rotation_drag_coefficients<T: Real>(
    belt: &PushElements,
    radii: PerPulley<T>,
    wraps: PerPulley<T>,
) -> PerPulley<T> {
    let per_thickness = belt.element_inertia / belt.element_thickness;
    let curvatures = radii.map(Real::recip);
    // One division for both.
    let inverse = (wraps.secondary * wraps.primary).recip() * per_thickness;
    PerPulley::from_fn(|arc| curvatures[arc] * curvatures[arc] * wraps[arc.other()] * inverse)
}

/// Throughput ν|J| of elements, m/s.
#[inline(always)]
pub fn throughput<T: Real>(nu: T, flow: T) -> T {
    let square = flow * flow;
    let (_, inverse) = (square + FLOW_SMOOTHING * FLOW_SMOOTHING).root_and_inverse();
    nu * square * inverse
}

/// Drag of the elements per dξ, N/m, on an arc of this [coefficient](rotation_drag_coefficients)
/// and curvature `kappa`, with the [`throughput`] and the speed V, m/s.
#[inline(always)]
pub fn rotation_drag<T: Real>(coefficient: T, kappa: T, throughput: T, speed: T) -> T {
    coefficient * kappa * throughput * speed
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drag_is_odd_and_smooth_and_grows_with_the_square_of_speed() {
        let drag = |v: f64| rotation_drag(1.0, 20.0, throughput(0.99, v), v);
        for v in [1e-3, 0.1, 3.0, 40.0] {
            assert_eq!(drag(-v), -drag(v));
            assert!(drag(v) > 0.0);
        }
        assert_eq!(drag(0.0), 0.0);
        assert!(drag(1e-6) < 1e-15, "{}", drag(1e-6));
        assert!((drag(40.0) / drag(20.0) - 4.0).abs() < 1e-4);
    }
}
