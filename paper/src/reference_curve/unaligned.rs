//! A curve for a mesh that does not follow its arcs. Mesh points are at fixed ξ, as in the paper,
//! and arc borders move through the elements as Θ changes.
//!
//! With F(ξ, Θ) the curve and ξ(η, Θ) its own mesh: ∂F/∂Θ = ∂r/∂Θ|_η − ξ_Θ t, χ_Θ|_ξ = χ_Θ|_η − ξ_Θ
//! κ, and so on; the curvature of an arc does not depend on ξ, so κ_Θ is the same. As in the
//! paper's (18), the border terms are missing: when a border passes a quadrature point, κ jumps
//! there, and the force −∂V/∂Θ of the quadrature lacks ½EI\[κ²\] dξ_k/dΘ.

use super::{
    CoordinateDerivatives, Jet, PointDerivatives, ReferenceCurve, ReferencePoint, TangentAngle, TwoPulley,
    TwoPulleyFrame,
};
use crate::scalar::{LANES, Real};
use nalgebra::Vector2;

/// A curve whose arcs the mesh does not follow: one segment.
#[derive(Clone, Debug)]
pub struct Unaligned {
    /// The curve itself.
    pub curve: TwoPulley,
}

/// A fraction of a segment: its value, and a zero with its derivatives with respect to Θ.
struct FractionWithin<T: Real> {
    value: T::Constant,
    change: T,
}

impl Unaligned {
    /// Derivatives with respect to the coordinates of the curve, where it is `point`. On a fixed
    /// mesh ξ and dξ are constant.
    pub fn derivatives<T: Real>(
        frame: &TwoPulleyFrame<T>,
        fraction: T::Constant,
        point: &ReferencePoint<T>,
    ) -> CoordinateDerivatives<T> {
        let of = |segment| {
            let FractionWithin { value, change } = Self::within(frame, segment, fraction);
            let mut derivatives = frame.derivatives(segment, change + T::constant(value), point);
            for by in [&mut derivatives.theta, &mut derivatives.spread] {
                by.r -= point.t * ((point.kappa * frame.growth.v + 1.0) * by.xi);
                (by.xi, by.dilation) = (T::zero(), T::zero());
            }
            derivatives
        };
        Self::gather(frame, fraction, of, merge_derivatives)
    }

    /// The results of `of` for the segment of each place in a pack. `merge` returns the second of
    /// two in the lanes where its first argument is positive, else the third.
    fn gather<T: Real, R>(
        frame: &TwoPulleyFrame<T>,
        fraction: T::Constant,
        of: impl Fn(usize) -> R,
        merge: impl Fn(T, R, R) -> R,
    ) -> R {
        let mut found = None;
        // Length from the start of a segment to the place: negative before the segment.
        let mut from_start = T::constant(fraction * frame.length);
        for segment in 0..TwoPulley::SEGMENTS {
            let from_end = from_start - frame.segment_length(segment).v;
            let is_last = segment + 1 == TwoPulley::SEGMENTS;
            let has = |lane| from_start.lane(lane) >= 0.0 && (is_last || from_end.lane(lane) < 0.0);
            if (0..LANES).any(has) {
                let here = of(segment);
                found = Some(match found {
                    Some(before) => merge(-from_start, before, here),
                    None => here,
                });
            }
            from_start = from_end;
        }
        // No segment has a place of a curve that does not close.
        found.unwrap_or_else(|| of(0))
    }

    /// The fraction of `segment` at a fraction of the whole curve.
    fn within<T: Real>(
        frame: &TwoPulleyFrame<T>,
        segment: usize,
        fraction: T::Constant,
    ) -> FractionWithin<T> {
        let mut rest = T::constant(fraction * frame.length);
        for before in 0..segment {
            rest -= frame.segment_length(before).v;
        }
        let fraction = rest / frame.segment_length(segment).v;
        let value = fraction.value();
        FractionWithin {
            value,
            change: fraction - T::constant(value),
        }
    }

