//! Tilt of a loaded sheave, first by its clearance, then by bending: a law without state.
//!
//! The movable sheave slides on its shaft with clearance. Under load it tilts by the clearance ψ_c; beyond ψ_c shaft, hub
//! and disc bend. With a = √(ψ_x² + ψ_y² + δ²) the moment along ψ is
//!
//! M(a) = k [s a + (1 − s) ⟨a − ψ_c⟩₊], s = 0.02, δ = 0.02 ψ_c, ⟨·⟩₊ smoothed over 0.05 ψ_c,
//!
//! and the moment vector M ψ/a has a potential. Some 0.6 kN overcome the soft part s and take up the clearance. Without
//! clearance the law is linear, k ψ. Under the moment m the tilt relaxes with the time constant τ: (M/a)(ψ + τ ψ̇) = m.
//!
//! Both sheaves of a pulley have the same tilt in the model, the mean of the two.
//!
//! The amplitude is that of Sattler's trigonometric law of the groove width: |ψ| = aΔ tan β, a = (1 + cos²β)/sin 2β,
//! has the same variation of radius, so |ψ| ≈ 1.02 Δ at β = 11°. The defaults follow, under a uniform pressure, from
//! Δ = (1 + 0.02 (F/kN − 20))·1e-3, fitted to measured shifts (Carbone, Mangialardi, Bonsen, Tursi, Veenhuizen 2007).

use crate::scalar::{Real, smooth_plus, smooth_plus_energy};

/// Tilt stiffness from which a sheave is treated as rigid, independent of its clearance, N·m/rad.
pub const RIGID_TILT_STIFFNESS: f64 = 1e12;

/// Stiffness within the clearance, as a share of k.
const SOFT: f64 = 0.02;
/// δ, and the smoothing width of the end of the clearance, as shares of the clearance.
const ROUNDING: f64 = 0.02;
const BEARING: f64 = 0.05;

/// Parameters of the tilt of one sheave.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tilt {
    /// Stiffness k beyond the clearance, N·m/rad; from [`RIGID_TILT_STIFFNESS`] on the sheave is rigid.
    pub stiffness: f64,
    /// Clearance ψ_c, rad.
    pub clearance: f64,
    /// Relaxation time τ, s.
    pub time: f64,
}

impl Tilt {
    /// Whether the sheave counts as rigid.
    #[must_use]
    pub fn is_rigid(&self) -> bool {
        self.stiffness >= RIGID_TILT_STIFFNESS
    }

    /// √(ψ_x² + ψ_y² + δ²), rad.
    fn amplitude<T: Real>(&self, [x, y]: [T; 2]) -> T {
        let rounding = ROUNDING * self.clearance;
        (x * x + y * y + rounding * rounding).sqrt()
    }

    /// Secant stiffness M/a at the tilt `psi`, rad: N·m/rad.
    pub fn secant<T: Real>(&self, psi: [T; 2]) -> T {
        if self.clearance == 0.0 {
            return T::from(self.stiffness);
        }
        let amplitude = self.amplitude(psi);
        let (beyond, _) = smooth_plus(amplitude - self.clearance, BEARING * self.clearance);
        beyond / amplitude * ((1.0 - SOFT) * self.stiffness) + SOFT * self.stiffness
    }

    /// Moment at the tilt `psi`, rad, and its rate `rate`, rad/s: (M/a)(ψ + τ ψ̇), N·m.
    pub fn moment<T: Real>(&self, psi: [T; 2], rate: [T; 2]) -> [T; 2] {
        let secant = self.secant(psi);
        std::array::from_fn(|axis| secant * (psi[axis] + rate[axis] * self.time))
    }

    /// Power that relaxation dissipates, W.
    #[must_use]
    pub fn loss(&self, psi: [f64; 2], [x, y]: [f64; 2]) -> f64 {
        self.secant(psi) * self.time * (x * x + y * y)
    }

    /// Stored energy ∫M da, J.
    #[must_use]
    pub fn energy(&self, psi: [f64; 2]) -> f64 {
        let [x, y] = psi;
        let square = x * x + y * y;
        if self.clearance == 0.0 {
            return 0.5 * self.stiffness * square;
        }
        let stored =
            |amplitude: f64| smooth_plus_energy(amplitude - self.clearance, BEARING * self.clearance, self.clearance);
        let beyond = stored(self.amplitude(psi)) - stored(ROUNDING * self.clearance);
        self.stiffness * (0.5 * SOFT * square + (1.0 - SOFT) * beyond)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lever of a uniform pressure at ratio 1 on the laboratory variator, m.
    const LEVER: f64 = 0.0365;

    fn laboratory() -> Tilt {
        Tilt {
            stiffness: 1.79e6,
            clearance: 0.624e-3,
            time: 2e-3,
        }
    }

    /// Tilt under a moment, rad.
    fn tilt_under(law: &Tilt, moment: f64) -> f64 {
        let (mut low, mut high) = (0.0, 0.1);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            let [found, _] = law.moment([middle, 0.0], [0.0; 2]);
            if found < moment { low = middle } else { high = middle }
        }
        low
    }

    #[test]
    fn the_tilt_is_that_of_the_measured_opening() {
        for force in [5e3, 10e3, 20e3, 30e3] {
            let opening = (1.0 + 0.02 * (force / 1e3 - 20.0)) * 1e-3;
            let found = tilt_under(&laboratory(), force * LEVER);
            assert!((found / (1.02 * opening) - 1.0).abs() < 0.01, "{force} N: {found} rad");
        }
    }

    #[test]
    fn the_moment_is_the_slope_of_the_energy_in_every_direction() {
        let linear = Tilt {
            clearance: 0.0,
            ..laboratory()
        };
        for law in [laboratory(), linear] {
            for psi in [[0.0, 0.0], [1e-6, -2e-6], [3e-4, 1e-4], [4e-4, -5e-4], [-9e-4, 8e-4]] {
                let moment = law.moment(psi, [0.0; 2]);
                for axis in 0..2 {
                    let h = 1e-8;
                    let at = |by: f64| {
                        let mut psi = psi;
                        psi[axis] += by;
                        law.energy(psi)
                    };
                    let slope = (at(h) - at(-h)) / (2.0 * h);
                    assert!((slope - moment[axis]).abs() < 1e-3, "{psi:?}: {slope} {}", moment[axis]);
                }
            }
        }
    }
}
