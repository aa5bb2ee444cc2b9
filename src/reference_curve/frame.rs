//! The curve around two pulleys with arcs about displaced centres, and its derivatives along a path
//! of its coordinates.
//!
//! On a tilted sheave, elements of constant penetration are at ϱ = R/(1 + (ψ_x cos θ + ψ_y sin
//! θ)/tan β), to first order a circle about a displaced centre. The curve about centres at the
//! distance d_A + a is that of two pulleys, turned clockwise by an angle γ and shifted by s:
//!
//! r(ξ, Θ, a, γ, s) = M + s + Γ(γ) (r₀(ξ, Θ, d_A + a) − M), M the middle between the axes.
//!
//! A ring that stretches grows by δ along its outward normal: its arcs have the radii r_P + δ, r_S
//! + δ, and the loop is longer by 2πδ. ξ remains the length along the curve without growth, so |r'|
//! = 1 + δκ, with κ the turning per dξ.
//!
//! The six coordinates are Θ, spread a, turn γ, shift s (two) and growth δ; both centres are free.
//! Of their derivatives only ∂/∂a is new. The closure (27) yields ∂r_P/∂i = −r_P φ/W and ∂r_P/∂a =
//! −(b/d)/W, W = π − φ + i φ: the derivatives of φ and b cancel.
//!
//! A motion is a path through these coordinates. A frame holds derivatives along a path:
//! derivatives with respect to Θ on the path with Θ̇ = 1, and ∂/∂t at fixed η on a path with the
//! rates of a motion. The projection of forces uses the first derivatives with respect to each
//! coordinate: [`CoordinateDerivatives`].

use super::{Jet, ReferenceCurve, ReferencePoint, TwoPulley};
use crate::scalar::{Real, turn_right};
use nalgebra::Vector2;
use std::f64::consts::PI;

/// The curve of two pulleys on a mesh, which follows the arcs or not.
pub trait MeshCurve: ReferenceCurve + std::fmt::Debug + Sync {
    /// The frame at one place of a path of the coordinates.
    fn on_path<T: Real>(curve: &TwoPulley, path: &Path<T>) -> Self::Frame<T>;

    /// Arcs and strands of a frame.
    fn arcs<T: Real>(frame: &Self::Frame<T>) -> &TwoPulleyFrame<T>;

    /// Derivatives with respect to the coordinates at a fraction of a segment, where the curve is
    /// `point`.
    fn derivatives<T: Real>(
        frame: &Self::Frame<T>,
        segment: usize,
        fraction: T,
        point: &ReferencePoint<T>,
    ) -> CoordinateDerivatives<T>;
}

/// Number of segments: half the secondary arc, strand, primary arc, strand, half the secondary arc.
const SEGMENTS: usize = 5;
/// Number of coordinates: Θ, spread a (m), turn γ (rad), shift s (two, m), growth δ (m).
pub const COORDINATES: usize = 6;
/// Coordinates that change the shape: Θ and spread. They come first.
const OF_SHAPE: usize = 2;

/// Coordinates with their first and second derivatives along a path.
pub type Path<T> = [Jet<T>; COORDINATES];

/// The path whose variable is Θ.
#[inline(always)]
pub fn along_theta<T: Real>(theta: T) -> Path<T> {
    let mut path = [Jet::constant(0.0); COORDINATES];
    (path[0].v, path[0].d) = (theta, T::one());
    path
}

/// [`TwoPulley`] at one place of a path.
#[derive(Clone, Debug)]
pub struct TwoPulleyFrame<T: Real> {
    centers: [Jet<Vector2<T>>; 2],
    /// Arc radii without growth, secondary first, m.
    pub radius: [Jet<T>; 2],
    /// Growth δ, m.
    pub growth: Jet<T>,
    /// Strain 2πδ/L of the loop.
    pub strain: Jet<T>,
    /// φ: half the secondary wrap angle, rad.
    pub phi: Jet<T>,
    turn: Jet<T>,
    lengths: [Jet<T>; SEGMENTS],
    starts: [Jet<T>; SEGMENTS],
    /// Start and vector of each strand.
    strands: [[Jet<Vector2<T>>; 2]; 2],
    /// M + s, m.
    middle: Vector2<T>,
    d_shape: [ShapeDerivatives<T>; OF_SHAPE],
}

/// Derivatives with respect to a coordinate of the shape.
#[derive(Clone, Copy, Debug)]
struct ShapeDerivatives<T: Real> {
    centers: [Vector2<T>; 2],
    radius: [T; 2],
    phi: T,
    lengths: [T; SEGMENTS],
    starts: [T; SEGMENTS],
    /// Derivatives of the logarithms of the lengths.
    dilations: [T; SEGMENTS],
    strands: [(Vector2<T>, Vector2<T>); 2],
}