    fn point_in<T: Real>(
        frame: &TwoPulleyFrame<T>,
        segment: usize,
        fraction: T::Constant,
    ) -> ReferencePoint<T> {
        let FractionWithin { value: f, change: df } = Self::within(frame, segment, fraction);
        let p = frame.point(segment, f);
        let chi = TwoPulley::tangent_angle(frame, segment, f).chi;
        let length = frame.segment_length(segment);
        // Taylor expansion by df along the segment, at fixed η.
        let step = length.v * df;
        let t = p.t + p.n * (p.kappa * step);
        let n = p.n - p.t * (p.kappa * step);
        let r_theta = p.r_theta + (p.t * length.d + p.n * (length.v * chi.d)) * df;
        let r_theta2 = p.r_theta2
            + (p.t * (length.dd - length.v * chi.d * chi.d)
                + p.n * (length.d * chi.d * 2.0 + length.v * chi.dd))
                * df;
        let chi_theta = chi.d + (length.d * p.kappa + length.v * p.kappa_theta) * df;
        let (along, along2) = (p.xi.d + length.d * df, p.xi.dd + length.dd * df);
        // From fixed η to fixed ξ.
        let chi_theta = chi_theta - along * p.kappa;
        ReferencePoint {
            r: p.r + p.t * step,
            r_theta: r_theta - t * along,
            r_theta2: r_theta2 - n * (along * chi_theta * 2.0) - n * (along * along * p.kappa) - t * along2,
            t,
            n,
            chi_theta,
            kappa: p.kappa,
            kappa_theta: p.kappa_theta,
            xi: Jet {
                v: T::constant(fraction * frame.length),
                ..Jet::constant(0.0)
            },
        }
    }

    fn tangent_angle_in<T: Real>(
        frame: &TwoPulleyFrame<T>,
        segment: usize,
        fraction: T::Constant,
    ) -> TangentAngle<T> {
        let FractionWithin { value: f, change: df } = Self::within(frame, segment, fraction);
        let TangentAngle { chi, kappa } = TwoPulley::tangent_angle(frame, segment, f);
        let length = frame.segment_length(segment);
        let place = frame.point(segment, f).xi;
        let (along, along2) = (place.d + length.d * df, place.dd + length.dd * df);
        let by_fraction = [
            length.v * kappa.v,
            length.d * kappa.v + length.v * kappa.d,
            length.dd * kappa.v + length.d * kappa.d * 2.0 + length.v * kappa.dd,
        ];
        let d = chi.d + by_fraction[1] * df - along * kappa.v;
        let dd = chi.dd + by_fraction[2] * df - along * kappa.d * 2.0 - along2 * kappa.v;
        TangentAngle {
            chi: Jet {
                v: chi.v + by_fraction[0] * df,
                d,
                dd,
            },
            kappa,
        }
    }
}

/// Scalars with derivatives have first derivatives only. Places in the lanes of a pack may lie on
/// different segments; Θ is the same in all lanes.
impl ReferenceCurve for Unaligned {
    type Frame<T: Real> = TwoPulleyFrame<T>;

    fn length(&self) -> f64 {
        self.curve.length()
    }

    fn segments(&self) -> usize {
        1
    }

    fn frame<T: Real>(&self, theta: T) -> TwoPulleyFrame<T> {
        self.curve.frame(theta)
    }

    fn segment_length<T: Real>(frame: &TwoPulleyFrame<T>, _segment: usize) -> Jet<T> {
        frame.segment_length(TwoPulley::WHOLE)
    }

    fn point<T: Real>(
        frame: &TwoPulleyFrame<T>,
        _segment: usize,
        fraction: T::Constant,
    ) -> ReferencePoint<T> {
        let of = |segment| Self::point_in(frame, segment, fraction);
        Self::gather(frame, fraction, of, merge_points)
    }

    fn tangent_angle<T: Real>(
        frame: &TwoPulleyFrame<T>,
        _segment: usize,
        fraction: T::Constant,
    ) -> TangentAngle<T> {
        let of = |segment| Self::tangent_angle_in(frame, segment, fraction);
        Self::gather(frame, fraction, of, merge_angles)
    }
}

fn merge_vectors<T: Real>(first: T, a: Vector2<T>, b: Vector2<T>) -> Vector2<T> {
    a.zip_map(&b, |a, b| first.if_positive(a, b))
}

fn merge_jets<T: Real>(first: T, a: Jet<T>, b: Jet<T>) -> Jet<T> {
    Jet {
        v: first.if_positive(a.v, b.v),
        d: first.if_positive(a.d, b.d),
        dd: first.if_positive(a.dd, b.dd),
    }
}

fn merge_points<T: Real>(first: T, a: ReferencePoint<T>, b: ReferencePoint<T>) -> ReferencePoint<T> {
    let vector = |a, b| merge_vectors(first, a, b);
    ReferencePoint {
        r: vector(a.r, b.r),
        r_theta: vector(a.r_theta, b.r_theta),
        r_theta2: vector(a.r_theta2, b.r_theta2),
        t: vector(a.t, b.t),
        n: vector(a.n, b.n),
        chi_theta: first.if_positive(a.chi_theta, b.chi_theta),
        kappa: first.if_positive(a.kappa, b.kappa),
        kappa_theta: first.if_positive(a.kappa_theta, b.kappa_theta),
        xi: merge_jets(first, a.xi, b.xi),
    }
}

