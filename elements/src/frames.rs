//! Elements in the plane of the drive: chords between rocking edges, frames, turning.
//!
//! p_i is the rocking edge of element i. The element is oriented as its neighbours' edges lie: t_i along p_{i+1} − p_{i−1},
//! o_i outward, to its left; t = (sin χ, cos χ), o = (−cos χ, sin χ), and χ grows where the belt turns inward. Speeds are
//! components in this frame, v_i = V_i t_i + U_i o_i. They turn with it, by the angle Δχ_i of a step, so that
//!
//! m (V̇ + U Ω) = F·t, m (U̇ − V Ω) = F·o, Ω = Δχ/Δt.
//!
//! A speed is the mean of the step after it: the edge moves along the frame that has turned half a step further,
//! p ← p + Δt (V t' + U o'). Otherwise friction would meet a false radial speed V Ω Δt/2.
//!
//! All arrays have a copy of the last element before the first and one of the first behind the last: the elements are
//! 1…N. Chord i leads from element i to i + 1.

/// Copies the last value before the first, and the first behind the last.
pub fn close(values: &mut [f64]) {
    let n = values.len() - 2;
    values[0] = values[n];
    values[n + 1] = values[1];
}

/// Unit vectors and lengths of the chords through a row of points.
#[derive(Clone, Debug)]
pub struct Chords {
    /// Unit vectors, x and y.
    pub x: Vec<f64>,
    /// y.
    pub y: Vec<f64>,
    /// Lengths, m.
    pub length: Vec<f64>,
}

impl Chords {
    /// For `n` points.
    #[must_use]
    pub fn new(n: usize) -> Self {
        let zero = vec![0.0; n + 2];
        Self {
            x: zero.clone(),
            y: zero.clone(),
            length: zero,
        }
    }

    /// The chords through these points, with their copies.
    pub fn evaluate(&mut self, x: &[f64], y: &[f64]) {
        let chords = self.length.len() - 1;
        let (x, y) = (&x[..chords + 1], &y[..chords + 1]);
        let (cx, cy, length) = (&mut self.x[..chords], &mut self.y[..chords], &mut self.length[..chords]);
        for i in 0..chords {
            let (dx, dy) = (x[i + 1] - x[i], y[i + 1] - y[i]);
            let l = (dx * dx + dy * dy).sqrt();
            let inverse = 1.0 / l;
            (cx[i], cy[i], length[i]) = (dx * inverse, dy * inverse, l);
        }
    }
}

/// Frames of the elements.
#[derive(Clone, Debug)]
pub struct Frames {
    /// t, x.
    pub tx: Vec<f64>,
    /// t, y.
    pub ty: Vec<f64>,
    /// Δχ since the step before, rad.
    pub turn: Vec<f64>,
}

impl Frames {
    /// For `n` elements.
    #[must_use]
    pub fn new(n: usize) -> Self {
        let zero = vec![0.0; n + 2];
        Self {
            tx: zero.clone(),
            ty: zero.clone(),
            turn: zero,
        }
    }

    /// The frames of elements with these chords, and how far they have turned.
    pub fn evaluate(&mut self, chords: &Chords) {
        let n = self.tx.len() - 2;
        let (cx, cy, length) = (&chords.x[..n + 1], &chords.y[..n + 1], &chords.length[..n + 1]);
        let (tx, ty, turn) = (&mut self.tx[..n + 1], &mut self.ty[..n + 1], &mut self.turn[..n + 1]);
        for i in 1..=n {
            let dx = cx[i - 1] * length[i - 1] + cx[i] * length[i];
            let dy = cy[i - 1] * length[i - 1] + cy[i] * length[i];
            let inverse = 1.0 / (dx * dx + dy * dy).sqrt();
            let (new_x, new_y) = (dx * inverse, dy * inverse);
            turn[i] = ty[i] * new_x - tx[i] * new_y;
            (tx[i], ty[i]) = (new_x, new_y);
        }
        close(&mut self.tx);
        close(&mut self.ty);
        close(&mut self.turn);
    }
}
