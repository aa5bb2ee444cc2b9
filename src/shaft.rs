//! Drag of a pulley's shaft by seals, oil and bearings: a law without state.
//!
//! T_d = tanh(ω/ω₀) (T₀ + μ_b r_b R) + b ω, against the rotation, with T₀ of the seals, b of the
//! oil, and R, N, the resultant of all contact forces of the belt on the pulley, which the bearings
//! carry with the friction μ_b at their mean radius r_b. It is zero at a standstill, and an
//! estimate for some 100 to 6000 rpm.

/// ω₀, rad/s: 20 rpm.
pub const SPEED_SMOOTHING: f64 = 2.0;

/// Smoothing width of R at zero load, N.
const RESULTANT_SMOOTHING: f64 = 1.0;

/// Parameters of the drag of a shaft.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ShaftDrag {
    /// Torque T₀ that depends neither on speed nor on load, N·m.
    pub constant: f64,
    /// Viscous coefficient b, N·m·s/rad.
    pub viscous: f64,
    /// Friction coefficient μ_b of the bearings.
    pub bearing_friction: f64,
    /// Mean radius r_b of the bearings, m.
    pub bearing_radius: f64,
}

/// Drag torque of a shaft, with its derivatives.
#[derive(Clone, Copy, Debug)]
pub struct Drag {
    /// Torque, N·m, positive where it acts against a positive speed.
    pub torque: f64,
    /// Derivative with respect to the angular speed, N·m·s/rad.
    pub by_speed: f64,
    /// Derivatives with respect to the components of the resultant, m.
    pub by_resultant: [f64; 2],
}

impl ShaftDrag {
    /// The drag at the angular speed `omega`, rad/s, under contact forces whose resultant is `[x,
    /// y]`, N.
    #[must_use]
    pub fn loads(&self, omega: f64, [x, y]: [f64; 2]) -> Drag {
        let square = x * x + y * y;
        let smooth = (square + RESULTANT_SMOOTHING * RESULTANT_SMOOTHING).sqrt();
        let lever = self.bearing_friction * self.bearing_radius;
        // R = F²/√(F² + δ²), and ∂R/∂F_x = F_x (F² + 2δ²)/√(F² + δ²)³.
        let steepness = (1.0 + (RESULTANT_SMOOTHING / smooth).powi(2)) / smooth;
        let direction = (omega / SPEED_SMOOTHING).tanh();
        let loaded = self.constant + lever * square / smooth;
        Drag {
            torque: direction * loaded + self.viscous * omega,
            by_speed: (1.0 - direction * direction) / SPEED_SMOOTHING * loaded + self.viscous,
            by_resultant: [x, y].map(|force| direction * lever * steepness * force),
        }
    }
}
