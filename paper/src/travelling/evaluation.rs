//! A cell over a travelling ring, evaluated with plain numbers or with derivatives.

use crate::reference_curve::{Jet, ReferencePoint, TwoPulley, TwoPulleyFrame};
use crate::ring::beam;
use crate::ring::kinematics::Motion;
use crate::ring::lagrangian::{LagrangianElement, LagrangianRing};
use crate::ring::model::{Coordinates, NODAL, RingFormulation as _};
use crate::scalar::{Real, Tangent};
use crate::solver::View;
use crate::travelling::order::nodal;
use crate::travelling::passing::{CellOver, CellRows, DRIFT, GAUGE, Passing, RingAtPoint};
use pushbelt::solver::Factors;
use pushbelt::variator::ring_models::{
    AtStation, CELL_POINTS, CellGeometry, CellInput, CellMotion, CellPoints, CellRing, Extent, FirstUnknowns,
    InForce, Layout, StateComponent, balance,
};
use std::ops::Mul;

/// Directions differentiated in one pass over a cell.
pub(super) const PASS: usize = 4;
/// A number with its derivatives in the directions of a pass.
pub(super) type Differentiated = Tangent<PASS, f64>;

/// Tension of an element at its mean strain, N, and its derivatives with respect to the element's
/// unknowns.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct MeanTension {
    pub value: f64,
    pub derivatives: [f64; NODAL],
}

/// The scalars of an evaluation of a cell, and the directions of their derivatives.
pub(super) trait Scalars: Copy {
    /// Scalar of the equations.
    type T: Real<Constant = f64> + Mul<Self::W, Output = Self::T>;
    /// Scalar of places on the ring: a plain number where the mesh is fixed.
    type W: Real;
    /// Factors of ẏ and q in the derivatives.
    fn factors(&self) -> Factors;
    /// The scalar of a value, its direction and its derivative.
    fn seed(&self, value: f64, direction: usize, derivative: f64) -> Self::T;
    /// The scalar of a place on the ring.
    fn coordinate(&self, coordinate: Self::T) -> Self::W;
}

/// Plain numbers without derivatives.
#[derive(Clone, Copy)]
pub(super) struct Values;

impl Scalars for Values {
    type T = f64;
    type W = f64;
    fn factors(&self) -> Factors {
        Factors::ZERO
    }
    #[inline(always)]
    fn seed(&self, value: f64, _direction: usize, _derivative: f64) -> f64 {
        value
    }
    #[inline(always)]
    fn coordinate(&self, coordinate: f64) -> f64 {
        coordinate
    }
}

/// Derivatives in the directions from `first` on, none of which moves the mesh.
#[derive(Clone, Copy)]
pub(super) struct Still {
    pub first: usize,
    pub factors: Factors,
}

impl Scalars for Still {
    type T = Differentiated;
    type W = f64;
    fn factors(&self) -> Factors {
        self.factors
    }
    #[inline(always)]
    fn seed(&self, value: f64, direction: usize, derivative: f64) -> Differentiated {
        Differentiated::seed(value, direction.wrapping_sub(self.first), derivative)
    }
    #[inline(always)]
    fn coordinate(&self, coordinate: Differentiated) -> f64 {
        coordinate.re
    }
}

/// Derivatives in the directions from `first` on, one of which moves the mesh.
#[derive(Clone, Copy)]
pub(super) struct Moving(pub Still);

impl Scalars for Moving {
    type T = Differentiated;
    type W = Differentiated;
    fn factors(&self) -> Factors {
        self.0.factors
    }
    #[inline(always)]
    fn seed(&self, value: f64, direction: usize, derivative: f64) -> Differentiated {
        self.0.seed(value, direction, derivative)
    }
    #[inline(always)]
    fn coordinate(&self, coordinate: Differentiated) -> Differentiated {
        coordinate
    }
}

/// Belt, state and ring of an evaluation of cells.
pub(super) struct Evaluation<'a, E: LagrangianElement> {
    pub acting: InForce<'a>,
    pub view: View<'a>,
    pub ring: &'a LagrangianRing<E, TwoPulley>,
    pub mean_tensions: &'a [MeanTension],
}

/// The unknowns of a cell as scalars, by their directions.
#[derive(Clone, Copy)]
struct CellScalars<'a, S> {
    view: View<'a>,
    at: &'a [usize],
    scalars: S,
}

impl<S: Scalars> CellScalars<'_, S> {
    #[inline(always)]
    fn unknown(&self, part: StateComponent, k: usize) -> S::T {
        let Factors { alpha, beta } = self.scalars.factors();
        let (of, factor) = match part {
            StateComponent::Position => (self.view.q, beta),
            StateComponent::Value => (self.view.y, 1.0),
            StateComponent::Rate => (self.view.y_dot, alpha),
        };
        self.scalars.seed(of[self.at[k]], k, factor)
    }
}

