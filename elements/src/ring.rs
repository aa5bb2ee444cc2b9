//! The ring: one node an element, which slides along the steel.
//!
//! Node i is at c_i = p_i + e o_i and at the place S_i of the steel, Ṡ_i = (V_i + e Ω_i − w_i)/λ_i, where w is the speed of the
//! steel along t and λ its stretch. Across, the steel moves with its element. With the chords r_i from c_i to c_{i+1}, of length R_i,
//! the normals n_i inward of them, ΔS_i = S_{i+1} − S_i, and the steel's velocity w t + U o, in which D is a rate:
//!
//! - tension T_i = EA (ε + η Dε), ε = R_i/ΔS_i − 1, moment M_i = EI (κ + η_κ Dκ), κ_i the angle from r_{i−1} to r_i over
//!   ½(ΔS_{i−1} + ΔS_i),
//! - force on node i: F_i = T_i r_i − T_{i−1} r_{i−1} + X_{i−1} n_{i−1} − X_i n_i, shear X_i = (M_{i+1} − M_i)/R_i,
//! - along the belt m_i (ẇ + U Ω) = F·t − q; across, F·o and the inertia m_i act on the element,
//! - the true contact force N = −F·o − m_i w Ω_r, which is T κ − EI κ'' − m_r w² κ, with the turning Ω_r = Ω − Ṡ κ of the
//!   steel,
//! - friction of the ring on the element at the lever e_1: q = μ_r ⟨N − N_0⟩ s/√(s² + v_0²), s = w − V − e_1 Ω, N_0 = 0. Its couple e_1 q about
//!   the rocking edge acts on both neighbours, ∓(e_1 q/2h) o_i, since they orient the element.
//!
//! All layers have the same mean speed. What layers lose on each other is not in this model.
//! Left out: Ṡ ∂w/∂S beside ẇ.

use crate::frames::{Chords, Frames, close};
use crate::law::Law;

/// Forces of the ring.
#[derive(Clone, Debug)]
pub struct Ring {
    /// Chords between nodes.
    pub chords: Chords,
    cx: Vec<f64>,
    cy: Vec<f64>,
    /// T, N, of each chord.
    pub tension: Vec<f64>,
    /// ∂T_i/∂w_{i+1} = −∂T_i/∂w_i in the step, N·s/m.
    pub slope: Vec<f64>,
    /// ΔS, m.
    pub steel: Vec<f64>,
    /// Rate of stretch ε̇ ΔS, m/s.
    pub rate: Vec<f64>,
    /// M, N·m, of each node.
    moment: Vec<f64>,
    /// Angle between the chords of a node, rad.
    pub angle: Vec<f64>,
    /// Its rate, rad/s.
    pub angle_rate: Vec<f64>,
    turning: Vec<f64>,
    /// F·t, N.
    pub along: Vec<f64>,
    /// F·o, N.
    pub across: Vec<f64>,
    /// N, N.
    pub contact: Vec<f64>,
    /// q/s, N·s/m.
    pub friction: Vec<f64>,
    /// q, N, on the element.
    pub drag: Vec<f64>,
    /// m, kg.
    pub mass: Vec<f64>,
    /// Ω_r, rad/s.
    pub turn: Vec<f64>,
}

impl Ring {
    /// For `n` elements.
    #[must_use]
    pub fn new(n: usize) -> Self {
        let zero = || vec![0.0; n + 2];
        Self {
            chords: Chords::new(n),
            cx: zero(),
            cy: zero(),
            tension: zero(),
            slope: zero(),
            steel: zero(),
            rate: zero(),
            moment: zero(),
            angle: zero(),
            angle_rate: zero(),
            turning: zero(),
            along: zero(),
            across: zero(),
            contact: zero(),
            friction: zero(),
            drag: zero(),
            mass: zero(),
            turn: zero(),
        }
    }

    /// Places of the nodes and the chords between them.
    pub fn place(&mut self, law: &Law, frames: &Frames, [x, y]: [&[f64]; 2]) {
        let e = law.ring.offset;
        let n = law.count + 2;
        let (x, y, tx, ty) = (&x[..n], &y[..n], &frames.tx[..n], &frames.ty[..n]);
        let (cx, cy) = (&mut self.cx[..n], &mut self.cy[..n]);
        for i in 0..n {
            (cx[i], cy[i]) = (x[i] - e * ty[i], y[i] + e * tx[i]);
        }
        self.chords.evaluate(&self.cx, &self.cy);
    }

