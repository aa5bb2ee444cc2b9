//! The reference curve of a variator (paper 5.1): two arcs and two strands, eq. (27) and (28).
//!
//! With i_g = (1−Θ)/(1+Θ), r_S = i_g r_P, φ = arccos((r_P−r_S)/d_A), b = √(d_A² − (r_P−r_S)²) the closure (27)
//! L = 2b + 2 r_P(π−φ) + 2 r_S φ gives r_P(Θ). The printed (28) has misprints: ξ_P = ξ − r_Sφ − b and
//! φ_P = φ + ξ_P/r_P; (29) mirrors at L − ξ. Written with the tangent angle χ the whole loop is one formula:
//! arc points O + r(−cos χ, sin χ) with χ from 0 to φ on S, φ to 2π−φ on P, 2π−φ to 2π on S.

use super::curve::{ReferenceCurve, ReferencePoint, TangentAngle};
use super::jet::Jet;
use crate::scalar::Real;
use nalgebra::Vector2;
use num_dual::{Dual3_64, DualNum};
use std::f64::consts::PI;

/// Number of segments: half the secondary arc, strand, primary arc, strand, half the secondary arc.
pub const SEGMENTS: usize = 5;

/// Most Newton steps for a radius. The default variator takes one or two at every ratio; a curve that does not close
/// may take all.
const NEWTON_STEPS: usize = 50;
/// Newton's last step as a share of L. The remaining error is of the order of its square, below rounding.
const LAST_STEP: f64 = 1e-8;
/// Length error, as a share of L, up to which a curve counts as closed: some thousand times the rounding error.
const CLOSED: f64 = 1e-12;
/// Largest start value of r_P, as a share of that with r_P − r_S = d_A, the end of the range of φ.
const LARGEST_START: f64 = 0.999;
/// Largest iterate of r_P, as the same share.
const LARGEST_ITERATE: f64 = 0.9999;
/// Least |1 − i_g| for which r_P is limited: at ratio 1 there is no limit.
const LEAST_DIFFERENCE: f64 = 1e-9;

/// The curve around two pulleys: S at the origin, P at (d_A, 0).
#[derive(Clone, Debug)]
pub struct TwoPulley {
    center_distance: f64,
    length: f64,
}

/// The belt does not fit the pulleys.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("no belt of length {length} m closes around pulleys {center_distance} m apart at a geometric ratio of {ratio}")]
pub struct GeometryError {
    /// Belt length L, m.
    pub length: f64,
    /// Distance of the axes d_A, m.
    pub center_distance: f64,
    /// Geometric ratio i_g.
    pub ratio: f64,
}

/// i_g = (1−Θ)/(1+Θ); the map is its own inverse.
pub fn ratio_of_theta<T: Real>(theta: T) -> T {
    (-theta + 1.0) / (theta + 1.0)
}

impl TwoPulley {
    /// Curve of length `length` around pulleys `center_distance` apart, both in m.
    #[must_use]
    pub fn new(center_distance: f64, length: f64) -> Self {
        Self {
            center_distance,
            length,
        }
    }

    /// Distance of the axes d_A, m.
    #[must_use]
    pub(super) fn center_distance(&self) -> f64 {
        self.center_distance
    }

    /// The belt of the same length around pulleys at another distance, m.
    #[must_use]
    pub(super) fn at_distance(&self, center_distance: f64) -> Self {
        Self {
            center_distance,
            length: self.length,
        }
    }

    /// φ and b at the difference of radii r_P − r_S, m, each with its first three derivatives with respect to it.
    fn tangent(&self, difference: f64) -> [[f64; 4]; 2] {
        let d = self.center_distance;
        let phi = (difference / d).acos();
        let b = (d * d - difference * difference).sqrt();
        let inverse = b.recip();
        let (cube, square) = (inverse.powi(3), difference * difference);
        let fifth = cube * inverse * inverse;
        [
            [phi, -inverse, -difference * cube, -(b * b + 3.0 * square) * fifth],
            [
                b,
                -difference * inverse,
                -d * d * cube,
                -3.0 * d * d * difference * fifth,
            ],
        ]
    }

