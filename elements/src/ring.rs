//! The ring: one node an element, which slides along the steel.
//!
//! Node i is at c_i = p_i + e o_i and at the place S_i of the steel, Ṡ_i = (V_i + e Ω_i − w_i)/λ_i,
//! where w is the speed of the steel along t and λ its stretch. Across, the steel moves with its
//! element. With the chords r_i from c_i to c_{i+1}, of length R_i, the normals n_i inward of them,
//! ΔS_i = S_{i+1} − S_i, and the steel's velocity w t + U o, in which D is a rate:
//!
//! - tension T_i = EA (ε + η Dε), ε = R_i/ΔS_i − 1, moment M_i = EI (κ + η_κ Dκ), κ_i the angle
//!   from r_{i−1} to r_i over ½(ΔS_{i−1} + ΔS_i),
//! - force on node i: F_i = T_i r_i − T_{i−1} r_{i−1} + X_{i−1} n_{i−1} − X_i n_i,
//!   shear X_i = (M_{i+1} − M_i)/R_i,
//! - along the belt m_i (ẇ + U Ω) = F·t − q; across, F·o and the inertia m_i act on the element,
//! - the true contact force N = −F·o − m_i w Ω_r, which is T κ − EI κ'' − m_r w² κ, with the
//!   turning Ω_r = Ω − Ṡ κ of the steel,
//! - friction of the ring on the element at the lever e_1: q = μ_r ⟨N − N_0⟩ s/√(s² + v_0²),
//!   s = w − V − e_1 Ω, N_0 = 0 (what a strand's vibration rectifies is below 2 N). Its couple
//!   e_1 q about the rocking edge acts on both neighbours, ∓(e_1 q/2h) o_i, since they orient the
//!   element.
//!
//! With free [`pitch`](crate::pitch) Π takes the place of Ω in s, e_1 q acts on the element alone,
//! and the neighbours have the couple of the crown. All layers have the same mean speed. What layers lose on each other is not in this model.
//! Left out: Ṡ ∂w/∂S beside ẇ.

use crate::belt::{Belt, Vector, chords, close, cross, dot};
use crate::{cyclic::Rows, law::Law};

rows! {
    /// Forces of the ring, of its chords and its nodes.
    Ring {
        node: Vector, "c, m.";
        unit: Vector, "Unit vectors r of the chords.";
        length: f64, "R, m, of each chord.";
        tension: f64, "T, N, of each chord.";
        slope: f64, "∂T_i/∂w_{i+1} = −∂T_i/∂w_i in the step, N·s/m.";
        steel: f64, "ΔS, m.";
        rate: f64, "Rate of stretch ε̇ ΔS, m/s.";
        turning: f64, "Turning of each chord, inward, rad/s.";
        shear: f64, "X, N, of each chord.";
        moment: f64, "M, N·m.";
        angle: f64, "Angle between the chords of a node, rad.";
        angle_rate: f64, "Its rate, rad/s.";
        force: Vector, "F·t and F·o, N.";
        contact: f64, "N, N.";
        friction: f64, "q/s, N·s/m.";
        drag: f64, "q, N, on the element.";
        couple: f64, "Couple on the frame of the element, N·m.";
        mass: f64, "m, kg.";
        turn: f64, "Ω_r, rad/s.";
    }
}

impl Ring {
    /// Places of the nodes and the chords between them.
    pub fn place(&mut self, law: &Law, belt: &Belt) {
        let (e, places) = (law.parameters.belt.pitch_offset, belt.p.iter().zip(&belt.t));
        for ((node, (p, t)), pitch) in self.node.iter_mut().zip(places).zip(&belt.pitch) {
            *node = p + Vector::new(0.0, e + law.crown * (1.0 - pitch.cos())) * t;
        }
        chords(&self.node, &mut self.unit, &mut self.length);
    }

