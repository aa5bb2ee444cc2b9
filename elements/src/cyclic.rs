//! Symmetric linear equations along the closed belt, by elimination in order. The last unknowns are
//! a border.

use crate::belt::Vector;

/// Diagonal, row beside it, and right-hand side of [`Tridiagonal`].
pub type Rows<'a> = [&'a mut [f64]; 3];

rows! {
    /// A x = b with A of rows `off[i − 1]`, `diagonal[i]`, `off[i]`; `off[n − 1]` couples the last
    /// unknown with the first; n ≥ 5.
    Tridiagonal {
        inverse: f64, "Inverse pivots.";
        rows: Vector, "Right-hand side and, imaginary, coefficient of the last unknown.";
    }
}

impl Tridiagonal {
    /// Solves with the right-hand side in `x`, which becomes the solution. The elimination goes
    /// from both ends to the middle at once, since each row waits for the division of the row
    /// before it.
    pub fn solve(&mut self, diagonal: &[f64], off: &[f64], x: &mut [f64]) {
        let n = x.len();
        let (diagonal, off) = (&diagonal[..n], &off[..n]);
        cut!(n; mut self => inverse, rows);
        let last = n - 1;
        // Rows 0 to middle − 1 on one side, last − 1 to middle + 1 on the other, or one fewer.
        let middle = last / 2;
        rows.iter_mut().zip(&*x).for_each(|(row, x)| *row = x.into());
        rows[0].im = off[last];
        rows[last - 1].im = off[last - 1];
        inverse[0] = 1.0 / diagonal[0];
        inverse[last - 1] = 1.0 / diagonal[last - 1];
        let mut eliminate = |i: usize, from: usize, off: f64| {
            let factor = off * inverse[from];
            inverse[i] = 1.0 / (diagonal[i] - factor * off);
            rows[i] -= factor * rows[from];
        };
        for k in 1..middle {
            eliminate(k, k - 1, off[k - 1]);
            let i = last - 1 - k;
            if i > middle {
                eliminate(i, i + 1, off[i]);
            }
        }
        let (left, right) = (off[middle - 1] * inverse[middle - 1], off[middle] * inverse[middle + 1]);
        inverse[middle] = 1.0 / (diagonal[middle] - left * off[middle - 1] - right * off[middle]);
        let row = rows[middle] - left * rows[middle - 1] - right * rows[middle + 1];
        rows[middle] = row * inverse[middle];
        for k in 1..=middle {
            let i = middle - k;
            rows[i] = (rows[i] - off[i] * rows[i + 1]) * inverse[i];
            let i = middle + k;
            if i < last {
                rows[i] = (rows[i] - off[i - 1] * rows[i - 1]) * inverse[i];
            }
        }
        let (first, before) = (rows[0], rows[last - 1]);
        let pivot = diagonal[last] - off[last] * first.im - off[last - 1] * before.im;
        x[last] = (x[last] - off[last] * first.re - off[last - 1] * before.re) / pivot;
        for i in 0..last {
            x[i] = rows[i].re - rows[i].im * x[last];
        }
    }
}

rows! {
    /// A x = b with A = diag(`diagonal`) + `weight` (1, −4, 6, −4, 1), cyclic: a beam's bending on
    /// points of mass; n ≥ 7.
    Pentadiagonal {
        inverse: f64, "Inverse pivots.";
        next: f64, "m_i.";
        border: Vector, "Coefficients of the last two unknowns, p + iq.";
    }
}