    /// Closure (27): length of the curve less L, m, and its derivative with respect to r_P at ratio `ratio`, α_P + i_g α_S.
    fn closure<D: DualNum<Primitive = f64>>(&self, r_p: &D, ratio: &D, phi: &D, b: &D) -> (D, D) {
        let [wrap_p, wrap_s] = [-phi.clone() + PI, phi.clone()].map(|half| half * 2.0);
        let slope = wrap_p + wrap_s * ratio;
        (b.clone() * 2.0 + slope.clone() * r_p - self.length, slope)
    }

    /// [`TwoPulley::closure`] at a radius.
    fn closure_at(&self, r_p: f64, ratio: f64) -> (f64, f64) {
        let [[phi, ..], [b, ..]] = self.tangent(r_p - ratio * r_p);
        self.closure(&r_p, &ratio, &phi, &b)
    }

    /// r_P at ratio `ratio`, m; NaN where there is none.
    pub(super) fn primary_radius(&self, ratio: f64) -> f64 {
        // L = 2d_A + π(r_P + r_S) + d_A (x² + x⁴/12 + x⁶/40 + …) with x = (r_P − r_S)/d_A. The start value solves the
        // quadratic equation and is corrected by the next two terms at that solution.
        let d = self.center_distance;
        let (square, linear) = ((1.0 - ratio) * (1.0 - ratio) / d, PI * (1.0 + ratio));
        let rest = self.length - 2.0 * d;
        let mut r_p = 2.0 * rest / (linear + (linear * linear + 4.0 * square * rest).max(0.0).sqrt());
        let x2 = square * r_p * r_p / d;
        r_p -= d * x2 * x2 * (1.0 / 12.0 + x2 / 40.0) / (linear + 2.0 * square * r_p);
        // The derivative of the closure is positive and bounded away from zero, so Newton converges from every start
        // inside the range of φ.
        let limit = d / (1.0 - ratio).abs().max(LEAST_DIFFERENCE);
        r_p = r_p.clamp(0.0, LARGEST_START * limit);
        for _ in 0..NEWTON_STEPS {
            let (excess, slope) = self.closure_at(r_p, ratio);
            let step = excess / slope;
            r_p = (r_p - step).min(LARGEST_ITERATE * limit);
            if step.abs() < LAST_STEP * self.length {
                break;
            }
        }
        r_p
    }

    /// Reference radii (r_P, r_S) at a geometric ratio, m.
    ///
    /// # Errors
    /// The belt is too short or too long for the distance of the axes.
    pub fn radii(&self, ratio: f64) -> Result<(f64, f64), GeometryError> {
        let r_p = self.primary_radius(ratio);
        let r_s = ratio * r_p;
        let closes = self.closure_at(r_p, ratio).0.abs() < CLOSED * self.length;
        if ratio > 0.0 && closes && r_p > 0.0 && r_s > 0.0 {
            Ok((r_p, r_s))
        } else {
            Err(GeometryError {
                length: self.length,
                center_distance: self.center_distance,
                ratio,
            })
        }
    }
}

/// Radii, angle and strand length at one Θ with their first three derivatives.
#[derive(Clone, Copy, Debug)]
pub struct TwoPulleyShape {
    center_distance: f64,
    radius: [Dual3_64; 2],
    phi: Dual3_64,
    half: Dual3_64,
    arc: Dual3_64,
    strand: Dual3_64,
}

/// f(x) with the derivatives of x, from f and its first three derivatives at the value of x.
fn compose([f, d, dd, ddd]: [f64; 4], x: Dual3_64) -> Dual3_64 {
    let (v1, v2, v3) = (x.v1, x.v2, x.v3);
    Dual3_64::new(
        f,
        d * v1,
        dd * v1 * v1 + d * v2,
        ddd * v1 * v1 * v1 + 3.0 * dd * v1 * v2 + d * v3,
    )
}

impl TwoPulley {
    /// The shape at Θ.
    #[must_use]
    pub fn shape(&self, theta: f64) -> TwoPulleyShape {
        let ratio = ratio_of_theta(Dual3_64::from_re(theta).derivative());
        let radius = self.primary_radius(ratio.re);
        let derivatives = self.tangent(radius - ratio.re * radius);
        let strand = |r_p: Dual3_64| derivatives.map(|f| compose(f, r_p - ratio * r_p));
        // The value has converged; each further Newton step makes one more derivative exact.
        let mut r_p = Dual3_64::from_re(radius);
        for _ in 0..3 {
            let [phi, b] = strand(r_p);
            let (excess, slope) = self.closure(&r_p, &ratio, &phi, &b);
            r_p -= excess / slope.re;
        }
        let [phi, strand] = strand(r_p);
        let r_s = ratio * r_p;
        TwoPulleyShape {
            center_distance: self.center_distance,
            radius: [r_s, r_p],
            phi,
            half: r_s * phi,
            arc: r_p * (-phi + PI) * 2.0,
            strand,
        }
    }
}