    /// Tension, moments and forces at the speeds of the step before.
    pub fn evaluate(&mut self, law: &Law, dt: f64, frames: &Frames, [v, u, w, s]: [&[f64]; 4]) {
        let (n, ring) = (law.count, &law.ring);
        let (tx, ty) = (&frames.tx[..n + 2], &frames.ty[..n + 2]);
        let (rx, ry, length) = (
            &self.chords.x[..n + 1],
            &self.chords.y[..n + 1],
            &self.chords.length[..n + 1],
        );
        let (v, u, w, s) = (&v[..n + 2], &u[..n + 2], &w[..n + 2], &s[..n + 2]);
        let (ea, seen) = (ring.axial_stiffness, ring.damping + dt);
        {
            let (tension, slope) = (&mut self.tension[..n + 1], &mut self.slope[..n + 1]);
            let (steel, rate, turning) = (
                &mut self.steel[..n + 1],
                &mut self.rate[..n + 1],
                &mut self.turning[..n + 1],
            );
            for i in 0..=n {
                let velocity = |k: usize| (w[k] * tx[k] - u[k] * ty[k], w[k] * ty[k] + u[k] * tx[k]);
                let (a, b) = (velocity(i), velocity(i + 1));
                let (dx, dy) = (b.0 - a.0, b.1 - a.1);
                let inverse = 1.0 / (s[i + 1] - s[i]);
                steel[i] = s[i + 1] - s[i];
                rate[i] = dx * rx[i] + dy * ry[i];
                turning[i] = (dx * ry[i] - dy * rx[i]) / length[i];
                slope[i] = ea * seen * inverse;
                tension[i] = ea * (length[i] * inverse - 1.0) + slope[i] * rate[i];
            }
        }
        {
            let (steel, turning) = (&self.steel[..n + 1], &self.turning[..n + 1]);
            let (moment, angle, angle_rate, mass) = (
                &mut self.moment[..n + 1],
                &mut self.angle[..n + 1],
                &mut self.angle_rate[..n + 1],
                &mut self.mass[..n + 1],
            );
            let seen = ring.curvature_damping + dt;
            for i in 1..=n {
                let share = 0.5 * (steel[i - 1] + steel[i]);
                angle[i] = ry[i - 1] * rx[i] - rx[i - 1] * ry[i];
                angle_rate[i] = turning[i] - turning[i - 1];
                moment[i] = ring.bending_stiffness / share * (angle[i] + seen * angle_rate[i]);
                mass[i] = ring.mass_per_length * share;
            }
        }
        close(&mut self.moment);
        // Shear, in the array that is free now.
        let (shear, moment) = (&mut self.turning[..n + 1], &self.moment[..n + 2]);
        for i in 0..=n {
            shear[i] = (moment[i + 1] - moment[i]) / length[i];
        }
        let (shear, tension) = (&self.turning[..n + 1], &self.tension[..n + 1]);
        let (along, across, turn) = (
            &mut self.along[..n + 1],
            &mut self.across[..n + 1],
            &mut self.turn[..n + 1],
        );
        let (angle, mass) = (&self.angle[..n + 1], &self.mass[..n + 1]);
        let friction = &mut self.friction[..n + 1];
        let contact = &self.contact[..n + 1];
        let (per_step, v0) = (1.0 / dt, law.friction.ring_velocity);
        for i in 1..=n {
            let fx = tension[i] * rx[i] - tension[i - 1] * rx[i - 1] + shear[i - 1] * ry[i - 1] - shear[i] * ry[i];
            let fy = tension[i] * ry[i] - tension[i - 1] * ry[i - 1] - shear[i - 1] * rx[i - 1] + shear[i] * rx[i];
            along[i] = fx * tx[i] + fy * ty[i];
            across[i] = fy * tx[i] - fx * ty[i];
            let omega = frames.turn[i] * per_step;
            // Ṡ κ; λ is 1 within a thousandth.
            let passing = v[i] + ring.offset * omega - w[i];
            turn[i] = omega - passing * angle[i] * ring.mass_per_length / mass[i];
            let sliding = w[i] - v[i] - ring.lever * omega;
            friction[i] = law.friction.ring * (contact[i] - ring.contact_threshold).max(0.0)
                / (sliding * sliding + v0 * v0).sqrt();
        }
    }

