//! The reference curve of a belt drive with any number of pulleys, back-side idlers included (paper
//! section 7).
//!
//! Pulleys are listed clockwise along the belt. A pulley inside the loop has a positive radius ρ;
//! one on the back of the belt has a negative ρ. With t = (sin χ, cos χ), n = (cos χ, −sin χ) the
//! belt on a pulley is at O − ρ n, so the strand from pulley j to the next has D = O' − O = b t +
//! (ρ' − ρ) n:
//!
//! b = √(D² − (ρ'−ρ)²), χ = atan2(D_x, D_y) − asin((ρ'−ρ)/|D|),
//!
//! and the arc on a pulley has the length ρ (χ_out − χ_in); χ_out − χ_in has the sign of ρ. The sum
//! over all arcs is 2π. The curve starts at the leftmost point of pulley 0, χ = 0, which must lie
//! on its arc. Its segments are the rest of that arc, strand, arc, …, strand, and the beginning of
//! that arc.
//!
//! Without a [`Tensioner`] all axes are fixed, the belt has the length that fits, and there is no
//! Θ. A tensioner carries one pulley on an arm about a pivot. Θ is the arm's angle, and the arm's
//! length a(Θ) keeps the belt's length constant, as r_P(Θ) does in a variator.

use nalgebra::Vector2;
use num_dual::{Dual3_64, DualNum};
use pushbelt::scalar::{Real, turn_right};
use pushbelt_paper::reference_curve::{Jet, ReferenceCurve, ReferencePoint, TangentAngle};
use std::array::from_fn;
use std::f64::consts::TAU;

/// A pulley with the radius of the belt's centre line on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrivePulley {
    /// Axis, m.
    pub center: [f64; 2],
    /// Radius of the belt's centre line, m; negative on the back of the belt.
    pub radius: f64,
}

/// An arm that carries a pulley.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tensioner {
    /// Index of the pulley; not 0. The arm points to its axis for Θ = 0.
    pub pulley: usize,
    /// Pivot of the arm, m.
    pub pivot: [f64; 2],
}

/// No belt runs around these pulleys.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DriveError {
    /// Fewer than two pulleys.
    #[error("a belt drive needs two pulleys")]
    TooFew,
    /// Two consecutive pulleys overlap, or the belt touches a pulley on the wrong side.
    #[error("the belt does not wrap pulley {0} in the sense of its radius")]
    Wrap(usize),
    /// The leftmost point of pulley 0 is not on the belt.
    #[error("the leftmost point of pulley 0 is not on its arc, so the curve cannot start there")]
    Start,
    /// The tensioner carries pulley 0, no pulley, or a pulley at its own pivot.
    #[error("a tensioner carries a pulley other than pulley 0 and does not have its axis for a pivot")]
    Tensioner,
}

/// A belt drive with N pulleys.
#[derive(Clone, Debug)]
pub struct BeltDrive<const N: usize> {
    pulleys: [DrivePulley; N],
    length: f64,
    tensioner: Option<Arm>,
}

/// Limit of Newton steps for the length of an arm.
const NEWTON_STEPS: usize = 50;
/// Newton's last step as a share of the belt's length, below rounding.
const LAST_STEP: f64 = 1e-16;
/// Largest arc of a pulley, rad: three quarters of a turn. A larger arc means a strand on the wrong
/// side.
const LARGEST_WRAP: f64 = 0.75 * TAU;

/// The arm of a [`Tensioner`] with the length that it has for Θ = 0.
#[derive(Clone, Copy, Debug)]
struct Arm {
    pulley: usize,
    pivot: [f64; 2],
    length: f64,
    /// Direction for Θ = 0.
    angle: f64,
}

/// Axes with derivatives.
type Centers<D, const N: usize> = [[D; 2]; N];

/// atan2(x, y) with derivatives that are valid for all signs of x and y.
fn direction<D: DualNum<Primitive = f64> + Copy>(x: D, y: D) -> D {
    let value = x.re().atan2(y.re());
    let (sin, cos) = value.sin_cos();
    ((x * cos - y * sin) / (x * sin + y * cos)).atan() + value
}

/// χ, continuous along the belt, and length b of the strand after each pulley.
fn strands<D: DualNum<Primitive = f64> + Copy, const N: usize>(
    pulleys: &[DrivePulley; N],
    centers: &Centers<D, N>,
) -> [(D, D); N] {
    let mut before: Option<f64> = None;
    from_fn(|j| {
        let next = (j + 1) % N;
        let [dx, dy] = [0, 1].map(|k| centers[next][k] - centers[j][k]);
        let difference = pulleys[next].radius - pulleys[j].radius;
        let square = dx * dx + dy * dy;
        let b = (square - difference * difference).sqrt();
        let chi = direction(dx, dy) - (square.sqrt().recip() * difference).asin();
        // χ increases on a pulley of positive radius and decreases on one of negative radius.
        let least = match before {
            None => 0.0,
            Some(before) if pulleys[j].radius > 0.0 => before,
            Some(before) => before - TAU,
        };
        let chi = chi - ((chi.re() - least) / TAU).floor() * TAU;
        before = Some(chi.re());
        (chi, b)
    })
}

