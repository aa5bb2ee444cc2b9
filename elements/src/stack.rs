//! Contact of neighbouring elements at the rocking edge, and the oil between their faces.
//!
//! With the gap g = |p_{i+1} − p_i| − h, its rate ġ along the chord, K = k_e/h and the roughness ρ,
//!
//! Q = K (⟨−g⟩ − d_e H ġ) − S(c ġ), c = C/(h_0 + g₊)³,
//!
//! - ⟨x⟩ = ρ ln(1 + e^{x/ρ}), H its slope at −g, g₊ = ⟨−g⟩ + g: no force acts across a gap at rest,
//! - C: oil of viscosity η between parallel faces a × b, a < b, of which the share f is filled
//!   (Reynolds' equation with the pressure of the surroundings at all four edges, within 1 % for
//!   a ≤ b/2): C = f η a³ b (1 − 0.63 a/b). The floor h_0 is that of rough faces in contact,
//! - S(F) = F where the gap closes, F/√(1 + (F/F_c)²) where it opens: the oil cavitates at the
//!   suction F_c.
//!
//! The law of heads is the same, at their height and with a quarter of the oil
//! ([`pitch`](crate::pitch)).
//!
//! The law is linear in the speeds at the end of a step: Q = K (⟨−g⟩ − (Δt + d_e) H ġ) − c' ġ, with
//! c' = S/ġ at the speed of the step before.

use crate::belt::{Belt, Vector, cross, dot};
use crate::{cyclic::Rows, law::Law};
use pushbelt::scalar::{LANES, Lanes, Real, soft_plus_energy};

/// Oil between heads over that between faces, by the cube of their heights.
const HEAD_OIL: f64 = 0.25;

rows! {
    /// Forces of the gaps at the rocking edges, or at the heads; chord i is gap i.
    Stack {
        push: f64, "Q, N.";
        rate: f64, "ġ, m/s.";
        slope: f64, "−∂Q/∂ġ in the step, N·s/m.";
        damping: f64, "Its part by damping of the contact, N·s/m.";
        oil: f64, "Its part by oil, N·s/m.";
    }
}

/// Distance of the points at a `height` of the elements beside chord c, m.
fn distance(belt: &Belt, c: usize, height: f64) -> f64 {
    belt.distance[c] + height * cross(belt.axis[c + 1], belt.axis[c])
}

impl Stack {
    /// The law at the present gaps and speeds of the elements, at a `height` above their edges, m.
    pub fn evaluate(&mut self, law: &Law, dt: f64, belt: &Belt, height: f64) {
        let gaps = law.count + 1;
        cut!(gaps; belt => normal, offset);
        let thickness = &law.thicknesses[..gaps];
        cut!(gaps + 1; belt => v, t, spin);
        cut!(gaps; mut self => push, rate, slope, damping, oil);
        // The overlap, which the push force then replaces.
        for c in 0..gaps {
            push[c] = thickness[c] - distance(belt, c, height);
            rate[c] = dot(v[c + 1] * t[c + 1] - v[c] * t[c], normal[c]) - offset[c] * spin[c + 1]
                + height * (spin[c + 1] - spin[c]);
        }
        let (elements, stiffness) = (&law.parameters.belt, law.push_stiffness);
        let share = if height > 0.0 { HEAD_OIL } else { 1.0 };
        for from in (0..gaps).step_by(LANES) {
            let many = LANES.min(gaps - from);
            let pack = |of: &[f64]| Lanes::new(std::array::from_fn(|k| of[from + k.min(many - 1)]));
            let (overlap, approaching) = (pack(push), pack(rate));
            let closing = overlap.soft_plus(elements.roughness);
            let (closed, touching) = (closing.value, closing.slope);
            let by_oil = law.oil.coefficient(closed - overlap, approaching) * share;
            let touching = touching * stiffness;
            let total = touching * (dt + elements.damping) + by_oil;
            for (row, value) in [
                (&mut *damping, touching * elements.damping),
                (oil, by_oil),
                (slope, total),
                (push, closed * stiffness - total * approaching),
            ] {
                row[from..from + many].copy_from_slice(&value.to_array()[..many]);
            }
        }
    }