impl TwoPulleyShape {
    /// The curve for a scalar `T`; `dtheta` = Θ − Re Θ carries the derivatives of Θ.
    #[must_use]
    pub fn frame<T: Real>(&self, dtheta: T) -> TwoPulleyFrame<T> {
        let lift = |x| Jet::lift(x, dtheta);
        let [half, arc, strand] = [self.half, self.arc, self.strand].map(lift);
        let lengths = [half, strand, arc, strand, half];
        let mut starts = [Jet::constant(0.0); SEGMENTS];
        for k in 1..SEGMENTS {
            starts[k] = starts[k - 1].plus_scaled(lengths[k - 1], 1.0);
        }
        let radius = self.radius.map(lift);
        let phi = lift(self.phi);
        let quarter = |chi: Jet<T>| chi.plus_scaled(Jet::constant(PI / 2.0), 1.0);
        let end = Jet::constant(2.0 * PI).plus_scaled(phi, -1.0);
        let mut lower = VectorJet::polar(radius[1], end);
        lower.v.x += T::from(self.center_distance);
        // t(χ) = (sin χ, cos χ) is the radial direction (−cos χ, sin χ) at χ + π/2.
        let strands = [
            (VectorJet::polar(radius[0], phi), VectorJet::polar(strand, quarter(phi))),
            (lower, VectorJet::polar(strand, quarter(end))),
        ];
        TwoPulleyFrame {
            center: [0.0, self.center_distance],
            radius,
            phi,
            lengths,
            starts,
            strands,
        }
    }
}

/// A vector and its first two derivatives with respect to Θ.
#[derive(Clone, Copy, Debug)]
pub(super) struct VectorJet<T: Real> {
    pub(super) v: Vector2<T>,
    pub(super) d: Vector2<T>,
    pub(super) dd: Vector2<T>,
}

impl<T: Real> VectorJet<T> {
    /// O + ρ(−cos χ, sin χ) with χ(Θ), ρ(Θ).
    #[inline(always)]
    pub(super) fn polar(rho: Jet<T>, chi: Jet<T>) -> Self {
        let (sin, cos) = chi.v.sin_cos();
        let e = Vector2::new(-cos, sin);
        let t = Vector2::new(sin, cos);
        Self {
            v: e * rho.v,
            d: e * rho.d + t * (rho.v * chi.d),
            dd: e * (rho.dd - rho.v * chi.d * chi.d) + t * (rho.d * chi.d * 2.0 + rho.v * chi.dd),
        }
    }

    /// From its components.
    #[inline(always)]
    pub(super) fn of([x, y]: [Jet<T>; 2]) -> Self {
        Self {
            v: Vector2::new(x.v, y.v),
            d: Vector2::new(x.d, y.d),
            dd: Vector2::new(x.dd, y.dd),
        }
    }

    /// `self` ± `other`.
    #[inline(always)]
    pub(super) fn plus_scaled_by(self, other: &Self, factor: f64) -> Self {
        let f = T::from(factor);
        Self {
            v: self.v + other.v * f,
            d: self.d + other.d * f,
            dd: self.dd + other.dd * f,
        }
    }

    #[inline(always)]
    pub(super) fn plus_scaled(self, other: &Self, factor: T::Constant) -> Self {
        let f = T::constant(factor);
        Self {
            v: self.v + other.v * f,
            d: self.d + other.d * f,
            dd: self.dd + other.dd * f,
        }
    }
}

/// [`TwoPulley`] at one Θ.
#[derive(Clone, Debug)]
pub struct TwoPulleyFrame<T: Real> {
    center: [f64; 2],
    /// Arc radii, secondary first, m.
    pub radius: [Jet<T>; 2],
    /// φ: half the secondary wrap angle, rad.
    pub phi: Jet<T>,
    lengths: [Jet<T>; SEGMENTS],
    starts: [Jet<T>; SEGMENTS],
    strands: [(VectorJet<T>, VectorJet<T>); 2],
}

