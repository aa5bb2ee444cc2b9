//! The curve around two pulleys with arcs about displaced centres, and its derivatives along a path
//! of its coordinates.
//!
//! The curve about centres at the distance d_A + a is that of two pulleys, turned clockwise by an
//! angle γ and shifted by s: r(ξ, Θ, a, γ, s) = M + s + Γ(γ) (r₀(ξ, Θ, d_A + a) − M), M the middle
//! between the axes. A ring that stretches grows by δ along its outward normal: its arcs have the
//! radii r_P + δ and r_S + δ. ξ remains the length along the curve without growth, so |r'| = 1 +
//! δκ, with κ the turning per dξ.
//!
//! Of the derivatives only ∂/∂a is new: the closure (27) yields ∂r_P/∂i = −r_P φ/W and ∂r_P/∂a =
//! −(b/d)/W, W = π − φ + i φ; the derivatives of φ and b cancel.
//!
//! A frame holds derivatives along a path through the six coordinates: those with respect to Θ on
//! the path with Θ̇ = 1, and ∂/∂t at fixed η on a path with the rates of a motion. The projection
//! of forces uses the first derivatives with respect to each coordinate: [`CoordinateDerivatives`].

use super::{Jet, ReferencePoint, TwoPulley};
use crate::scalar::{Real, turn_right};
use nalgebra::Vector2;
use std::f64::consts::PI;

const SEGMENTS: usize = TwoPulley::SEGMENTS;
/// Number of coordinates.
pub const COORDINATES: usize = 6;
/// Coordinates that change the shape: Θ and spread. They come first.
const OF_SHAPE: usize = 2;

/// A value for each coordinate of the curve.
#[derive(Clone, Copy, Debug)]
pub struct CurveCoordinates<V> {
    /// Θ.
    pub theta: V,
    /// Spread a, m.
    pub spread: V,
    /// Turn γ, rad.
    pub turn: V,
    /// Shift s, m.
    pub shift: [V; 2],
    /// Growth δ, m.
    pub growth: V,
}

impl<V> CurveCoordinates<V> {
    /// From the values in the order of the fields.
    #[inline(always)]
    pub fn from_array([theta, spread, turn, x, y, growth]: [V; COORDINATES]) -> Self {
        Self {
            theta,
            spread,
            turn,
            shift: [x, y],
            growth,
        }
    }

    /// The values in the order of the fields.
    #[inline(always)]
    pub fn to_array(self) -> [V; COORDINATES] {
        let [x, y] = self.shift;
        [self.theta, self.spread, self.turn, x, y, self.growth]
    }

    /// `f` of each value.
    #[inline(always)]
    pub fn map<U>(self, f: impl Fn(V) -> U) -> CurveCoordinates<U> {
        CurveCoordinates::from_array(self.to_array().map(f))
    }
}

/// Coordinates with their first and second derivatives along a path.
pub type Path<T> = CurveCoordinates<Jet<T>>;

impl<T: Real> Path<T> {
    /// The path whose variable is Θ.
    #[inline(always)]
    pub fn along_theta(theta: T) -> Self {
        let mut path = Self::from_array([Jet::constant(0.0); COORDINATES]);
        (path.theta.v, path.theta.d) = (theta, T::one());
        path
    }
}

/// A place on the curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurvePlace {
    /// Segment.
    pub segment: usize,
    /// Fraction of the segment.
    pub fraction: f64,
}

/// Start and vector of a strand, or their derivatives.
#[derive(Clone, Copy, Debug)]
struct Strand<V> {
    start: V,
    along: V,
}

/// [`TwoPulley`] at one place of a path.
#[derive(Clone, Debug)]
pub struct TwoPulleyFrame<T: Real> {
    /// Length L of the curve without growth, m.
    pub length: f64,
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
    strands: [Strand<Jet<Vector2<T>>>; 2],
    /// M + s, m.
    middle: Vector2<T>,
    d_shape: [ShapeDerivatives<T>; OF_SHAPE],
}

#[derive(Clone, Copy, Debug)]
struct ShapeDerivatives<T: Real> {
    centers: [Vector2<T>; 2],
    radius: [T; 2],
    phi: T,
    lengths: [T; SEGMENTS],
    starts: [T; SEGMENTS],
    /// Derivatives of the logarithms of the lengths.
    dilations: [T; SEGMENTS],
    strands: [Strand<Vector2<T>>; 2],
}

/// Derivatives of the curve at a mesh point with respect to its coordinates. ∂r/∂s is the unit
/// matrix, ∂r/∂δ the outward normal; turn, shift and growth change neither ξ nor κ.
#[derive(Clone, Copy, Debug)]
pub struct CoordinateDerivatives<T: Real> {
    /// With respect to Θ.
    pub theta: PointDerivatives<T>,
    /// With respect to the spread.
    pub spread: PointDerivatives<T>,
    /// ∂r/∂γ, m.
    pub turn: Vector2<T>,
}

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