    /// Elastic energy, J.
    pub fn energy(law: &Law, belt: &Belt, height: f64) -> f64 {
        let overlap = |c| law.thicknesses[c] - distance(belt, c, height);
        let of = |c| soft_plus_energy(overlap(c), law.parameters.belt.roughness);
        law.push_stiffness * (1..=law.count).map(of).sum::<f64>()
    }

    /// Powers of oil and of the contact's damping, W.
    pub fn losses(&self) -> [f64; 2] {
        [&self.oil, &self.damping].map(|of| {
            let powers = of.iter().zip(&self.rate).skip(1);
            powers.map(|(of, rate)| of * rate * rate).sum()
        })
    }

    /// Adds the gaps' part to the equations of V: their slopes to `diagonal`, `off`, the push
    /// forces along t to `right`.
    pub fn rows(&self, law: &Law, belt: &Belt, [diagonal, off, right]: Rows<'_>) {
        let n = law.count;
        cut!(n + 1; self => push, slope);
        cut!(n + 1; belt => normal, t);
        let (diagonal, off, right) = (&mut diagonal[..n], &mut off[..n], &mut right[..n]);
        for k in 0..n {
            let i = k + 1;
            let pushed = |c: usize| push[c] * dot(normal[c], t[i]);
            diagonal[k] += slope[i] + slope[k];
            off[k] -= slope[i];
            right[k] += pushed(k) - pushed(i);
        }
    }

