//! Tilt of a loaded sheave, first by its clearance, then by bending: a law without state.
//!
//! The movable sheave tilts on its shaft by the clearance ψ_c; beyond it shaft, hub and disc bend.
//! With a = √(ψ_x² + ψ_y² + δ²) the moment along ψ is
//!
//! M(a) = k [s a + (1 − s) ⟨a − ψ_c⟩₊], s = 0.02, δ = 0.02 ψ_c, ⟨·⟩₊ smoothed over 0.05 ψ_c,
//!
//! and the moment vector M ψ/a has a potential. Without clearance the law is linear, k ψ. Under the
//! moment m the tilt relaxes with the time constant τ: (M/a)(ψ + τ ψ̇) = m.
//!
//! The defaults follow, under a uniform pressure, from Sattler's Δ = (1 + 0.02 (F/kN − 20))·1e-3
//! (|ψ| ≈ 1.02 Δ at β = 11°), fitted to measured shifts (Carbone, Mangialardi, Bonsen, Tursi,
//! Veenhuizen 2007).

use crate::scalar::{Real, smooth_plus_energy};

/// Tilt stiffness from which a sheave is treated as rigid, independent of its clearance, N·m/rad.
pub const RIGID_TILT_STIFFNESS: f64 = 1e12;

/// Stiffness within the clearance, as a fraction of k.
const SOFT: f64 = 0.02;
/// δ, and the smoothing width of the end of the clearance, as fractions of the clearance.
const ROUNDING: f64 = 0.02;
const BEARING: f64 = 0.05;

/// Parameters of the tilt of one sheave.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tilt {
    /// Stiffness k beyond the clearance, N·m/rad.
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
        let beyond = (amplitude - self.clearance).smooth_plus(BEARING * self.clearance).value;
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
        let stored = |amplitude: f64| {
            smooth_plus_energy(amplitude - self.clearance, BEARING * self.clearance, self.clearance)
        };
        let beyond = stored(self.amplitude(psi)) - stored(ROUNDING * self.clearance);
        self.stiffness * (0.5 * SOFT * square + (1.0 - SOFT) * beyond)
    }
}
