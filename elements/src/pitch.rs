//! Pitch of the elements: heads, pegs, crowns, and the equations of Π.
//!
//! With the axes a, b of [`belt`](crate::belt), the gap between elements i and i + 1 is
//! x = c·a_{i+1} along the normal of the rear face, c = p_{i+1} − p_i, and the edge has slid by
//! σ = c·b_{i+1} on that face. Edges have no friction there. I Π̇_i is the sum of the couples about
//! the rocking edge:
//!
//! - push force Q of the gap behind: −Q σ,
//! - heads, at the height H: gap x_h = x + H sin(θ_{i+1} − θ_i), force Q_h along a_{i+1}; couples
//!   Q_h (H − σ) on i + 1, −Q_h H on i,
//! - peg in its hole with the clearance s_p: S = −k_p (|σ| − s_p) sgn σ along b_{i+1}; couple S x on
//!   i + 1,
//! - flanks: forces at Gauss' two heights −H_f (½ ± 1/√12), each with half of the stiffness,
//! - ring: q e_1, and its contact force N on the saddle's crown of radius R_c, which rolls:
//!   −N (R_c − e_1) sin φ; the ring gets the opposite couple, and is lifted by
//!   (R_c − e_1)(1 − cos φ).
//!
//! Heights, radius, clearance and k_p are typical values, not of a drawing. The equations of Π
//! precede those of V and U in a step; cos (θ_{i+1} − θ_i) is 1. Left out: friction between
//! faces, a centre of mass away from the rocking edge.

use crate::belt::{add, close, dot};
use crate::{Belt, Law, Vector, cyclic::Rows, flanks::Flank, ring::Ring, stack::Stack};

/// Stiffness of a peg in its hole, N/m, and its damping time, s.
const PEG: f64 = 5.0e6;
const PEG_DAMPING: f64 = 2.0e-6;

rows! {
    /// Pegs of the gaps, and what the equations of Π have found.
    Pitch {
        peg: f64, "S, N.";
        sliding: f64, "σ̇ where a peg touches, else 0, m/s.";
        spun: f64, "ΔΠ of the step, rad/s.";
    }
}

impl Pitch {
    /// Forces of the pegs at the speeds of the step before, linear in those after it.
    pub fn evaluate(&mut self, law: &Law, dt: f64, belt: &Belt) {
        for c in 0..=law.count {
            let (across, up) = (belt.offset[c], Vector::i() * belt.normal[c]);
            let beyond = across.abs() - law.options.clearance;
            let faster = belt.v[c + 1] * belt.t[c + 1] - belt.v[c] * belt.t[c];
            let sliding = dot(faster, up) + belt.distance[c] * belt.spin[c + 1];
            let ahead = beyond + (dt + PEG_DAMPING) * sliding * across.signum();
            let touches = beyond > 0.0 && ahead > 0.0;
            self.sliding[c] = if touches { sliding } else { 0.0 };
            self.peg[c] = if touches { -PEG * ahead * across.signum() } else { 0.0 };
        }
    }

    /// The equations of Π: falls on the `diagonal` and `off` it, couples on the right.
    pub fn rows(&self, law: &Law, dt: f64, belt: &Belt, of: (&[Stack; 2], &Ring, &[Flank]), rows: Rows<'_>) {
        let (n, height, inertia) = (law.count, law.options.head, law.parameters.belt.element_inertia);
        let ([edges, heads], ring, flank) = of;
        let [diagonal, off, right] = rows.map(|row| &mut row[..n]);
        for k in 0..n {
            let (i, across, along) = (k + 1, belt.offset[k], belt.distance[k]);
            let touching = f64::from(u8::from(self.peg[k] != 0.0));
            let stiff = touching * PEG * (dt + PEG_DAMPING);
            diagonal[k] = inertia / dt
                + flank[i].spin[2]
                + stiff * along * along
                + edges.slope[k] * across * across
                + (heads.slope[k] + heads.slope[i]) * height * height;
            off[k] = -heads.slope[i] * height * height;
            right[k] = flank[i].moment + self.peg[k] * along - edges.push[k] * across
                + heads.push[k] * (height - across)
                - heads.push[i] * height
                + ring.drag[i] * law.lever
                - ring.couple[i];
        }
    }