/// Length of the belt, m.
fn belt_length<D: DualNum<Primitive = f64> + Copy, const N: usize>(
    pulleys: &[DrivePulley; N],
    centers: &Centers<D, N>,
) -> D {
    let strands = strands(pulleys, centers);
    let mut length = D::from(0.0);
    let mut before = strands[N - 1].0 - TAU;
    for (pulley, (chi, b)) in pulleys.iter().zip(strands) {
        length += b + (chi - before) * pulley.radius;
        before = chi;
    }
    length
}

impl<const N: usize> BeltDrive<N> {
    /// A drive with fixed axes, around which the belt just fits.
    ///
    /// # Errors
    /// No belt runs around these pulleys.
    pub fn new(pulleys: [DrivePulley; N]) -> Result<Self, DriveError> {
        if N < 2 {
            return Err(DriveError::TooFew);
        }
        let centers = pulleys.map(|p| p.center);
        let strands = strands(&pulleys, &centers);
        for (j, &(_, b)) in strands.iter().enumerate() {
            if b.is_nan() || b <= 0.0 {
                return Err(DriveError::Wrap(j));
            }
        }
        let (first, end) = (strands[0].0, strands[N - 1].0);
        // One turn in total, and χ = 0 is on the arc of pulley 0.
        if pulleys[0].radius <= 0.0 || !(0.0..TAU).contains(&first) || !(0.0..=TAU).contains(&end) {
            return Err(DriveError::Start);
        }
        for j in 1..N {
            if (strands[j].0 - strands[j - 1].0).abs() > LARGEST_WRAP {
                return Err(DriveError::Wrap(j));
            }
        }
        let length = belt_length(&pulleys, &centers);
        Ok(Self {
            pulleys,
            length,
            tensioner: None,
        })
    }

    /// The same drive with a pulley on an arm. Θ is the clockwise rotation of the arm from this
    /// position, rad.
    ///
    /// # Errors
    /// [`DriveError::Tensioner`].
    pub fn with_tensioner(mut self, tensioner: Tensioner) -> Result<Self, DriveError> {
        let pulley = self.pulleys.get(tensioner.pulley).ok_or(DriveError::Tensioner)?;
        let arm = Vector2::from(pulley.center) - Vector2::from(tensioner.pivot);
        if tensioner.pulley == 0 || arm.norm() == 0.0 {
            return Err(DriveError::Tensioner);
        }
        self.tensioner = Some(Arm {
            pulley: tensioner.pulley,
            pivot: tensioner.pivot,
            length: arm.norm(),
            angle: arm.x.atan2(arm.y),
        });
        Ok(self)
    }

    /// Axes with the arm at the angle Θ and of the length `a`.
    fn centers<D: DualNum<Primitive = f64> + Copy>(&self, theta: D, a: D) -> Centers<D, N> {
        let mut centers = self.pulleys.map(|p| p.center.map(D::from));
        if let Some(arm) = &self.tensioner {
            let (sin, cos) = (theta + arm.angle).sin_cos();
            centers[arm.pulley] = [a * sin + arm.pivot[0], a * cos + arm.pivot[1]];
        }
        centers
    }

    /// Axes at Θ for which the belt fits, with derivatives; NaN if there are none.
    fn fitting_centers(&self, theta: f64) -> Centers<Dual3_64, N> {
        let variable = Dual3_64::from_re(theta).derivative();
        let Some(arm) = &self.tensioner else {
            return self.centers(variable, Dual3_64::from_re(0.0));
        };
        let fit = |theta: f64, a: f64| {
            let by_arm = belt_length(
                &self.pulleys,
                &self.centers(Dual3_64::from_re(theta), Dual3_64::from_re(a).derivative()),
            );
            (by_arm.re - self.length, by_arm.v1)
        };
        let mut a = arm.length;
        let mut slope = f64::NAN;
        for _ in 0..NEWTON_STEPS {
            let (off, by_arm) = fit(theta, a);
            slope = by_arm;
            let step = off / by_arm;
            a -= step;
            if step.abs() < LAST_STEP * self.length {
                break;
            }
        }
        // The value has converged; each further Newton step makes one more derivative exact.
        let mut jet = Dual3_64::from_re(a);
        for _ in 0..3 {
            jet -= (belt_length(&self.pulleys, &self.centers(variable, jet)) - self.length) / slope;
        }
        self.centers(variable, jet)
    }
}

/// A segment at one Θ.
#[derive(Clone, Copy, Debug)]
struct Segment<T> {
    start: Jet<T>,
    length: Jet<T>,
    /// χ at its start.
    chi: Jet<T>,
    /// Change of χ along it.
    sweep: Jet<T>,
    /// Signed radius; infinite on a strand.
    radius: f64,
    /// Axis of an arc, start of a strand.
    place: [Jet<T>; 2],
}

