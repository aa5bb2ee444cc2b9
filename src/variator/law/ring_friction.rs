//! Friction between ring and elements, and between the layers of the ring (`docs/theory.md`, (4.10)
//! and (4.11)).
//!
//! The elements slide on the innermost layer, whose neutral line is e₁ = e − (n − 1) t/2 outside
//! the pitch line. Friction f on the ring has the virtual power f δ(t̂·ṙ + w |r'| − V λ₁/λ): λ₁/λ f
//! acts on V.

use crate::contact::Friction;
use crate::ring::layers;
use crate::scalar::Real;

/// Smoothing width of ⟨T − m_r ṡ²⟩₊, N, and of the contact force, N/m.
const RING_LOAD_SMOOTHING: f64 = 1.0;

/// Part T − m_r ṡ² of the ring's tension that presses its layers on each other, N.
#[inline(always)]
pub fn pressing<T: Real>(mass_per_length: f64, tension: T, s_dot: T) -> T {
    tension - s_dot * s_dot * mass_per_length
}

/// Friction of the ring on elements per dξ under their contact force `load`, N/m, at the sliding
/// speed, m/s.
#[inline(always)]
pub fn ring_friction<T: Real>(friction: &Friction, load: T, sliding: T) -> T {
    let v0 = friction.ring_velocity;
    let (_, inverse_speed) = (sliding * sliding + v0 * v0).root_and_inverse();
    load.smooth_plus(RING_LOAD_SMOOTHING).value * friction.ring * sliding * inverse_speed
}

/// Drag of the ring's layers per dξ, N/m, at the tension [`pressing`], N, and the speed of the ring
/// along itself, m/s, with one of [`drag_coefficients`](layers::Layers::drag_coefficients).
#[inline(always)]
pub fn layer_drag<T: Real>(coefficient: T, pressing: T, kappa: T, speed: T) -> T {
    coefficient * pressing.smooth_plus(RING_LOAD_SMOOTHING).value * kappa * layers::direction(speed)
}
