//! Division of the reference curve into ring elements, and of the elements into quadrature points.
//! Element borders lie on the segment borders for every Θ, so all integrals are smooth in Θ.

use super::kinematics::Hermite;
use std::f64::consts::TAU;

/// A quadrature point of an element, or of a part of it.
#[derive(Clone, Copy, Debug)]
pub struct Station<L = f64> {
    /// Fraction of the segment.
    pub fraction: L,
    /// Hermite functions there.
    pub shape: Hermite<L>,
    /// dξ as a fraction of the element length.
    pub weight: L,
    /// Fraction of the part: weight of its right face.
    pub right: L,
}

/// A ring element as a part of a segment.
#[derive(Clone, Copy, Debug)]
pub struct Element {
    /// Segment of the reference curve.
    pub segment: usize,
    /// Start as a fraction of the segment.
    pub start: f64,
    /// Length as a fraction of the segment.
    pub length: f64,
}

impl Element {
    /// The station at the local coordinate x ∈ [−1, 1].
    #[must_use]
    pub fn station(&self, x: f64, weight: f64, right: f64) -> Station {
        Station {
            fraction: self.start + self.length * 0.5 * (1.0 + x),
            shape: Hermite::new(x),
            weight,
            right,
        }
    }
}

/// The element in which `fraction` of a segment lies, and how far along it, from 0 to 1.
#[must_use]
pub fn find(elements: &[Element], segment: usize, fraction: f64) -> (usize, f64) {
    let after =
        elements.partition_point(|e| e.segment < segment || e.segment == segment && e.start <= fraction);
    let element = after.saturating_sub(1);
    let Element { start, length, .. } = elements[element];
    (element, (fraction - start) / length)
}

/// How a segment is divided. A grading g ∈ [0, 1) makes the element at the named end 1 − g of the
/// mean size; 0 is even.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Spacing {
    /// Finer towards the start.
    Start(f64),
    /// Finer towards the end.
    End(f64),
    /// Finer towards both ends.
    Both(f64),
}

impl Spacing {
    /// Fraction of the segment before the border at the fraction `s` of the element count.
    #[must_use]
    pub fn border(self, s: f64) -> f64 {
        let graded = |s: f64, g: f64| s - g / TAU * (TAU * s).sin();
        match self {
            Self::Start(g) => 2.0 * graded(0.5 * s, g),
            Self::End(g) => 2.0 * graded(0.5 + 0.5 * s, g) - 1.0,
            Self::Both(g) => graded(s, g),
        }
    }
}

/// Divides a segment into `count` elements.
pub fn divide(segment: usize, count: usize, spacing: Spacing) -> impl Iterator<Item = Element> {
    let border = move |k: usize| spacing.border(k as f64 / count as f64);
    (0..count).map(move |k| Element {
        segment,
        start: border(k),
        length: border(k + 1) - border(k),
    })
}

const GAUSS: [&[(f64, f64)]; 4] = [
    &[(-0.577_350_269_189_625_8, 1.0), (0.577_350_269_189_625_8, 1.0)],
    &[
        (-0.774_596_669_241_483_4, 5.0 / 9.0),
        (0.0, 8.0 / 9.0),
        (0.774_596_669_241_483_4, 5.0 / 9.0),
    ],
    &[
        (-0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
        (-0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
        (0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
        (0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
    ],
    &[
        (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
        (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
        (0.0, 0.568_888_888_888_888_9),
        (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
        (0.906_179_845_938_664, 0.236_926_885_056_189_08),
    ],
];

/// Nodes and weights of Gauss's rule on [−1, 1] with 2 to 5 points.
#[must_use]
pub fn gauss(points: usize) -> &'static [(f64, f64)] {
    GAUSS[points.clamp(2, 5) - 2]
}

/// Divides an element into parts with Gauss points: the left face and the stations of each part.
#[must_use]
pub fn parts(element: &Element, count: usize, points: usize) -> Vec<(Station, Vec<Station>)> {
    let width = 1.0 / count as f64;
    (0..count)
        .map(|c| {
            let left = -1.0 + 2.0 * c as f64 * width;
            let stations = gauss(points)
                .iter()
                .map(|&(eta, w)| {
                    let right = 0.5 * (1.0 + eta);
                    element.station(left + 2.0 * width * right, 0.5 * w * width, right)
                })
                .collect();
            (element.station(left, 0.0, 0.0), stations)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gauss_integrates_polynomials_of_its_degree() {
        for points in 2..=5 {
            for degree in 0..2 * points {
                let sum: f64 = gauss(points).iter().map(|&(x, w)| w * x.powi(degree as i32)).sum();
                let exact = f64::from(1 - degree as i32 % 2) * 2.0 / (degree as f64 + 1.0);
                assert!((sum - exact).abs() < 1e-15, "{points} points, degree {degree}");
            }
        }
    }

    #[test]
    fn spacings_fill_a_segment_and_are_fine_at_the_named_ends() {
        for (spacing, [starts_fine, ends_fine]) in [
            (Spacing::Start(0.6), [true, false]),
            (Spacing::End(0.6), [false, true]),
            (Spacing::Both(0.6), [true, true]),
        ] {
            let shares: Vec<f64> = divide(0, 50, spacing).map(|e| 50.0 * e.length).collect();
            assert!((shares.iter().sum::<f64>() - 50.0).abs() < 1e-12);
            for (length, is_fine) in [(shares[0], starts_fine), (shares[49], ends_fine)] {
                assert!(
                    if is_fine { length < 0.41 } else { length > 1.5 },
                    "{spacing:?}: {length}"
                );
            }
        }
        assert!(divide(0, 50, Spacing::Both(0.0)).all(|e| (50.0 * e.length - 1.0).abs() < 1e-12));
    }
}