/// Derivatives of the curve at a mesh point with respect to Θ and to the spread, and ∂r/∂γ, m.
/// ∂r/∂s is the unit matrix, ∂r/∂δ the outward normal; none of the three changes ξ or κ.
pub type CoordinateDerivatives<T> = ([PointDerivatives<T>; OF_SHAPE], Vector2<T>);

/// Derivatives with respect to a coordinate at fixed η.
#[derive(Clone, Copy, Debug)]
pub struct PointDerivatives<T: Real> {
    /// Of r.
    pub r: Vector2<T>,
    /// Of ξ, m.
    pub xi: T,
    /// Of κ, 1/m.
    pub kappa: T,
    /// Of ln dξ.
    pub dilation: T,
}

/// r_P, r_S, φ and b at one place of a path through Θ and the distance d of the centres, and their
/// derivatives with respect to Θ and spread.
fn dimensions<T: Real>(curve: &TwoPulley, theta: &Jet<T>, d: &Jet<T>) -> ([Jet<T>; 4], [[T; 4]; OF_SHAPE]) {
    let (ratio, i_theta) = ratio(theta);
    let i = ratio.v;
    // Solved for plain numbers, and extended to `T` by the first derivatives.
    let (i0, d0) = (i.re(), d.v.re());
    let r0 = if d0 > 0.0 {
        TwoPulley::new(d0, curve.length).primary_radius(i0)
    } else {
        f64::NAN
    };
    let x0 = (1.0 - i0) * r0 / d0;
    let (phi0, sine) = (x0.acos(), (1.0 - x0 * x0).sqrt());
    let w0 = PI - phi0 + i0 * phi0;
    let r = (i - i0) * (-r0 * phi0 / w0) + (d.v - d0) * (-sine / w0) + r0;
    let delta = r - i * r;
    let x = delta / d.v;
    let phi = -(x - x0) * sine.recip() + phi0;
    let b = (d.v * d.v - delta * delta).sqrt();
    let (per_b, per_d) = (b.recip(), d.v.recip());
    let w = i * phi - phi + PI;
    let per_w = w.recip();
    // Derivatives of r with respect to i and d.
    let (by_i, by_d) = (-(r * phi * per_w), -(b * per_d * per_w));

    let r_dot = by_i * ratio.d + by_d * d.d;
    let delta_dot = r_dot - ratio.d * r - i * r_dot;
    let off = delta_dot - x * d.d;
    let phi_dot = -(off * per_b);
    let b_dot = (d.v * d.d - delta * delta_dot) * per_b;
    let w_dot = ratio.d * phi + i * phi_dot - phi_dot;
    let by_i_dot = -((r_dot * phi + r * phi_dot + by_i * w_dot) * per_w);
    let by_d_dot = -(((b_dot - b * per_d * d.d) * per_d + by_d * w_dot) * per_w);
    let r_ddot = by_i_dot * ratio.d + by_i * ratio.dd + by_d_dot * d.d + by_d * d.dd;
    let delta_ddot = r_ddot - ratio.dd * r - ratio.d * r_dot * 2.0 - i * r_ddot;
    let phi_ddot = (off * b_dot * per_b - (delta_ddot - off * per_d * d.d - x * d.dd)) * per_b;
    let b_ddot =
        (d.d * d.d + d.v * d.dd - delta_dot * delta_dot - delta * delta_ddot - b_dot * b_dot) * per_b;
    let jet = |v, d, dd| Jet { v, d, dd };
    let r_p = jet(r, r_dot, r_ddot);

    let derivatives = |d_r: T, d_i: T, d_d: T| {
        let d_delta = d_r - i * d_r - d_i * r;
        [
            d_r,
            i * d_r + d_i * r,
            -((d_delta - x * d_d) * per_b),
            (d.v * d_d - delta * d_delta) * per_b,
        ]
    };
    let by_shape = [
        derivatives(by_i * i_theta, i_theta, T::zero()),
        derivatives(by_d, T::zero(), T::one()),
    ];
    let (phi, b) = (jet(phi, phi_dot, phi_ddot), jet(b, b_dot, b_ddot));
    ([r_p, ratio.times(r_p), phi, b], by_shape)
}

