//! Contact of neighbouring elements at the rocking edge, and the oil between their faces.
//!
//! With the gap g = |p_{i+1} − p_i| − h, its rate ġ along the chord, K = k_e/h and the roughness ρ,
//!
//! Q = K (⟨−g⟩ − d_e H ġ) − S(c ġ), c = C/(h_0 + g₊)³,
//!
//! - ⟨x⟩ = ρ ln(1 + e^{x/ρ}), H its slope at −g, g₊ = ⟨−g⟩ + g: no force acts across a gap at rest,
//! - C: oil of viscosity η between parallel faces a × b, a < b, of which the share f is filled (Reynolds' equation with the
//!   pressure of the surroundings at all four edges, within 1 % for a ≤ b/2): C = f η a³ b (1 − 0.63 a/b). The floor h_0 is
//!   the distance of rough faces in contact,
//! - S(F) = F in closing, F/√(1 + (F/F_c)²) in opening: the oil cavitates at the suction F_c.
//!
//! The law is linear in the speeds at the end of a step: Q = K (⟨−g⟩ − (Δt + d_e) H ġ) − c' ġ, with c' = S/ġ at the speed of
//! the step before.

use crate::frames::{Chords, Frames};
use crate::law::Law;
use pushbelt::scalar::{LANES, Lanes, Real, soft_plus_energy};

/// Oil between two elements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Oil {
    /// C, N·s·m².
    pub constant: f64,
    /// h_0, m.
    pub floor: f64,
    /// F_c, N.
    pub suction: f64,
}

impl Oil {
    /// Oil with the viscosity `eta`, Pa·s, between faces of `sides`, m, that it fills to the share `fill`.
    #[must_use]
    pub fn between_faces(eta: f64, sides: [f64; 2], fill: f64, floor: f64) -> Self {
        let [a, b] = [sides[0].min(sides[1]), sides[0].max(sides[1])];
        Self {
            constant: fill * eta * a.powi(3) * b * (1.0 - 0.63 * a / b),
            floor,
            suction: a * b * 1.0e5,
        }
    }

    /// Oil with the force `squeeze`, N·s, per rate of strain of elements of `thickness` at zero gap.
    #[must_use]
    pub fn of_squeeze(squeeze: f64, floor: f64, thickness: f64, suction: f64) -> Self {
        Self {
            constant: squeeze / thickness * floor.powi(3),
            floor,
            suction,
        }
    }

    /// c' at the gap and its rate.
    #[inline(always)]
    fn coefficient<T: Real>(&self, gap: T, rate: T) -> T {
        let wide = gap + self.floor;
        let c = (wide * wide * wide).recip() * self.constant;
        let share = c * rate * (1.0 / self.suction);
        let (_, limited) = (share * share + 1.0).root_and_inverse();
        c * rate.if_positive(limited, T::one())
    }
}

/// 75 N·s at a floor of 6 µm, a tenth of what oil of 10 mPa·s between faces of 8 by 24 mm would give; 19 N.
impl Default for Oil {
    fn default() -> Self {
        Self::of_squeeze(75.0, 6.0e-6, 1.5e-3, 19.0)
    }
}

/// Forces of the gaps; chord i is gap i.
#[derive(Clone, Debug)]
pub struct Stack {
    /// Q, N.
    pub push: Vec<f64>,
    /// ġ, m/s.
    pub rate: Vec<f64>,
    /// −∂Q/∂ġ in the step, N·s/m.
    pub slope: Vec<f64>,
    /// Its part by damping of the contact, N·s/m.
    pub damping: Vec<f64>,
    /// Its part by oil, N·s/m.
    pub oil: Vec<f64>,
}

impl Stack {
    /// For `n` elements.
    #[must_use]
    pub fn new(n: usize) -> Self {
        let zero = || vec![0.0; n + LANES + 2];
        Self {
            push: zero(),
            rate: zero(),
            slope: zero(),
            damping: zero(),
            oil: zero(),
        }
    }

    /// The law at the present gaps, with the speeds `v`, `u` of the elements.
    pub fn evaluate(&mut self, law: &Law, dt: f64, chords: &Chords, frames: &Frames, [v, u]: [&[f64]; 2]) {
        let gaps = law.count + 1;
        let (cx, cy, length) = (&chords.x[..gaps], &chords.y[..gaps], &chords.length[..gaps]);
        let (tx, ty) = (&frames.tx[..gaps + 1], &frames.ty[..gaps + 1]);
        let (v, u) = (&v[..gaps + 1], &u[..gaps + 1]);
        for i in 0..gaps {
            let along = |k: usize| {
                let (t, o) = (tx[k] * cx[i] + ty[k] * cy[i], tx[k] * cy[i] - ty[k] * cx[i]);
                v[k] * t + u[k] * o
            };
            self.rate[i] = along(i + 1) - along(i);
        }
        let (stiffness, damping) = (law.push_stiffness, law.push_damping);
        for from in (0..gaps).step_by(LANES) {
            let pack = |of: &[f64]| Lanes::new(std::array::from_fn(|k| of[(from + k).min(gaps - 1)]));
            let (overlap, rate) = (-pack(length) + law.thickness, pack(&self.rate));
            let [closed, slope, _] = overlap.soft_plus(law.roughness);
            let oil = law.oil.coefficient(closed - overlap, rate);
            let touching = slope * stiffness;
            let total = touching * (dt + damping) + oil;
            let push = closed * stiffness - total * rate;
            for (row, value) in [
                (&mut self.damping, touching * damping),
                (&mut self.oil, oil),
                (&mut self.slope, total),
                (&mut self.push, push),
            ] {
                row[from..from + LANES].copy_from_slice(&value.to_array());
            }
        }
    }

    /// Elastic energy of a gap whose chord has this length, m: J.
    #[must_use]
    pub fn energy(law: &Law, length: f64) -> f64 {
        law.push_stiffness * soft_plus_energy(law.thickness - length, law.roughness)
    }
}