fn merge_angles<T: Real>(first: T, a: TangentAngle<T>, b: TangentAngle<T>) -> TangentAngle<T> {
    TangentAngle {
        chi: merge_jets(first, a.chi, b.chi),
        kappa: merge_jets(first, a.kappa, b.kappa),
    }
}

fn merge_derivatives<T: Real>(
    first: T,
    a: CoordinateDerivatives<T>,
    b: CoordinateDerivatives<T>,
) -> CoordinateDerivatives<T> {
    let merge = |a: PointDerivatives<T>, b: PointDerivatives<T>| PointDerivatives {
        r: merge_vectors(first, a.r, b.r),
        xi: first.if_positive(a.xi, b.xi),
        kappa: first.if_positive(a.kappa, b.kappa),
        dilation: first.if_positive(a.dilation, b.dilation),
    };
    CoordinateDerivatives {
        theta: merge(a.theta, b.theta),
        spread: merge(a.spread, b.spread),
        turn: merge_vectors(first, a.turn, b.turn),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::{Dual, Lanes, Tangent};

    /// Derivatives at fixed ξ, and their derivatives through the scalar, against differences.
    #[test]
    fn derivatives_match_differences() {
        let curve = Unaligned {
            curve: TwoPulley::new(0.168, 0.703),
        };
        let h = 1e-5;
        let theta = 0.3;
        let close = |a: Vector2<f64>, b: Vector2<f64>, tol: f64| assert!((a - b).norm() < tol, "{a} {b}");
        for k in 0..40 {
            let f = (f64::from(k) + 0.35) / 40.0;
            let at = |theta: f64| Unaligned::point::<f64>(&curve.frame(theta), 0, f);
            let angle = |theta: f64| Unaligned::tangent_angle::<f64>(&curve.frame(theta), 0, f);
            let (p, plus, minus) = (at(theta), at(theta + h), at(theta - h));
            let (chi, chi_plus, chi_minus) = (angle(theta).chi, angle(theta + h).chi, angle(theta - h).chi);
            assert!((p.xi.v - f * 0.703).abs() < 1e-15);
            close(p.r_theta, (plus.r - minus.r) / (2.0 * h), 1e-8);
            close(p.r_theta2, (plus.r_theta - minus.r_theta) / (2.0 * h), 1e-7);
            close(p.n * p.chi_theta, (plus.t - minus.t) / (2.0 * h), 1e-7);
            assert!((chi.d - (chi_plus.v - chi_minus.v) / (2.0 * h)).abs() < 1e-7);
            assert!((chi.d - p.chi_theta).abs() < 1e-12);
            assert!((chi.dd - (chi_plus.d - chi_minus.d) / (2.0 * h)).abs() < 1e-6);
            let dual = Unaligned::point(&curve.frame(Dual::seed(theta, 0, 1.0)), 0, f);
            close(dual.r.map(|x| x.eps[0]), p.r_theta, 1e-12);
            close(dual.r_theta.map(|x| x.eps[0]), p.r_theta2, 1e-11);
            close(dual.t.map(|x| x.eps[0]), p.n * p.chi_theta, 1e-11);
            assert!((dual.chi_theta.eps[0] - chi.dd).abs() < 1e-10);
        }
    }

    /// Places of a pack lie on different segments; each lane equals a separate evaluation.
    #[test]
    fn lanes_of_a_pack_equal_separate_evaluations() {
        let pulleys = TwoPulley::new(0.168, 0.703);
        let theta = -0.35;
        let pack = pulleys.frame(Tangent::<2>::seed(Lanes::from(theta), 1, 1.0));
        let alone = Unaligned { curve: pulleys }.frame(Dual::seed(theta, 0, 1.0));
        for k in 0..40 {
            let f: [f64; LANES] =
                std::array::from_fn(|lane| ((f64::from(k) + 23.0 * lane as f64) / 40.0 + 0.01) % 1.0);
            let packed = Unaligned::point(&pack, 0, Lanes::new(f));
            for (lane, &f) in f.iter().enumerate() {
                let single = Unaligned::point(&alone, 0, f);
                for (packed, single) in [
                    (packed.r.x, single.r.x),
                    (packed.t.y, single.t.y),
                    (packed.r_theta.y, single.r_theta.y),
                    (packed.chi_theta, single.chi_theta),
                    (packed.kappa, single.kappa),
                    (packed.kappa_theta, single.kappa_theta),
                    (packed.xi.v, single.xi.v),
                ] {
                    let size = 1.0 + single.re.abs() + single.eps[0].abs();
                    assert!((packed.re.to_array()[lane] - single.re).abs() < 1e-13 * size);
                    assert!((packed.eps[1].to_array()[lane] - single.eps[0]).abs() < 1e-12 * size);
                }
            }
        }
    }
}
