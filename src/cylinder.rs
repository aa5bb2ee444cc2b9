//! Hydraulic cylinder of a pulley: a law without state. Its axial force closes the pulley:
//!
//! F = p A + F₀ − k z + c ω² − S ż/√(ż² + v₀²).
//!
//! - p, Pa: pressure of the oil above ambient; A, m²: area of the piston,
//! - F₀ − k z: spring; z = 0 at ratio 1,
//! - c ω²: oil that turns with the pulley; beyond full compensation c < 0,
//! - S: friction of the seals, with the regularisation of the flanks' friction.

use crate::scalar::Real;

/// Parameters of the cylinder of a pulley.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cylinder {
    /// Area A of the piston, m².
    pub area: f64,
    /// Force F₀ of the spring at ratio 1, N.
    pub spring_force: f64,
    /// Stiffness k of the spring, N/m.
    pub spring_stiffness: f64,
    /// Axial force c of the rotating oil per square of the angular speed, N·s²/rad².
    pub centrifugal: f64,
    /// Friction S of the seals, N.
    pub seal: f64,
}

impl Cylinder {
    /// Force of spring and rotating oil at position `z`, m, and angular speed `omega`, rad/s.
    #[inline]
    pub fn passive_force<T: Real>(&self, z: T, omega: T) -> T {
        -z * self.spring_stiffness + self.spring_force + omega * omega * self.centrifugal
    }

    /// Friction of the seals along the speed `z_dot`, m/s, which it opposes; `velocity` = v₀, m/s.
    #[inline]
    pub fn drag<T: Real>(&self, z_dot: T, velocity: f64) -> T {
        let (_, inverse) = (z_dot * z_dot + velocity * velocity).root_and_inverse();
        z_dot * inverse * self.seal
    }

    /// Energy of the spring, J.
    #[must_use]
    pub fn energy(&self, z: f64) -> f64 {
        (0.5 * self.spring_stiffness * z - self.spring_force) * z
    }
}