    /// Tension, moments and forces at the speeds of the step before.
    pub fn evaluate(&mut self, law: &Law, dt: f64, belt: &Belt) {
        let (n, ring, options) = (law.count, &law.parameters.ring, &law.options);
        let per_step = 1.0 / dt;
        cut!(n + 2; belt => t, v, w, s, pitch, spin, turn);
        cut!(n + 1; self => unit, length);
        cut!(n + 1; mut self => tension, slope, steel, rate, turning);
        for i in 0..=n {
            let lifted = |k: usize| law.crown * pitch[k].sin() * (spin[k] - turn[k] * per_step);
            let velocity = |k: usize| Vector::new(w[k], v[k].im + lifted(k)) * t[k];
            let faster = velocity(i + 1) - velocity(i);
            steel[i] = s[i + 1] - s[i];
            let inverse = 1.0 / steel[i];
            rate[i] = dot(faster, unit[i]);
            turning[i] = cross(faster, unit[i]) / length[i];
            slope[i] = ring.axial_stiffness * (ring.damping + dt) * inverse;
            tension[i] = ring.axial_stiffness * (length[i] * inverse - 1.0) + slope[i] * rate[i];
        }
        cut!(n + 1; mut self => moment, angle, angle_rate, mass);
        for i in 1..=n {
            let fraction = 0.5 * (steel[i - 1] + steel[i]);
            angle[i] = cross(unit[i], unit[i - 1]);
            angle_rate[i] = turning[i] - turning[i - 1];
            let seen = (options.curvature_damping + dt) * angle_rate[i];
            moment[i] = ring.bending_stiffness / fraction * (angle[i] + seen);
            mass[i] = ring.mass_per_length * fraction;
        }
        close(&mut self.moment);
        let moment = &self.moment[..n + 2];
        cut!(n + 1; mut self => shear, force, turn, friction);
        for i in 0..=n {
            shear[i] = (moment[i + 1] - moment[i]) / length[i];
        }
        let contact = &self.contact[..n + 1];
        let v0 = law.parameters.friction.ring_velocity;
        for i in 1..=n {
            let pull = |c: usize| unit[c] * tension[c];
            let across = |c: usize| Vector::new(0.0, shear[c]) * unit[c];
            force[i] = (pull(i) - pull(i - 1) - across(i - 1) + across(i)) * t[i].conj();
            let omega = belt.turn[i] * per_step;
            // Ṡ κ; λ is 1 within a thousandth.
            let passing = v[i].re + law.parameters.belt.pitch_offset * omega - w[i];
            turn[i] = omega - passing * angle[i] * ring.mass_per_length / mass[i];
            let sliding = w[i] - v[i].re - law.lever * belt.spin[i];
            let pressed = (contact[i] - options.contact_threshold).max(0.0);
            friction[i] = law.parameters.friction.ring * pressed / (sliding * sliding + v0 * v0).sqrt();
        }
    }

    /// The equations of w: m/Δt + slopes and friction on the `diagonal`, F·t − m U Ω_r − q on the
    /// right.
    pub fn rows(&self, law: &Law, dt: f64, belt: &Belt, rows: Rows<'_>) {
        let (n, per_step) = (law.count, 1.0 / dt);
        let [diagonal, off, right] = rows.map(|row| &mut row[..n]);
        cut!(n + 1; belt => v, w, spin);
        cut!(n + 1; self => mass, slope, friction, force);
        let ring_turn = &self.turn[..n + 1];
        for k in 0..n {
            let i = k + 1;
            let sliding = w[i] - v[i].re - law.lever * spin[i];
            diagonal[k] = mass[i] * per_step + slope[i] + slope[k] + friction[i];
            off[k] = -slope[i];
            right[k] = force[i].re - mass[i] * v[i].im * ring_turn[i] - friction[i] * sliding;
        }
    }

    /// The forces after w has changed by `change`, with its copies.
    pub fn correct(&mut self, law: &Law, belt: &Belt, change: &[f64]) {
        let n = law.count;
        cut!(n + 1; belt => v, w, t, spin);
        cut!(n + 1; self => slope, mass, friction);
        cut!(n + 1; mut self => tension, rate, force, contact, drag, couple);
        let (own_turn, unit, change) = (&self.turn[..n + 1], &self.unit[..n + 1], &change[..n + 2]);
        for i in 0..=n {
            rate[i] += change[i + 1] - change[i];
            tension[i] += slope[i] * (change[i + 1] - change[i]);
        }
        for i in 1..=n {
            let outward = |c: usize| slope[c] * (change[c + 1] - change[c]) * cross(t[i], unit[c]);
            force[i].im += outward(i) - outward(i - 1);
            contact[i] = -force[i].im - mass[i] * w[i] * own_turn[i];
            drag[i] = friction[i] * (w[i] - v[i].re - law.lever * spin[i]);
            couple[i] = if law.options.pitch {
                contact[i] * law.crown * belt.pitch[i].sin()
            } else {
                law.lever * drag[i]
            };
        }
        close(&mut self.drag);
        close(&mut self.couple);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Options, law, near};

    /// The slopes of a step are those of tension with Δt + η and of moments with Δt + η_κ.
    #[test]
    fn slopes_are_differences() {
        let law = law(20, &Options::default());
        let (dt, moved) = (2.0e-6, 1.0e-3);
        // Forces on the nodes of a straight row with a speed of node 10 along or across it.
        let forces = |u: f64, w: f64| {
            let (mut belt, mut ring) = (Belt::new(20), Ring::new(20));
            belt.t.fill(1.0.into());
            belt.s = (0..22).map(|i| f64::from(i) * law.thickness).collect();
            belt.p = belt.s.iter().map(Vector::from).collect();
            (belt.v[10].im, belt.w[10]) = (u, w);
            ring.place(&law, &belt);
            ring.evaluate(&law, dt, &belt);
            ring
        };
        let ring = forces(moved, 0.0);
        for (k, weight) in [1.0, -4.0, 6.0, -4.0, 1.0].into_iter().enumerate() {
            near(-ring.force[8 + k].im / moved, law.bending_slope(dt) * weight, 1e-9);
        }
        let ring = forces(0.0, moved);
        for (k, weight) in [-1.0, 2.0, -1.0].into_iter().enumerate() {
            near(-ring.force[9 + k].re / moved, ring.slope[10] * weight, 1e-9);
        }
    }
}
