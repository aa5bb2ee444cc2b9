//! Friction between ring and elements.

use crate::contact::Friction;
use crate::ring::Ring;
use crate::scalar::{Real, smooth_plus};

/// Smoothing width of the ring's normal load ⟨T − m_r ṡ²⟩₊, N.
const RING_LOAD_SMOOTHING: f64 = 1.0;

/// Part of the ring's tension that presses it on the elements, N: less what keeps its own mass on the curve at ṡ, m/s.
#[inline(always)]
pub(crate) fn pressing<T: Real>(ring: &Ring, tension: T, s_dot: T) -> T {
    tension - s_dot * s_dot * ring.mass_per_length
}

/// The same where it is no pull, N.
#[inline(always)]
pub(crate) fn ring_load<T: Real>(pressing: T) -> T {
    smooth_plus(pressing, RING_LOAD_SMOOTHING).0
}

/// Friction of the ring on elements per dξ, N/m, under the tension `pressing`, N, where it slides at `sliding`, m/s.
#[inline(always)]
pub(crate) fn ring_friction<T: Real>(friction: &Friction, pressing: T, kappa: T, sliding: T) -> T {
    let load = ring_load(pressing);
    let v0 = friction.velocity;
    let (_, inverse_speed) = (sliding * sliding + v0 * v0).root_and_inverse();
    load * kappa * friction.ring * sliding * inverse_speed
}