impl<E: LagrangianElement> Evaluation<'_, E> {
    /// The balance of a cell and the forces on its ring.
    #[inline(always)]
    pub fn cell<S: Scalars>(
        &self,
        over: &CellOver,
        frame: &TwoPulleyFrame<S::T>,
        scalars: S,
        observe: impl FnMut(&AtStation<'_, S::T>),
    ) -> CellRows<S::T> {
        let InForce { belt, friction } = self.acting;
        let law = &belt.law;
        let of = CellScalars {
            view: self.view,
            at: over.unknowns(),
            scalars,
        };
        let own = over.nodal();
        let globals = own + DRIFT;
        let first = FirstUnknowns {
            own,
            drift: globals,
            sheave: globals + 2,
        };
        let motion = CellMotion::from_unknowns(first, |part, k| of.unknown(part, k));
        let of_mesh = &belt.mesh.cells[over.cell];
        let element = &belt.mesh.elements[of_mesh.element];
        let drags = law.arc_drags(frame.radius.map(|radius| radius.v), frame.wraps());
        let geometry = CellGeometry {
            // Stations of the mesh have fractions of the segment.
            extent: Extent {
                start: 0.0,
                length: 1.0,
            },
            face: &of_mesh.face,
            stations: &of_mesh.stations,
            axis: law.axes[of_mesh.pulley],
            plane: law.planes[of_mesh.pulley],
            length: Jet::constant(0.0).plus_scaled(frame.segment_length(element.segment), element.length),
            layer_drag: drags.layers[of_mesh.pulley],
            rotation_drag: drags.rotation[of_mesh.pulley],
        };
        let drift = of.unknown(StateComponent::Position, globals);
        let per_element = self.ring.element_length().recip();
        let points: [_; CELL_POINTS] = std::array::from_fn(|number| {
            (number <= of_mesh.stations.len()).then(|| {
                let reference = frame.point(element.segment, geometry.fraction(number));
                let x = ((reference.xi.v - drift) * per_element - over.turn[number]) * 2.0 - 1.0;
                self.ring_at(over, number, reference, x, &of)
            })
        });
        let multipliers = [GAUGE, GAUGE + 1].map(|k| of.unknown(StateComponent::Value, own + k));
        let mut passing = Passing::<_, _, E>::new(points, &motion.reference, multipliers);
        let given = CellInput {
            law,
            friction,
            geometry: &geometry,
            motion: &motion,
        };
        let (balance, _) = balance(&given, &mut passing, &mut CellPoints::empty(), observe);
        CellRows {
            balance,
            ring: passing.forces(),
        }
    }

    /// The ring at a point, where its element is at the local coordinate `x` from −1 to 1.
    #[inline(always)]
    fn ring_at<S: Scalars>(
        &self,
        over: &CellOver,
        number: usize,
        reference: ReferencePoint<S::T>,
        x: S::T,
        of: &CellScalars<'_, S>,
    ) -> RingAtPoint<S::T, S::W, E> {
        let first = over.first(number);
        let unknowns: [Motion<S::T>; NODAL] = std::array::from_fn(|k| Motion {
            value: of.unknown(StateComponent::Position, first + k),
            rate: of.unknown(StateComponent::Value, first + k),
            acceleration: of.unknown(StateComponent::Rate, first + k),
        });
        let motion = self.ring.motion(&unknowns);
        let shape = E::shape(of.scalars.coordinate(x));
        let particle = E::particle(&motion, &shape);
        let tension = if E::MEAN_STRAIN {
            self.mean_tension(over.element(number), first, of.scalars)
        } else {
            beam::tension(self.ring.ring(), particle.strain(), particle.strain_rate())
        };
        RingAtPoint {
            reference,
            motion,
            shape,
            particle,
            tension,
        }
    }

    /// Tension at the mean strain of an element whose first direction is `first`, N.
    #[inline(always)]
    fn mean_tension<S: Scalars>(&self, element: usize, first: usize, scalars: S) -> S::T {
        let mean = &self.mean_tensions[element];
        let derivatives = mean.derivatives.iter().enumerate();
        derivatives.fold(S::T::from(mean.value), |sum, (k, &derivative)| {
            sum + scalars.seed(0.0, first + k, derivative)
        })
    }
}

/// Motion of the unknowns of an element: `seed` makes a scalar from a value, its direction and its
/// derivative.
pub(super) fn coordinates<T: Real>(
    layout: &Layout,
    view: View<'_>,
    element: usize,
    Factors { alpha, beta }: Factors,
    seed: impl Fn(f64, usize, f64) -> T,
) -> Coordinates<T> {
    std::array::from_fn(|k| {
        if k >= NODAL {
            return Motion {
                value: T::zero(),
                rate: T::zero(),
                acceleration: T::zero(),
            };
        }
        let at = nodal(layout, element, k);
        Motion {
            value: seed(view.q[at], k, beta),
            rate: seed(view.y[at], k, 1.0),
            acceleration: seed(view.y_dot[at], k, alpha),
        }
    })
}

/// Motion of the unknowns of an element as plain numbers.
pub(super) fn values(layout: &Layout, view: View<'_>, element: usize) -> Coordinates<f64> {
    coordinates(layout, view, element, Factors::ZERO, |value, _, _| value)
}
