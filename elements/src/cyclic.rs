//! Symmetric linear equations along the closed belt, by elimination in order. The last unknowns are a border.

/// A x = b with A of rows `off[i − 1]`, `diagonal[i]`, `off[i]`; `off[n − 1]` couples the last unknown with the first.
#[derive(Clone, Debug)]
pub struct Tridiagonal {
    inverse: Vec<f64>,
    border: Vec<f64>,
}

impl Tridiagonal {
    /// For `n` ≥ 5 unknowns.
    #[must_use]
    pub fn new(n: usize) -> Self {
        Self {
            inverse: vec![0.0; n],
            border: vec![0.0; n],
        }
    }

    /// Solves with the right-hand side in `x`, which becomes the solution. The elimination goes from both ends to the middle at once,
    /// since each row waits for the division of the row before it.
    pub fn solve(&mut self, diagonal: &[f64], off: &[f64], x: &mut [f64]) {
        let n = self.inverse.len();
        let (diagonal, off, x) = (&diagonal[..n], &off[..n], &mut x[..n]);
        let (inverse, border) = (&mut self.inverse[..n], &mut self.border[..n]);
        let last = n - 1;
        // Rows 0 to middle − 1 on one side, last − 1 to middle + 1 on the other, as many or one fewer.
        let middle = last / 2;
        border.fill(0.0);
        border[0] = off[last];
        border[last - 1] = off[last - 1];
        inverse[0] = 1.0 / diagonal[0];
        inverse[last - 1] = 1.0 / diagonal[last - 1];
        for k in 1..middle {
            let factor = off[k - 1] * inverse[k - 1];
            inverse[k] = 1.0 / (diagonal[k] - factor * off[k - 1]);
            x[k] -= factor * x[k - 1];
            border[k] -= factor * border[k - 1];
            let i = last - 1 - k;
            if i > middle {
                let factor = off[i] * inverse[i + 1];
                inverse[i] = 1.0 / (diagonal[i] - factor * off[i]);
                x[i] -= factor * x[i + 1];
                border[i] -= factor * border[i + 1];
            }
        }
        let (left, right) = (off[middle - 1] * inverse[middle - 1], off[middle] * inverse[middle + 1]);
        inverse[middle] = 1.0 / (diagonal[middle] - left * off[middle - 1] - right * off[middle]);
        x[middle] = (x[middle] - left * x[middle - 1] - right * x[middle + 1]) * inverse[middle];
        border[middle] = (border[middle] - left * border[middle - 1] - right * border[middle + 1]) * inverse[middle];
        for k in 1..=middle {
            let i = middle - k;
            x[i] = (x[i] - off[i] * x[i + 1]) * inverse[i];
            border[i] = (border[i] - off[i] * border[i + 1]) * inverse[i];
            let i = middle + k;
            if i < last {
                x[i] = (x[i] - off[i - 1] * x[i - 1]) * inverse[i];
                border[i] = (border[i] - off[i - 1] * border[i - 1]) * inverse[i];
            }
        }
        let pivot = diagonal[last] - off[last] * border[0] - off[last - 1] * border[last - 1];
        let end = (x[last] - off[last] * x[0] - off[last - 1] * x[last - 1]) / pivot;
        for (x, border) in x[..last].iter_mut().zip(&border[..last]) {
            *x -= border * end;
        }
        x[last] = end;
    }
}

/// A x = b with A = diag(`diagonal`) + `weight` (1, −4, 6, −4, 1), cyclic: a beam's bending on points of mass.
#[derive(Clone, Debug)]
pub struct Pentadiagonal {
    inverse: Vec<f64>,
    next: Vec<f64>,
    border: Vec<[f64; 2]>,
}

impl Pentadiagonal {
    /// For `n` ≥ 7 unknowns.
    #[must_use]
    pub fn new(n: usize) -> Self {
        Self {
            inverse: vec![0.0; n],
            next: vec![0.0; n],
            border: vec![[0.0; 2]; n],
        }
    }

    /// Solves with the right-hand side in `x`, which becomes the solution.
    pub fn solve(&mut self, diagonal: &[f64], weight: f64, x: &mut [f64]) {
        let n = self.inverse.len();
        let m = n - 2;
        let (near, far) = (-4.0 * weight, weight);
        let (diagonal, x) = (&diagonal[..n], &mut x[..n]);
        let (inverse, next, border) = (&mut self.inverse[..n], &mut self.next[..n], &mut self.border[..n]);
        border.fill([0.0; 2]);
        border[0] = [far, near];
        border[1] = [0.0, far];
        border[m - 2] = [far, 0.0];
        border[m - 1] = [near, far];
        // A = L D Lᵀ on the first m unknowns: L has m_i = `next` below its diagonal and far/D_i below that.
        let (mut lost, mut one, mut two) = (0.0, 0.0, 0.0);
        let mut before_two = 0.0;
        for i in 0..m {
            let inverted = 1.0 / (diagonal[i] + 6.0 * weight - lost - far * before_two);
            let coupling = near - far * one;
            if i > 0 {
                x[i] -= one * x[i - 1];
                border[i][0] -= one * border[i - 1][0];
                border[i][1] -= one * border[i - 1][1];
            }
            if i > 1 {
                x[i] -= before_two * x[i - 2];
                border[i][0] -= before_two * border[i - 2][0];
                border[i][1] -= before_two * border[i - 2][1];
            }
            (inverse[i], next[i]) = (inverted, coupling * inverted);
            (before_two, two) = (two, far * inverted);
            one = next[i];
            lost = coupling * one;
        }
        for i in (0..m).rev() {
            let (one, two) = (next[i], far * inverse[i]);
            x[i] *= inverse[i];
            border[i] = border[i].map(|value| value * inverse[i]);
            if i + 1 < m {
                x[i] -= one * x[i + 1];
                border[i][0] -= one * border[i + 1][0];
                border[i][1] -= one * border[i + 1][1];
            }
            if i + 2 < m {
                x[i] -= two * x[i + 2];
                border[i][0] -= two * border[i + 2][0];
                border[i][1] -= two * border[i + 2][1];
            }
        }
        // Rows of the last two unknowns, p and q.
        let of = |value: &dyn Fn(usize) -> f64| {
            [
                far * value(m - 2) + near * value(m - 1) + far * value(0),
                far * value(m - 1) + near * value(0) + far * value(1),
            ]
        };
        let right = of(&|i| x[i]);
        let right = [x[m] - right[0], x[m + 1] - right[1]];
        let columns = [0, 1].map(|k| of(&|i| border[i][k]));
        let [pp, pq] = [diagonal[m] + 6.0 * weight - columns[0][0], near - columns[1][0]];
        let [qp, qq] = [near - columns[0][1], diagonal[m + 1] + 6.0 * weight - columns[1][1]];
        let determinant = pp * qq - pq * qp;
        let end = [
            (right[0] * qq - right[1] * pq) / determinant,
            (right[1] * pp - right[0] * qp) / determinant,
        ];
        for (x, border) in x[..m].iter_mut().zip(&border[..m]) {
            *x -= border[0] * end[0] + border[1] * end[1];
        }
        (x[m], x[m + 1]) = (end[0], end[1]);
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