/// [`BeltDrive`] at one Θ.
#[derive(Clone, Copy, Debug)]
pub struct DriveFrame<T: Real, const N: usize> {
    /// Arcs in the order of the belt, the first from χ = 0 on.
    arcs: [Segment<T>; N],
    strands: [Segment<T>; N],
    /// The beginning of the first arc, up to χ = 2π.
    closing: Segment<T>,
}

impl<T: Real, const N: usize> DriveFrame<T, N> {
    fn segment(&self, segment: usize) -> &Segment<T> {
        match (segment / 2, segment % 2) {
            (j, 0) if j < N => &self.arcs[j],
            (j, 1) => &self.strands[j],
            _ => &self.closing,
        }
    }
}

impl<const N: usize> ReferenceCurve for BeltDrive<N> {
    type Frame<T: Real> = DriveFrame<T, N>;

    fn length(&self) -> f64 {
        self.length
    }

    fn segments(&self) -> usize {
        2 * N + 1
    }

    fn frame<T: Real>(&self, theta: T) -> DriveFrame<T, N> {
        let value = theta.re();
        let rest = theta - value;
        let centers = self.fitting_centers(value);
        let behind = strands(&self.pulleys, &centers);
        // A third-order jet in Θ, in the scalar of Θ.
        let lift = |x: Dual3_64| Jet {
            v: rest * x.v1 + x.re,
            d: rest * x.v2 + x.v1,
            dd: rest * x.v3 + x.v2,
        };
        let zero = Dual3_64::from_re(0.0);
        let (mut start, mut fits) = (zero, true);
        let mut segment =
            |length: Dual3_64, chi: Dual3_64, sweep: Dual3_64, radius: f64, place: [Dual3_64; 2]| {
                let segment = Segment {
                    start: lift(start),
                    length: lift(length),
                    chi: lift(chi),
                    sweep: lift(sweep),
                    radius,
                    place: place.map(lift),
                };
                start += length;
                fits &= length.re > 0.0;
                segment
            };
        let mut chi = zero;
        let both: [_; N] = from_fn(|j| {
            let radius = self.pulleys[j].radius;
            let (out, b) = behind[j];
            let [x, y] = centers[j];
            let arc = segment((out - chi) * radius, chi, out - chi, radius, [x, y]);
            let (sin, cos) = out.sin_cos();
            let strand = segment(b, out, zero, f64::INFINITY, [x - cos * radius, y + sin * radius]);
            chi = out;
            (arc, strand)
        });
        let left = -chi + TAU;
        let radius = self.pulleys[0].radius;
        let closing = segment(left * radius, chi, left, radius, centers[0]);
        let mut frame = DriveFrame {
            arcs: both.map(|(arc, _)| arc),
            strands: both.map(|(_, strand)| strand),
            closing,
        };
        if !fits {
            // The belt does not touch a pulley.
            frame.closing.length = Jet::constant(f64::NAN);
        }
        frame
    }

    fn segment_length<T: Real>(frame: &DriveFrame<T, N>, segment: usize) -> Jet<T> {
        frame.segment(segment).length
    }

    fn point<T: Real>(frame: &DriveFrame<T, N>, segment: usize, fraction: T::Constant) -> ReferencePoint<T> {
        let s = frame.segment(segment);
        let xi = s.start.plus_scaled(s.length, fraction);
        let chi = s.chi.plus_scaled(s.sweep, fraction);
        let (sin, cos) = chi.v.sin_cos();
        let t = Vector2::new(sin, cos);
        let n = turn_right(t);
        let place = [|j: &Jet<T>| j.v, |j: &Jet<T>| j.d, |j: &Jet<T>| j.dd]
            .map(|of| Vector2::new(of(&s.place[0]), of(&s.place[1])));
        let curved = s.radius.is_finite();
        // Relative to `place`: −ρ n on an arc, x t on a strand; t_Θ = χ_Θ n, n_Θ = −χ_Θ t.
        let [r, r_theta, r_theta2] = if curved {
            let rho = T::from(s.radius);
            [
                place[0] - n * rho,
                place[1] + t * (rho * chi.d),
                place[2] + (t * chi.dd + n * (chi.d * chi.d)) * rho,
            ]
        } else {
            let x = Jet::constant(0.0).plus_scaled(s.length, fraction);
            [
                place[0] + t * x.v,
                place[1] + t * x.d + n * (x.v * chi.d),
                place[2] + t * (x.dd - x.v * chi.d * chi.d) + n * (x.d * chi.d * 2.0 + x.v * chi.dd),
            ]
        };
        ReferencePoint {
            r,
            r_theta,
            r_theta2,
            t,
            n,
            chi_theta: chi.d,
            kappa: T::from(s.radius.recip()),
            kappa_theta: T::zero(),
            xi,
        }
    }

    fn has_ratio(&self) -> bool {
        self.tensioner.is_some()
    }

    fn tangent_angle<T: Real>(
        frame: &DriveFrame<T, N>,
        segment: usize,
        fraction: T::Constant,
    ) -> TangentAngle<T> {
        let s = frame.segment(segment);
        TangentAngle {
            chi: s.chi.plus_scaled(s.sweep, fraction),
            kappa: Jet::constant(s.radius.recip()),
        }
    }
}
