//! Elements in the plane of the drive: chords between rocking edges, frames, turning.
//!
//! p_i is the rocking edge of element i. The element is oriented as its neighbours' edges lie:
//! t_i along p_{i+1} − p_{i−1}, o_i outward, to its left; t = (sin χ, cos χ), o = (−cos χ, sin χ),
//! and χ grows where the belt turns inward. Speeds are components in this frame,
//! v_i = V_i t_i + U_i o_i. They turn with it, by the angle Δχ_i of a step, so that
//!
//! m (V̇ + U Ω) = F·t, m (U̇ − V Ω) = F·o, Ω = Δχ/Δt.
//!
//! A speed is the mean of the step after it: the edge moves along the frame that has turned half a
//! step further, p ← p + Δt (V t' + U o'). Otherwise friction would meet a false radial speed
//! V Ω Δt/2.
//!
//! With free pitch an element turns by itself: its axis a_i = t_i e^{−iφ_i} leans forward by φ_i out
//! of that frame, at the speed Π_i = Ω_i + φ̇_i, and b_i = i a_i points to its head
//! ([`pitch`](crate::pitch)). Otherwise a chord takes the place of the axis that it meets.
//!
//! Vectors of the plane are complex numbers x + iy: with V + iU the velocity is (V + iU) t, and
//! the components of a force along t and o are F t*, t* the conjugate.
//!
//! All arrays have a copy of the last element before the first and one of the first behind the
//! last: the elements are 1…N. Chord i leads from element i to i + 1.

/// A vector in the plane, x + iy, or components along t and o.
pub type Vector = num_complex::Complex64;

/// a·b.
pub fn dot(a: Vector, b: Vector) -> f64 {
    a.re * b.re + a.im * b.im
}

/// a × b.
pub fn cross(a: Vector, b: Vector) -> f64 {
    a.re * b.im - a.im * b.re
}

/// Adds values to sums.
#[inline(always)]
pub(crate) fn add<'a>(sums: impl IntoIterator<Item = &'a mut f64>, values: impl IntoIterator<Item = f64>) {
    sums.into_iter().zip(values).for_each(|(sum, value)| *sum += value);
}

/// Copies the last value before the first, and the first behind the last.
pub fn close<T: Copy>(values: &mut [T]) {
    let n = values.len() - 2;
    (values[0], values[n + 1]) = (values[n], values[1]);
}

rows! {
    /// Elements and the steel at them.
    Belt {
        p: Vector, "Rocking edges, m.";
        v: Vector, "Speeds V + iU of the elements, m/s.";
        w: f64, "Speed of the steel along t, m/s.";
        s: f64, "Place of the nodes in the steel, m.";
        t: Vector, "t.";
        turn: f64, "Δχ since the step before, rad.";
        unit: Vector, "Unit vectors of the chords.";
        length: f64, "Lengths of the chords, m.";
        pitch: f64, "φ, rad.";
        spin: f64, "Π, rad/s.";
        axis: Vector, "a.";
        normal: Vector, "Normal of a gap: a of the element in front of it.";
        distance: f64, "Chord along that normal, m.";
        offset: f64, "σ: chord across it, m.";
    }
}

/// Unit vectors and lengths, m, of the chords through `points`, with their copies.
pub fn chords(points: &[Vector], unit: &mut [Vector], length: &mut [f64]) {
    for ((ends, unit), length) in points.windows(2).zip(unit).zip(length) {
        let chord = ends[1] - ends[0];
        *length = chord.norm_sqr().sqrt();
        *unit = chord * (1.0 / *length);
    }
}

impl Belt {
    /// Copies, chords and frames, how far they have turned, and the axes of elements of free pitch.
    pub fn place(&mut self, free: bool) {
        let n = self.t.len() - 2;
        close(&mut self.p);
        chords(&self.p, &mut self.unit, &mut self.length);
        cut!(n + 1; self => unit, length);
        cut!(n + 1; mut self => t, turn);
        for i in 1..=n {
            let along = unit[i - 1] * length[i - 1] + unit[i] * length[i];
            let new = along * (1.0 / along.norm_sqr().sqrt());
            turn[i] = cross(new, t[i]);
            t[i] = new;
        }
        close(&mut self.t);
        close(&mut self.turn);
        if !free {
            self.axis.copy_from_slice(&self.t);
            self.normal.copy_from_slice(&self.unit);
            self.distance.copy_from_slice(&self.length);
            return;
        }
        for i in 1..=n {
            self.pitch[i] -= self.turn[i];
            self.axis[i] = self.t[i] * Vector::from_polar(1.0, -self.pitch[i]);
        }
        close(&mut self.axis);
        close(&mut self.pitch);
        close(&mut self.spin);
        for c in 0..=n {
            let (axis, chord) = (self.axis[c + 1], self.unit[c] * self.length[c]);
            self.normal[c] = axis;
            self.distance[c] = dot(chord, axis);
            self.offset[c] = cross(axis, chord);
        }
    }
}