    /// Changes Π, and the forces of the gaps with it.
    pub fn correct(&mut self, law: &Law, belt: &mut Belt, stacks: &mut [Stack; 2], change: &[f64]) {
        self.spun[1..=law.count].copy_from_slice(change);
        close(&mut self.spun);
        add(&mut belt.spin, self.spun.iter().copied());
        for (stack, height) in stacks.iter_mut().zip([0.0, law.options.head]) {
            for (c, pair) in self.spun.windows(2).enumerate() {
                let opened = height * (pair[1] - pair[0]) - belt.offset[c] * pair[1];
                stack.rate[c] += opened;
                stack.push[c] -= stack.slope[c] * opened;
            }
        }
    }

    /// Stored energy of turning elements and pegs, J.
    pub fn energy(law: &Law, belt: &Belt) -> f64 {
        let of = |i: usize| {
            let beyond = (belt.offset[i].abs() - law.options.clearance).max(0.0);
            PEG * beyond * beyond + law.parameters.belt.element_inertia * belt.spin[i] * belt.spin[i]
        };
        0.5 * (1..=law.count).map(of).sum::<f64>()
    }

    /// Power of the pegs' damping, W.
    pub fn loss(&self) -> f64 {
        PEG * PEG_DAMPING * self.sliding[1..].iter().map(|rate| rate * rate).sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Options, law};

    /// Couples are the falls of the energy with the pitch, at gaps that are open and closed, pegs
    /// that touch or not.
    #[test]
    fn couples_are_falls_of_energy() {
        let (n, step) = (9, 1.0e-9);
        let mut options = Options::default();
        (options.pitch, options.clearance) = (true, 2.0e-5);
        let law = law(n, &options);
        let chance = |k: usize| ((k * 37 + 11) % 19) as f64 / 9.0 - 1.0;
        let mut belt = Belt::new(n);
        // An arc of 40 mm, with gaps of ± 0.3 µm, closed far from contact.
        for i in 1..=n {
            let along = law.thickness * i as f64 + 3.0e-7 * chance(i);
            belt.p[i] = -Vector::from_polar(0.04, -along / 0.04);
            belt.pitch[i] = 0.005 + 0.02 * chance(3 * i);
        }
        belt.place(true);
        belt.turn.fill(0.0);
        let energy = |belt: &Belt| {
            let gaps = Stack::energy(&law, belt, 0.0) + Stack::energy(&law, belt, law.options.head);
            gaps + Pitch::energy(&law, belt)
        };
        let (mut stacks, mut pitch) = ([Stack::new(n), Stack::new(n)], Pitch::new(n));
        for (stack, height) in stacks.iter_mut().zip([0.0, law.options.head]) {
            stack.evaluate(&law, 0.0, &belt, height);
        }
        pitch.evaluate(&law, 0.0, &belt);
        let mut rows = [vec![0.0; n], vec![0.0; n], vec![0.0; n]];
        let [diagonal, off, right] = rows.each_mut();
        let flanks = vec![Flank::default(); n + 2];
        let of = (&stacks, &Ring::new(n), &flanks[..]);
        pitch.rows(&law, 1.0, &belt, of, [diagonal, off, right]);
        let pegs = pitch.peg[..n].iter().filter(|force| **force != 0.0).count();
        let heads = stacks[1].push[..n].iter().filter(|force| **force > 1.0).count();
        assert!((1..n).contains(&pegs) && heads > 0, "{pegs} {heads}");
        // Frames at the ends of the row lean to the other end.
        for i in 3..n - 1 {
            let at = |change: f64| {
                let mut moved = belt.clone();
                moved.pitch[i] += change;
                moved.place(true);
                energy(&moved)
            };
            let expected = (at(-step) - at(step)) / (2.0 * step);
            let found = right[i - 1];
            let within = 1e-3 * (1.0 + expected.abs());
            assert!((found - expected).abs() < within, "{i}: {found} {expected}");
        }
    }
}