    /// The equations of w: m/Δt + slopes and friction on the `diagonal`, F·t − m U Ω_r − q on the right.
    pub fn rows(&mut self, law: &Law, dt: f64, frames: &Frames, [v, u, w]: [&[f64]; 3], rows: [&mut [f64]; 3]) {
        let (n, lever) = (law.count, law.ring.lever);
        let [diagonal, off, right] = rows.map(|row| &mut row[..n]);
        let per_step = 1.0 / dt;
        let all = n + 2;
        let [v, u, w, turn] = [v, u, w, &frames.turn].map(|row| &row[..all]);
        let [mass, slope, friction] = [&self.mass, &self.slope, &self.friction].map(|row| &row[..all]);
        let [along, ring_turn] = [&self.along, &self.turn].map(|row| &row[..all]);
        for k in 0..n {
            let i = k + 1;
            let sliding = w[i] - v[i] - lever * turn[i] * per_step;
            diagonal[k] = mass[i] * per_step + slope[i] + slope[k] + friction[i];
            off[k] = -slope[i];
            right[k] = along[i] - mass[i] * u[i] * ring_turn[i] - friction[i] * sliding;
        }
    }

    /// The forces after w has changed by `change`, with its copies, to `w`.
    pub fn correct(&mut self, law: &Law, dt: f64, frames: &Frames, [v, w, change]: [&[f64]; 3]) {
        let (n, lever) = (law.count, law.ring.lever);
        let (tx, ty) = (&frames.tx[..n + 2], &frames.ty[..n + 2]);
        let (rx, ry) = (&self.chords.x[..n + 2], &self.chords.y[..n + 2]);
        let all = n + 2;
        let [v, w, change, turn] = [v, w, change, &frames.turn].map(|row| &row[..all]);
        let [slope, mass, friction, own_turn] =
            [&self.slope, &self.mass, &self.friction, &self.turn].map(|row| &row[..all]);
        let (tension, rate, across) = (&mut self.tension[..all], &mut self.rate[..all], &mut self.across[..all]);
        let (contact, drag) = (&mut self.contact[..all], &mut self.drag[..all]);
        let (per_step, first) = (1.0 / dt, change[1] - change[0]);
        let mut before = slope[0] * first;
        tension[0] += before;
        rate[0] += first;
        for i in 1..=n {
            let faster = change[i + 1] - change[i];
            let rise = slope[i] * faster;
            tension[i] += rise;
            rate[i] += faster;
            let outward = |k: usize| ry[k] * tx[i] - rx[k] * ty[i];
            across[i] += rise * outward(i) - before * outward(i - 1);
            before = rise;
            contact[i] = -across[i] - mass[i] * w[i] * own_turn[i];
            drag[i] = friction[i] * (w[i] - v[i] - lever * turn[i] * per_step);
        }
        close(&mut self.drag);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::Options;
    use pushbelt::variator::settings::Parameters;

    /// Forces F·t and F·o on the nodes of a straight row with these speeds.
    fn forces(law: &Law, dt: f64, u: &[f64], w: &[f64]) -> (Vec<f64>, Vec<f64>, Ring) {
        let n = law.count;
        let zero = vec![0.0; n + 2];
        let mut frames = Frames::new(n);
        frames.tx.fill(1.0);
        let x: Vec<_> = (0..n + 2).map(|i| i as f64 * law.thickness).collect();
        let mut ring = Ring::new(n);
        ring.place(law, &frames, [&x, &zero]);
        ring.evaluate(law, dt, &frames, [&zero, u, w, &x]);
        (ring.along.clone(), ring.across.clone(), ring)
    }

    /// The slopes of a step are those of tension with Δt + η and of moments with Δt + η_κ.
    #[test]
    fn slopes_are_differences() {
        let mut law = Law::new(&Parameters::default(), &Options::default()).unwrap();
        law.count = 20;
        let (dt, zero) = (2.0e-6, vec![0.0; 22]);
        let bending = (dt + law.ring.curvature_damping) * law.ring.bending_stiffness / law.thickness.powi(3);
        let mut moved = zero.clone();
        moved[10] = 1.0e-3;
        let (_, across, _) = forces(&law, dt, &moved, &zero);
        for (k, weight) in [1.0, -4.0, 6.0, -4.0, 1.0].into_iter().enumerate() {
            let found = -across[8 + k] / 1.0e-3;
            assert!((found / (bending * weight) - 1.0).abs() < 1e-9, "{k}: {found}");
        }
        let (along, _, ring) = forces(&law, dt, &zero, &moved);
        for (k, weight) in [-1.0, 2.0, -1.0].into_iter().enumerate() {
            let found = -along[9 + k] / 1.0e-3;
            assert!((found / (ring.slope[10] * weight) - 1.0).abs() < 1e-9, "{k}: {found}");
        }
    }
}