impl<T: Real> TwoPulleyFrame<T> {
    /// Wrap angles, secondary first, rad.
    #[inline(always)]
    #[must_use]
    pub fn wraps(&self) -> [T; 2] {
        wraps(self.phi.v)
    }
}

/// Wrap angles at φ, half the secondary one; secondary first, rad.
#[inline(always)]
pub(super) fn wraps<T: Real>(phi: T) -> [T; 2] {
    [phi * 2.0, phi * -2.0 + 2.0 * PI]
}

/// (pulley, χ at the start, χ's sweep) of the arc segments as multiples: χ = a + bφ.
pub(super) fn arc_angles(segment: usize) -> (usize, [f64; 2], [f64; 2]) {
    match segment {
        0 => (0, [0.0, 0.0], [0.0, 1.0]),
        2 => (1, [0.0, 1.0], [2.0 * PI, -2.0]),
        _ => (0, [2.0 * PI, -1.0], [0.0, 1.0]),
    }
}

/// The curve at a point of a strand along t, which turns by `chi_theta`.
#[inline(always)]
pub(super) fn on_strand<T: Real>(position: VectorJet<T>, t: Vector2<T>, chi_theta: T, xi: Jet<T>) -> ReferencePoint<T> {
    ReferencePoint {
        r: position.v,
        r_theta: position.d,
        r_theta2: position.dd,
        t,
        n: crate::scalar::turn_right(t),
        chi_theta,
        kappa: T::zero(),
        kappa_theta: T::zero(),
        xi,
    }
}

/// The curve at the tangent angle χ of an arc; `from_origin` adds the arc's centre to the vector from it.
#[inline(always)]
pub(super) fn on_arc<T: Real>(
    rho: Jet<T>,
    chi: Jet<T>,
    xi: Jet<T>,
    from_origin: impl FnOnce(VectorJet<T>) -> VectorJet<T>,
) -> ReferencePoint<T> {
    let arm = VectorJet::polar(rho, chi);
    let kappa = rho.v.recip();
    let n = arm.v * (-kappa);
    let position = from_origin(arm);
    ReferencePoint {
        r: position.v,
        r_theta: position.d,
        r_theta2: position.dd,
        t: Vector2::new(-n.y, n.x),
        n,
        chi_theta: chi.d,
        kappa,
        kappa_theta: -(rho.d * kappa * kappa),
        xi,
    }
}

impl ReferenceCurve for TwoPulley {
    type Frame<T: Real> = TwoPulleyFrame<T>;

    fn length(&self) -> f64 {
        self.length
    }

    fn segments(&self) -> usize {
        SEGMENTS
    }

    fn frame<T: Real>(&self, theta: T) -> TwoPulleyFrame<T> {
        let value = theta.re();
        self.shape(value).frame(theta - value)
    }

    #[inline(always)]
    fn segment_length<T: Real>(frame: &TwoPulleyFrame<T>, segment: usize) -> Jet<T> {
        frame.lengths[segment]
    }

    #[inline(always)]
    fn point<T: Real>(frame: &TwoPulleyFrame<T>, segment: usize, fraction: T::Constant) -> ReferencePoint<T> {
        let xi = frame.starts[segment].plus_scaled(frame.lengths[segment], fraction);
        if segment == 1 || segment == 3 {
            let (start, along) = &frame.strands[segment / 2];
            let chi_theta = if segment == 1 { frame.phi.d } else { -frame.phi.d };
            let t = along.v * frame.lengths[segment].v.recip();
            return on_strand(start.plus_scaled(along, fraction), t, chi_theta, xi);
        }
        let (pulley, start, sweep) = arc_angles(segment);
        let mut chi = Jet::constant(0.0).plus_scaled(frame.phi, fraction * sweep[1] + start[1]);
        chi.v += T::constant(fraction * sweep[0] + start[0]);
        on_arc(frame.radius[pulley], chi, xi, |mut arm| {
            arm.v += Vector2::new(T::from(frame.center[pulley]), T::zero());
            arm
        })
    }