/// i_g on a path through Θ, and di_g/dΘ.
fn ratio<T: Real>(theta: &Jet<T>) -> (Jet<T>, T) {
    let inverse = (theta.v + 1.0).recip();
    let slope = -(inverse * inverse * 2.0);
    let bend = -(slope * inverse * 2.0);
    let ratio = Jet {
        v: super::ratio_of_theta(theta.v),
        d: slope * theta.d,
        dd: slope * theta.dd + bend * theta.d * theta.d,
    };
    (ratio, slope)
}

/// Values of all segments from those of half the secondary arc, a strand and the primary arc.
fn symmetric<V: Copy>(half: V, strand: V, arc: V) -> [V; SEGMENTS] {
    [half, strand, arc, strand, half]
}

/// Pulley, and tangent angle at the start and sweep, each as [a, b] in a + bφ, of the segments.
const ANGLES: [(usize, [f64; 2], [f64; 2]); SEGMENTS] = [
    (0, [0.0, 0.0], [0.0, 1.0]),
    (0, [0.0, 1.0], [0.0, 0.0]),
    (1, [0.0, 1.0], [2.0 * PI, -2.0]),
    (1, [2.0 * PI, -1.0], [0.0, 0.0]),
    (0, [2.0 * PI, -1.0], [0.0, 1.0]),
];

#[inline(always)]
fn is_strand(segment: usize) -> bool {
    segment % 2 == 1
}

impl<T: Real> TwoPulleyFrame<T> {
    /// Wrap angles, secondary first, rad.
    #[inline(always)]
    pub fn wraps(&self) -> [T; 2] {
        [self.phi.v * 2.0, self.phi.v * -2.0 + 2.0 * PI]
    }

    /// Pulley of a segment: of an arc its own, of a strand the one at its start; its tangent angle
    /// χ at `fraction`, rad.
    #[inline(always)]
    pub fn angle(&self, segment: usize, fraction: T::Constant) -> (usize, Jet<T>) {
        let (pulley, start, sweep) = ANGLES[segment];
        let mut chi = self.turn.plus_scaled(self.phi, fraction * sweep[1] + start[1]);
        chi.v += T::constant(fraction * sweep[0] + start[0]);
        (pulley, chi)
    }
}

/// Derivatives are those along the path of the frame.
impl ReferenceCurve for TwoPulley {
    type Frame<T: Real> = TwoPulleyFrame<T>;

    fn length(&self) -> f64 {
        self.length
    }

    fn segments(&self) -> usize {
        SEGMENTS
    }

    fn frame<T: Real>(&self, theta: T) -> TwoPulleyFrame<T> {
        Self::on_path(self, &along_theta(theta))
    }

    #[inline(always)]
    fn segment_length<T: Real>(frame: &TwoPulleyFrame<T>, segment: usize) -> Jet<T> {
        frame.lengths[segment]
    }

    #[inline(always)]
    fn point<T: Real>(frame: &TwoPulleyFrame<T>, segment: usize, fraction: T::Constant) -> ReferencePoint<T> {
        let (pulley, chi) = frame.angle(segment, fraction);
        let (position, n, kappa) = if is_strand(segment) {
            let [start, along] = frame.strands[segment / 2];
            let n = turn_right(along.v * frame.lengths[segment].v.recip());
            (start.plus_scaled(along, T::constant(fraction)), n, Jet::constant(0.0))
        } else {
            let grown = frame.radius[pulley].plus_scaled(frame.growth, 1.0);
            let arm = Jet::polar(grown, chi);
            let position = frame.centers[pulley].plus_scaled(arm, T::one());
            (position, arm.v * -grown.v.recip(), frame.radius[pulley].recip())
        };
        ReferencePoint {
            r: position.v,
            r_theta: position.d,
            r_theta2: position.dd,
            t: Vector2::new(-n.y, n.x),
            n,
            chi_theta: chi.d,
            kappa: kappa.v,
            kappa_theta: kappa.d,
            xi: frame.starts[segment].plus_scaled(frame.lengths[segment], fraction),
        }
    }
}

