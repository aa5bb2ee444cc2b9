//! Energies of a ring.

/// Energies of a ring or of a part of it, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// T (6).
    pub kinetic: f64,
    /// Membrane part of V (17).
    pub membrane: f64,
    /// Bending part of V (17).
    pub bending: f64,
}

impl Energy {
    /// T + V, J.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.kinetic + self.membrane + self.bending
    }
}

impl std::ops::AddAssign for Energy {
    fn add_assign(&mut self, other: Self) {
        self.kinetic += other.kinetic;
        self.membrane += other.membrane;
        self.bending += other.bending;
    }
}