    fn tangent_angle<T: Real>(frame: &TwoPulleyFrame<T>, segment: usize, fraction: T::Constant) -> TangentAngle<T> {
        let end = Jet::constant(2.0 * PI).plus_scaled(frame.phi, -1.0);
        if segment == 1 || segment == 3 {
            return TangentAngle {
                chi: if segment == 1 { frame.phi } else { end },
                kappa: Jet::constant(0.0),
            };
        }
        let (pulley, start, sweep) = arc_angles(segment);
        let mut chi = Jet::constant(0.0).plus_scaled(frame.phi, fraction * sweep[1] + start[1]);
        chi.v += T::constant(fraction * sweep[0] + start[0]);
        TangentAngle {
            chi,
            kappa: frame.radius[pulley].recip(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve() -> TwoPulley {
        TwoPulley::new(0.168, 0.703)
    }

    #[test]
    fn published_radii() {
        let (r_p, r_s) = curve().radii(1.0).unwrap();
        assert!((r_p - 0.05841).abs() < 1e-5 && (r_s - r_p).abs() < 1e-15);
        let (r_p, r_s) = curve().radii(1.0 / 2.25).unwrap();
        assert!((r_p - 0.07837).abs() < 1e-5 && (r_s - 0.03483).abs() < 1e-5);
        assert!(TwoPulley::new(0.4, 0.703).radii(1.0).is_err());
    }

    #[test]
    fn paper_radii() {
        let (r_p, r_s) = TwoPulley::new(0.2, 1.0).radii(ratio_of_theta(0.4)).unwrap();
        assert!((r_p - 0.127_690).abs() < 5e-7 && (r_s - 0.054_724).abs() < 5e-7);
    }

    /// Every Θ derivative at fixed η, and the tangent along ξ, against central differences.
    #[test]
    fn derivatives_match_differences() {
        let curve = curve();
        let at = |theta: f64, segment, f| TwoPulley::point(&curve.frame(theta), segment, f);
        let h = 1e-5;
        for theta in [-0.4, 0.0, 0.3] {
            for segment in 0..SEGMENTS {
                for f in [0.0, 0.3, 1.0] {
                    let (p, plus, minus) = (
                        at(theta, segment, f),
                        at(theta + h, segment, f),
                        at(theta - h, segment, f),
                    );
                    let close = |a: Vector2<f64>, b: Vector2<f64>, tol: f64| assert!((a - b).norm() < tol, "{a} {b}");
                    close(p.r_theta, (plus.r - minus.r) / (2.0 * h), 1e-9);
                    close(p.r_theta2, (plus.r_theta - minus.r_theta) / (2.0 * h), 1e-8);
                    close(p.n * p.chi_theta, (plus.t - minus.t) / (2.0 * h), 1e-9);
                    assert!((p.kappa_theta - (plus.kappa - minus.kappa) / (2.0 * h)).abs() < 1e-6);
                    assert!((p.xi.d - (plus.xi.v - minus.xi.v) / (2.0 * h)).abs() < 1e-9);
                    assert!((p.xi.dd - (plus.xi.d - minus.xi.d) / (2.0 * h)).abs() < 1e-8);
                    if f == 0.3 {
                        let (a, b) = (at(theta, segment, f - h), at(theta, segment, f + h));
                        let dxi = b.xi.v - a.xi.v;
                        close(p.t, (b.r - a.r) / dxi, 1e-9);
                        close(p.n * p.kappa, (b.t - a.t) / dxi, 1e-7);
                    }
                }
            }
        }
    }

    #[test]
    fn the_loop_closes_and_its_tangent_is_continuous() {
        let frame = curve().frame(-0.35);
        for segment in 0..SEGMENTS {
            let (end, start) = (
                TwoPulley::point(&frame, segment, 1.0),
                TwoPulley::point(&frame, (segment + 1) % SEGMENTS, 0.0),
            );
            assert!((end.r - start.r).norm() < 1e-14 && (end.t - start.t).norm() < 1e-14);
        }
    }

    /// Dual numbers in the frame carry the derivative of the second derivative.
    #[test]
    fn third_derivative_through_the_dual() {
        use num_dual::Dual64;
        let curve = curve();
        let h = 1e-5;
        let dual = TwoPulley::point(&curve.frame(Dual64::new(0.2, 1.0)), 2, 0.3);
        let at = |theta: f64| TwoPulley::point(&curve.frame(theta), 2, 0.3).r_theta2;
        let difference = (at(0.2 + h) - at(0.2 - h)) / (2.0 * h);
        assert!((dual.r_theta2.x.eps - difference.x).abs() < 1e-6);
        assert!((dual.r_theta2.y.eps - difference.y).abs() < 1e-6);
    }
}
