//! Drag of a pulley's shaft by seals, oil and bearings: a law without state.
//!
//! T_d = tanh(ω/ω₀) (T₀ + μ_b r_b R) + b ω, against the rotation.
//!
//! - T₀, N·m: seals, independent of speed; b, N·m·s/rad: oil,
//! - R, N: the resultant of all contact forces of the belt on the pulley, which the bearings carry. The centripetal
//!   force of the belt's own mass does not act on the pulley and is not in R,
//! - μ_b, r_b, m: friction coefficient of the bearings, at their mean radius,
//! - ω₀: regularisation speed; the drag is zero at a standstill, and sticking bearings are not modelled.
//!
//! Friction of rolling bearings grows more slowly with speed than b ω, and with load slightly faster than μ_b R; the law is
//! an estimate for some 100 to 6000 rpm.

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
    /// The drag at the angular speed `omega`, rad/s, under contact forces whose resultant is `[x, y]`, N.
    #[must_use]
    pub fn at(&self, omega: f64, [x, y]: [f64; 2]) -> Drag {
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

#[cfg(test)]
mod tests {
    use super::*;

    const DRAG: ShaftDrag = ShaftDrag {
        constant: 0.15,
        viscous: 5.0e-4,
        bearing_friction: 1.8e-3,
        bearing_radius: 0.02,
    };

    #[test]
    fn figures() {
        // 2000 rpm under 3 and 4 kN: seals, bearings, oil.
        let drag = DRAG.at(209.44, [3.0e3, -4.0e3]).torque;
        assert!(
            (drag - (0.15 + 3.6e-5 * 5.0e3 + 5.0e-4 * 209.44)).abs() < 1e-8,
            "{drag}"
        );
        assert_eq!(DRAG.at(-209.44, [3.0e3, -4.0e3]).torque, -drag);
        // At a standstill and far beyond any speed.
        assert_eq!(DRAG.at(0.0, [0.0; 2]).torque, 0.0);
        assert!((DRAG.at(1.0e4, [0.0; 2]).torque - 5.15).abs() < 1e-12);
        assert_eq!(ShaftDrag::default().at(209.44, [3.0e3, -4.0e3]).torque, 0.0);
    }

    #[test]
    fn slopes_are_those_of_differences() {
        for omega in [-150.0, -1.0, 0.0, 0.5, 3.0, 1.0e3] {
            for resultant in [[0.0, 0.0], [0.3, -0.8], [2.0e3, 500.0]] {
                let Drag {
                    by_speed, by_resultant, ..
                } = DRAG.at(omega, resultant);
                let difference = |h: f64, along: [f64; 3]| {
                    let at = |h: f64| {
                        let [x, y] = [0, 1].map(|k| resultant[k] + h * along[k + 1]);
                        DRAG.at(omega + h * along[0], [x, y]).torque
                    };
                    (at(h) - at(-h)) / (2.0 * h)
                };
                let differences = [
                    difference(1e-4, [1.0, 0.0, 0.0]),
                    difference(1e-3, [0.0, 1.0, 0.0]),
                    difference(1e-3, [0.0, 0.0, 1.0]),
                ];
                let exact = [by_speed, by_resultant[0], by_resultant[1]];
                for (exact, found) in exact.into_iter().zip(differences) {
                    assert!((exact - found).abs() < 1e-9, "{omega} {resultant:?}: {exact} {found}");
                }
            }
        }
    }
}