impl Pentadiagonal {
    /// Solves with the right-hand side in `x`, which becomes the solution.
    pub fn solve(&mut self, diagonal: &[f64], weight: f64, x: &mut [f64]) {
        let n = x.len();
        let m = n - 2;
        let (near, far) = (-4.0 * weight, weight);
        let diagonal = &diagonal[..n];
        cut!(n; mut self => inverse, next, border);
        border.fill(Vector::default());
        (border[0], border[1]) = (Vector::new(far, near), Vector::new(0.0, far));
        (border[m - 2], border[m - 1]) = (Vector::new(far, 0.0), Vector::new(near, far));
        // A = L D Lᵀ on the first m unknowns: L has m_i = `next` below its diagonal and far/D_i
        // below that.
        let (mut lost, mut one, mut two) = (0.0, 0.0, 0.0);
        let mut before_two = 0.0;
        for i in 0..m {
            let inverted = 1.0 / (diagonal[i] + 6.0 * weight - lost - far * before_two);
            let coupling = near - far * one;
            for (back, factor) in [(1, one), (2, before_two)] {
                if i >= back {
                    x[i] -= factor * x[i - back];
                    border[i] -= factor * border[i - back];
                }
            }
            (inverse[i], next[i]) = (inverted, coupling * inverted);
            (before_two, two) = (two, far * inverted);
            one = next[i];
            lost = coupling * one;
        }
        for i in (0..m).rev() {
            x[i] *= inverse[i];
            border[i] *= inverse[i];
            for (ahead, factor) in [(1, next[i]), (2, far * inverse[i])] {
                if i + ahead < m {
                    x[i] -= factor * x[i + ahead];
                    border[i] -= factor * border[i + ahead];
                }
            }
        }
        // Rows of the last two unknowns.
        let of = |value: &dyn Fn(usize) -> f64| {
            let [a, b, c, d] = [m - 2, m - 1, 0, 1].map(value);
            [far * a + near * b + far * c, far * b + near * c + far * d]
        };
        let right = of(&|i| x[i]);
        let right = [x[m] - right[0], x[m + 1] - right[1]];
        let columns = [of(&|i| border[i].re), of(&|i| border[i].im)];
        let [pp, pq] = [diagonal[m] + 6.0 * weight - columns[0][0], near - columns[1][0]];
        let [qp, qq] = [near - columns[0][1], diagonal[m + 1] + 6.0 * weight - columns[1][1]];
        let determinant = pp * qq - pq * qp;
        x[m] = (right[0] * qq - right[1] * pq) / determinant;
        x[m + 1] = (right[1] * pp - right[0] * qp) / determinant;
        let (inner, end) = x.split_at_mut(m);
        for (x, border) in inner.iter_mut().zip(&border[..m]) {
            *x -= border.re * end[0] + border.im * end[1];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(n: usize, seed: usize) -> Vec<f64> {
        (0..n).map(|i| ((i * 37 + seed * 11) % 19) as f64 * 0.1 - 0.7).collect()
    }

    #[test]
    fn solutions_fulfil_their_equations() {
        for n in [7, 8, 31] {
            let rhs = numbers(n, 3);
            let off: Vec<_> = numbers(n, 1).iter().map(|c| c - 2.0).collect();
            let diagonal: Vec<_> = numbers(n, 2).iter().map(|c| c + 6.5).collect();
            let mut x = rhs.clone();
            Tridiagonal::new(n).solve(&diagonal, &off, &mut x);
            for i in 0..n {
                let (before, after) = ((i + n - 1) % n, (i + 1) % n);
                let left = off[before] * x[before] + diagonal[i] * x[i] + off[i] * x[after];
                assert!((left - rhs[i]).abs() < 1e-12, "{n}, {i}");
            }
            let mut x = rhs.clone();
            let diagonal: Vec<_> = numbers(n, 4).iter().map(|c| c + 1.0).collect();
            Pentadiagonal::new(n).solve(&diagonal, 2.3, &mut x);
            for i in 0..n {
                let at = |k: usize| x[(i + n + k - 2) % n];
                let bent = at(0) - 4.0 * at(1) + 6.0 * at(2) - 4.0 * at(3) + at(4);
                assert!((diagonal[i] * x[i] + 2.3 * bent - rhs[i]).abs() < 1e-11, "{n}, {i}");
            }
        }
    }
}
