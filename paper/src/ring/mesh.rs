//! Mesh of a ring alone.

pub use pushbelt::ring::mesh::*;

/// Mesh of a ring alone: elements around the loop with their quadrature points. Node k is the left
/// end of element k; node 0 is at ξ = 0.
#[derive(Clone, Debug)]
pub struct RingMesh {
    /// The elements in the order of ξ.
    pub elements: Vec<Element>,
    /// Quadrature points of each element.
    pub stations: Vec<Vec<Station>>,
    /// Their local coordinates x ∈ [−1, 1] and weights.
    pub quadrature: &'static [(f64, f64)],
}

impl RingMesh {
    /// Divides each segment into a number of elements, with `points` Gauss points each (2 to 5).
    /// With fewer than three the membrane energy is under-integrated and hourglass modes occur.
    #[must_use]
    pub fn new(segments: &[(usize, Spacing)], points: usize) -> Self {
        let elements: Vec<Element> = segments
            .iter()
            .enumerate()
            .flat_map(|(segment, &(count, spacing))| divide(segment, count, spacing))
            .collect();
        let stations = elements
            .iter()
            .flat_map(|element| parts(element, 1, points))
            .map(|(_, stations)| stations)
            .collect();
        Self {
            elements,
            stations,
            quadrature: gauss(points),
        }
    }

    /// Divides each segment evenly.
    #[must_use]
    pub fn even(counts: &[usize], points: usize) -> Self {
        let segments: Vec<_> = counts.iter().map(|&count| (count, Spacing::Both(0.0))).collect();
        Self::new(&segments, points)
    }
}