impl MeshCurve for TwoPulley {
    fn on_path<T: Real>(curve: &TwoPulley, path: &Path<T>) -> TwoPulleyFrame<T> {
        let [theta, spread, turn, x, y, growth] = *path;
        let axes = curve.center_distance;
        let distance = spread.plus_scaled(Jet::constant(axes), 1.0);
        let ([r_p, r_s, phi, b], d_dimensions) = dimensions(curve, &theta, &distance);
        let radius = [r_s, r_p];
        let grown = radius.map(|radius| radius.plus_scaled(growth, 1.0));
        let half = r_s.times(phi);
        let opposite = Jet::constant(PI).plus_scaled(phi, -1.0);
        let arc = r_p.times(opposite).map(|length| length * 2.0);
        let lengths = symmetric(half, b, arc);
        let mut starts = [Jet::constant(0.0); SEGMENTS];
        for k in 1..SEGMENTS {
            starts[k] = starts[k - 1].plus_scaled(lengths[k - 1], 1.0);
        }
        // From P to S, and half of it: e(γ) = (−cos γ, sin γ).
        let arm = Jet::polar(distance.map(|distance| distance * 0.5), turn);
        let middle = Jet {
            v: Vector2::new(x.v + 0.5 * axes, y.v),
            d: Vector2::new(x.d, y.d),
            dd: Vector2::new(x.dd, y.dd),
        };
        let centers = [1.0, -1.0].map(|side| middle.plus_scaled(arm, T::from(side)));
        let upper = phi.plus_scaled(turn, 1.0);
        let lower = turn.plus_scaled(phi, -1.0).plus_scaled(Jet::constant(2.0 * PI), 1.0);
        let quarter = Jet::constant(PI / 2.0);
        let strands = [(0, upper), (1, lower)].map(|(pulley, chi)| {
            let start = centers[pulley].plus_scaled(Jet::polar(grown[pulley], chi), T::one());
            [start, Jet::polar(b, chi.plus_scaled(quarter, 1.0))]
        });
        let per_length = lengths.map(|length| length.v.recip());
        let toward = arm.v * (distance.v * 0.5).recip();
        let d_shape = std::array::from_fn(|k| {
            let [d_r_p, d_r_s, d_phi, d_b] = d_dimensions[k];
            let d_radius = [d_r_s, d_r_p];
            let arc = |radius: T, d_radius: T, angle: T, d_angle: T| d_radius * angle + radius * d_angle;
            let d_lengths = symmetric(
                arc(r_s.v, d_r_s, phi.v, d_phi),
                d_b,
                arc(r_p.v, d_r_p, opposite.v, -d_phi) * 2.0,
            );
            let mut starts = [T::zero(); SEGMENTS];
            for k in 1..SEGMENTS {
                starts[k] = starts[k - 1] + d_lengths[k - 1];
            }
            let apart = T::from(if k == 0 { 0.0 } else { 0.5 });
            let centers = [toward * apart, toward * -apart];
            let per_b = b.v.recip();
            let strands = std::array::from_fn(|strand| {
                let t = strands[strand][1].v * per_b;
                let n = turn_right(t);
                let chi = if strand == 0 { d_phi } else { -d_phi };
                let start = centers[strand] - n * d_radius[strand] + t * (grown[strand].v * chi);
                (start, t * d_b + n * (b.v * chi))
            });
            ShapeDerivatives {
                centers,
                radius: d_radius,
                phi: d_phi,
                lengths: d_lengths,
                starts,
                dilations: std::array::from_fn(|k| d_lengths[k] * per_length[k]),
                strands,
            }
        });
        TwoPulleyFrame {
            centers,
            radius,
            growth,
            strain: growth.map(|growth| growth * (2.0 * PI / curve.length)),
            phi,
            turn,
            lengths,
            starts,
            strands,
            middle: middle.v,
            d_shape,
        }
    }

    #[inline(always)]
    fn arcs<T: Real>(frame: &TwoPulleyFrame<T>) -> &TwoPulleyFrame<T> {
        frame
    }

    #[inline(always)]
    fn derivatives<T: Real>(
        frame: &TwoPulleyFrame<T>,
        segment: usize,
        fraction: T,
        point: &ReferencePoint<T>,
    ) -> CoordinateDerivatives<T> {
        let (t, n) = (point.t, point.n);
        let shape = frame.d_shape.each_ref().map(|d| {
            let (r, kappa) = if is_strand(segment) {
                let (start, along) = &d.strands[segment / 2];
                (start + along * fraction, T::zero())
            } else {
                let (pulley, start, sweep) = ANGLES[segment];
                let chi = (fraction * sweep[1] + start[1]) * d.phi;
                let across = n * -d.radius[pulley];
                (
                    d.centers[pulley] + across + t * ((frame.radius[pulley].v + frame.growth.v) * chi),
                    -(d.radius[pulley] * point.kappa * point.kappa),
                )
            };
            PointDerivatives {
                r,
                xi: d.starts[segment] + d.lengths[segment] * fraction,
                kappa,
                dilation: d.dilations[segment],
            }
        });
        (shape, turn_right(point.r - frame.middle))
    }
}