    /// The push forces after speeds have changed by `change`, with its copies.
    pub fn correct(&mut self, change: &[Vector]) {
        for (c, pair) in change.windows(2).enumerate() {
            let rise = pair[1].re - pair[0].re;
            self.push[c] -= self.slope[c] * rise;
            self.rate[c] += rise;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::belt::{chords, close};
    use crate::oil::Oil;
    use crate::{Options, cyclic::Tridiagonal, near};

    /// Elements in a straight row along x, with forces on them. The gap from the last to the first
    /// is far from contact.
    struct Straight {
        law: Law,
        dt: f64,
        belt: Belt,
        force: Vec<f64>,
        stack: Stack,
    }

    impl Straight {
        fn new(law: Law, dt: f64, gap: f64) -> Self {
            let n = law.count;
            let mut belt = Belt::new(n);
            belt.t.fill(1.0.into());
            belt.p = (0..n + 2).map(|i| (i as f64 * (law.thickness + gap)).into()).collect();
            Self {
                force: vec![0.0; n],
                stack: Stack::new(n),
                law,
                dt,
                belt,
            }
        }

        fn evaluate(&mut self) {
            chords(&self.belt.p, &mut self.belt.normal, &mut self.belt.distance);
            self.stack.evaluate(&self.law, self.dt, &self.belt, 0.0);
        }

        fn step(&mut self) {
            let n = self.law.count;
            close(&mut self.belt.p);
            close(&mut self.belt.v);
            self.evaluate();
            let (mut diagonal, mut off) = (vec![self.law.mass / self.dt; n], vec![0.0; n]);
            let mut change = self.force.clone();
            let rows = [&mut diagonal[..], &mut off, &mut change];
            self.stack.rows(&self.law, &self.belt, rows);
            Tridiagonal::new(n).solve(&diagonal, &off, &mut change);
            for (k, change) in change.into_iter().enumerate() {
                self.belt.v[k + 1] += change;
                self.belt.p[k + 1] += self.dt * self.belt.v[k + 1];
            }
        }
    }

    fn law(count: usize, oil: Oil) -> Law {
        let law = crate::law(count, &Options::default());
        Law { oil, ..law }
    }

    fn oil(squeeze: f64) -> Oil {
        Oil::of_squeeze(squeeze, 6.0e-6, 1.5e-3, 19.0)
    }

    /// √(k_e/m_e) = 2742 m/s.
    #[test]
    fn a_pulse_in_a_straight_stack_travels_at_the_speed_of_its_waves() {
        let mut row = Straight::new(law(400, oil(0.0)), 1.0e-8, -5.0e-6);
        row.law.parameters.belt.damping = 0.0;
        let middle = 200.5;
        for (i, v) in row.belt.v.iter_mut().enumerate() {
            v.re = 1.0e-3 * (-((i as f64 - middle) / 10.0).powi(2)).exp();
        }
        let elements = 70.0;
        let speed = (1.0e7_f64 / 1.33).sqrt();
        assert!((speed - 2742.0).abs() < 0.5);
        let steps = (elements * row.law.thickness / speed / row.dt).round() as usize;
        (0..steps).for_each(|_| row.step());
        let pulse = row.belt.v.iter().enumerate().take(310).skip(235);
        let [sum, moment] = pulse.fold([0.0; 2], |[sum, moment], (i, v)| {
            [sum + v.re, moment + v.re * (i as f64 - middle)]
        });
        near(moment / sum, elements, 0.01);
    }

    /// A constant force F closes a gap: 1/(h_0 + g)² = 1/(h_0 + g_0)² + 2 F t/C.
    #[test]
    fn a_gap_closes_over_oil_as_reynolds_says() {
        let oil = oil(75.0);
        let (start, force) = (50.0e-6, 1.0);
        let mut row = Straight::new(law(7, oil), 1.0e-7, start);
        row.law.parameters.belt.roughness = 1.0e-9;
        // The first two approach, without inertia at the start; the others are far.
        (row.force[0], row.force[1]) = (force, -force);
        row.belt.v[1].re = 0.5 * force * (start + oil.floor).powi(3) / oil.constant;
        row.belt.v[2] = -row.belt.v[1];
        for i in 3..9 {
            row.belt.p[i] += 1.0e-2 * (i - 2) as f64;
        }
        let steps = 56_000;
        (0..steps).for_each(|_| row.step());
        let gap = row.belt.p[2].re - row.belt.p[1].re - row.law.thickness;
        let wide = |gap: f64| (oil.floor + gap).powi(-2);
        let time = f64::from(steps) * row.dt;
        let expected = (wide(start) + 2.0 * force * time / oil.constant).powf(-0.5) - oil.floor;
        assert!(gap < 0.5 * start);
        near(gap, expected, 0.01);
    }

    /// Reynolds' series for a rectangle: F = C ġ/g³. 75 N·s at 6 µm are about a tenth of it.
    #[test]
    fn the_constant_of_a_rectangle_is_that_of_the_series() {
        let (a, b) = (8.0e-3_f64, 24.0e-3_f64);
        let pi = std::f64::consts::PI;
        let terms = (0..60).map(|k| {
            let n = f64::from(2 * k + 1);
            let half = n * pi * b / (2.0 * a);
            (1.0 - half.tanh() / half) * 96.0 / (n * pi).powi(4)
        });
        let series = terms.sum::<f64>();
        near(1.0 - 0.63 * a / b, series, 0.01);
        let full = 0.01 * a.powi(3) * b * series;
        near(oil(75.0).constant, 0.1 * full, 0.15);
    }

    /// The suction never exceeds that at which oil cavitates.
    #[test]
    fn oil_cavitates() {
        let oil = oil(75.0);
        for rate in [1e-4, 1e-2, 1.0, 100.0] {
            assert!(oil.coefficient(0.0, rate) * rate <= oil.suction);
            assert!(oil.coefficient(0.0, -rate) * rate >= oil.coefficient(0.0, rate) * rate);
        }
    }

    /// −∂Q/∂ġ and −Δt ∂Q/∂g by differences.
    #[test]
    fn the_slope_of_a_step_is_that_of_the_law() {
        let dt = 2.0e-6;
        let push = |gap: f64, rate: f64, dt: f64| {
            let mut row = Straight::new(law(7, oil(0.0)), dt, gap);
            row.belt.v[2].re = rate;
            row.evaluate();
            (row.stack.push[1], row.stack.slope[1])
        };
        for gap in [-2.0e-6, -1.0e-7, 0.0, 1.0e-7] {
            let (_, slope) = push(gap, 0.0, dt);
            let by_rate = -(push(gap, 1e-3, 0.0).0 - push(gap, -1e-3, 0.0).0) / 2e-3;
            let by_gap = -(push(gap + 1e-11, 0.0, 0.0).0 - push(gap - 1e-11, 0.0, 0.0).0) / 2e-11;
            near(slope, by_rate + dt * by_gap, 1e-5);
        }
    }
}