/// Radii, φ and length b of a strand, or their derivatives.
struct Dimensions<V> {
    r_p: V,
    r_s: V,
    phi: V,
    b: V,
}

/// The dimensions on a path through Θ and the distance d of the centres, and the derivatives with
/// respect to Θ and spread.
fn dimensions<T: Real>(
    curve: &TwoPulley,
    theta: &Jet<T>,
    d: &Jet<T>,
) -> (Dimensions<Jet<T>>, [Dimensions<T>; OF_SHAPE]) {
    let by_theta = ratio(theta.v);
    let ratio = Jet {
        v: by_theta.v,
        d: by_theta.d * theta.d,
        dd: by_theta.d * theta.dd + by_theta.dd * theta.d * theta.d,
    };
    let (i, i_theta) = (ratio.v, by_theta.d);
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
        Dimensions {
            r_p: d_r,
            r_s: i * d_r + d_i * r,
            phi: -((d_delta - x * d_d) * per_b),
            b: (d.v * d_d - delta * d_delta) * per_b,
        }
    };
    let by_shape = [
        derivatives(by_i * i_theta, i_theta, T::zero()),
        derivatives(by_d, T::zero(), T::one()),
    ];
    let here = Dimensions {
        r_p,
        r_s: ratio.times(r_p),
        phi: jet(phi, phi_dot, phi_ddot),
        b: jet(b, b_dot, b_ddot),
    };
    (here, by_shape)
}

/// i_g with its derivatives with respect to Θ.
fn ratio<T: Real>(theta: T) -> Jet<T> {
    let inverse = (theta + 1.0).recip();
    let d = -(inverse * inverse * 2.0);
    Jet {
        v: super::ratio_of_theta(theta),
        d,
        dd: -(d * inverse * 2.0),
    }
}

/// Values of all segments from those of half the secondary arc, a strand and the primary arc.
fn symmetric<V: Copy>(half: V, strand: V, arc: V) -> [V; SEGMENTS] {
    [half, strand, arc, strand, half]
}

/// Pulley of each segment: of an arc its own, of a strand the one at its start.
const PULLEYS: [usize; SEGMENTS] = [0, 0, 1, 1, 0];
/// Tangent angle over each segment: its value at the start and its change along it, rad.
const ANGLES: [[f64; 2]; SEGMENTS] = [
    [0.0, 0.0],
    [0.0, 0.0],
    [0.0, 2.0 * PI],
    [2.0 * PI, 0.0],
    [2.0 * PI, 0.0],
];
/// The factors of φ in both.
const BY_PHI: [[f64; 2]; SEGMENTS] = [[0.0, 1.0], [1.0, 0.0], [1.0, -2.0], [-1.0, 0.0], [-1.0, 1.0]];

/// The factor of φ in the tangent angle at a fraction of a segment.
#[inline(always)]
fn by_phi<V: Real>(segment: usize, fraction: V) -> V {
    let [start, sweep] = BY_PHI[segment];
    fraction * sweep + start
}

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

    /// Tangent angle χ at `fraction` of a segment, rad.
    #[inline(always)]
    pub fn angle(&self, segment: usize, fraction: T::Constant) -> Jet<T> {
        let [start, sweep] = ANGLES[segment];
        let mut chi = self.turn.plus_scaled(self.phi, by_phi(segment, fraction));
        chi.v += T::constant(fraction * sweep + start);
        chi
    }

    /// Curvature κ of a segment without growth, 1/m.
    #[inline(always)]
    pub fn curvature(&self, segment: usize) -> Jet<T> {
        if is_strand(segment) {
            Jet::constant(0.0)
        } else {
            self.radius[PULLEYS[segment]].recip()
        }
    }

    /// Length of a segment, m.
    #[inline(always)]
    pub fn segment_length(&self, segment: usize) -> Jet<T> {
        if segment == TwoPulley::WHOLE {
            Jet::constant(self.length)
        } else {
            self.lengths[segment]
        }
    }

    /// The curve at `fraction` of a segment. Derivatives are those along the path of the frame.
    #[inline(always)]
    pub fn point(&self, segment: usize, fraction: T::Constant) -> ReferencePoint<T> {
        let pulley = PULLEYS[segment];
        let chi = self.angle(segment, fraction);
        let kappa = self.curvature(segment);
        let (position, n) = if is_strand(segment) {
            let Strand { start, along } = self.strands[segment / 2];
            let n = turn_right(along.v * self.lengths[segment].v.recip());
            (start.plus_scaled(along, T::constant(fraction)), n)
        } else {
            let grown = self.radius[pulley].plus_scaled(self.growth, 1.0);
            let arm = Jet::polar(grown, chi);
            let position = self.centers[pulley].plus_scaled(arm, T::one());
            (position, arm.v * -grown.v.recip())
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
            xi: self.starts[segment].plus_scaled(self.lengths[segment], fraction),
        }
    }

    /// Derivatives with respect to the coordinates at `fraction` of a segment, where the curve is
    /// `point`.
    #[inline(always)]
    pub fn derivatives(
        &self,
        segment: usize,
        fraction: T,
        point: &ReferencePoint<T>,
    ) -> CoordinateDerivatives<T> {
        let (t, n) = (point.t, point.n);
        let [theta, spread] = self.d_shape.each_ref().map(|d| {
            let (r, kappa) = if is_strand(segment) {
                let Strand { start, along } = &d.strands[segment / 2];
                (start + along * fraction, T::zero())
            } else {
                let pulley = PULLEYS[segment];
                let chi = by_phi(segment, fraction) * d.phi;
                let across = n * -d.radius[pulley];
                (
                    d.centers[pulley] + across + t * ((self.radius[pulley].v + self.growth.v) * chi),
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
        CoordinateDerivatives {
            theta,
            spread,
            turn: turn_right(point.r - self.middle),
        }
    }
}

impl TwoPulleyFrame<f64> {
    /// The same place, on a segment other than [`TwoPulley::WHOLE`].
    #[must_use]
    pub fn place(&self, segment: usize, fraction: f64) -> CurvePlace {
        let mut place = CurvePlace { segment, fraction };
        if segment == TwoPulley::WHOLE {
            place.segment = 0;
            let mut rest = fraction * self.length;
            while place.segment + 1 < SEGMENTS && rest >= self.lengths[place.segment].v {
                rest -= self.lengths[place.segment].v;
                place.segment += 1;
            }
            place.fraction = (rest / self.lengths[place.segment].v).min(1.0);
        }
        place
    }
}

impl TwoPulley {
    /// Number of segments: half the secondary arc, strand, primary arc, strand, half the secondary
    /// arc.
    pub const SEGMENTS: usize = 5;
    /// The whole curve as a segment of elements that do not follow the arcs.
    pub const WHOLE: usize = Self::SEGMENTS;

    /// The curve at Θ. Outside the admissible range of Θ the frame holds NaN.
    #[must_use]
    pub fn frame<T: Real>(&self, theta: T) -> TwoPulleyFrame<T> {
        self.on_path(&Path::along_theta(theta))
    }

    /// The curve at one place of a path of the coordinates.
    #[must_use]
    pub fn on_path<T: Real>(&self, path: &Path<T>) -> TwoPulleyFrame<T> {
        let CurveCoordinates {
            theta,
            spread,
            turn,
            shift: [x, y],
            growth,
        } = *path;
        let axes = self.center_distance;
        let distance = spread.plus_scaled(Jet::constant(axes), 1.0);
        let (here, by_shape) = dimensions(self, &theta, &distance);
        let Dimensions { r_p, r_s, phi, b } = here;
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
            let along = Jet::polar(b, chi.plus_scaled(quarter, 1.0));
            Strand { start, along }
        });
        let per_length = lengths.map(|length| length.v.recip());
        let toward = arm.v * (distance.v * 0.5).recip();
        let d_shape = std::array::from_fn(|k| {
            let d = &by_shape[k];
            let d_radius = [d.r_s, d.r_p];
            let arc = |radius: T, d_radius: T, angle: T, d_angle: T| d_radius * angle + radius * d_angle;
            let d_lengths = symmetric(
                arc(r_s.v, d.r_s, phi.v, d.phi),
                d.b,
                arc(r_p.v, d.r_p, opposite.v, -d.phi) * 2.0,
            );
            let mut starts = [T::zero(); SEGMENTS];
            for k in 1..SEGMENTS {
                starts[k] = starts[k - 1] + d_lengths[k - 1];
            }
            let apart = T::from(if k == 0 { 0.0 } else { 0.5 });
            let centers = [toward * apart, toward * -apart];
            let per_b = b.v.recip();
            let strands = std::array::from_fn(|strand| {
                let t = strands[strand].along.v * per_b;
                let n = turn_right(t);
                let chi = if strand == 0 { d.phi } else { -d.phi };
                let start = centers[strand] - n * d_radius[strand] + t * (grown[strand].v * chi);
                let along = t * d.b + n * (b.v * chi);
                Strand { start, along }
            });
            ShapeDerivatives {
                centers,
                radius: d_radius,
                phi: d.phi,
                lengths: d_lengths,
                starts,
                dilations: std::array::from_fn(|k| d_lengths[k] * per_length[k]),
                strands,
            }
        });
        TwoPulleyFrame {
            length: self.length,
            centers,
            radius,
            growth,
            strain: growth.map(|growth| growth * (2.0 * PI / self.length)),
            phi,
            turn,
            lengths,
            starts,
            strands,
            middle: middle.v,
            d_shape,
        }
    }
}
