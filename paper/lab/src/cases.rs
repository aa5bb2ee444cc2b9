//! A trait for all ring models, so that one test runs for each of them.

use std::fmt::Debug;

use crate::system::RingSystem;
use pushbelt::ring::Ring;
use pushbelt_paper::reference_curve::ReferenceCurve;
use pushbelt_paper::ring::ale_ring::{AleRing, OverlayDirections};
use pushbelt_paper::ring::ancf::Ancf;
use pushbelt_paper::ring::mesh::RingMesh;
use pushbelt_paper::ring::model::RingFormulation;
use pushbelt_paper::ring::rcm::Rcm;

/// A ring model under test.
pub trait Case<const D: usize = 2, const N: usize = 10> {
    /// The model on a curve.
    type Model<C: ReferenceCurve + Debug>: RingFormulation<D, N>;
    const NAME: &'static str;
    /// Order of convergence of frequencies in the element length, if both stretch and bending are
    /// relevant.
    const ORDER: f64;
    /// Elements of 160 degrees of freedom, as in the paper.
    const ELEMENTS: usize = 40;
    /// A model with about `elements` elements, exactly so on a circle.
    fn model<C: ReferenceCurve + Debug>(ring: Ring, curve: C, elements: usize) -> Self::Model<C>;
    fn system<C: ReferenceCurve + Debug>(
        ring: Ring,
        curve: C,
        elements: usize,
    ) -> RingSystem<Self::Model<C>, D, N> {
        RingSystem::new(Self::model(ring, curve, elements))
    }
}

/// A mesh of about `elements` elements with borders on the arcs.
pub fn aligned(segments: usize, elements: usize, points: usize) -> RingMesh {
    match segments {
        1 => RingMesh::even(&[elements], points),
        5 => RingMesh::even(&[1, 1, 2, 1, 1].map(|n| n * (elements / 6).max(1)), points),
        n => RingMesh::even(&vec![(elements / n).max(1); n], points),
    }
}

pub struct Ale;

pub struct AleTurning;

pub struct AleSpatial;

pub struct AleSpatialTurning;

pub struct AbsoluteNodal;

pub struct CoRotational;

impl Case for Ale {
    type Model<C: ReferenceCurve + Debug> = AleRing<C>;
    const NAME: &'static str = "ALE";
    const ORDER: f64 = 4.0;
    fn model<C: ReferenceCurve + Debug>(ring: Ring, curve: C, elements: usize) -> AleRing<C> {
        let mesh = aligned(curve.segments(), elements, 3);
        AleRing::flexible(ring, curve, mesh)
    }
}

impl Case for AleTurning {
    type Model<C: ReferenceCurve + Debug> = AleRing<C>;
    const NAME: &'static str = "ALE, overlay along t and n";
    const ORDER: f64 = 4.0;
    fn model<C: ReferenceCurve + Debug>(ring: Ring, curve: C, elements: usize) -> AleRing<C> {
        let mut model = Ale::model(ring, curve, elements);
        model.directions = OverlayDirections::Reference;
        model
    }
}

impl Case<3, 14> for AleSpatial {
    type Model<C: ReferenceCurve + Debug> = AleRing<C, 3>;
    const NAME: &'static str = "ALE in space";
    const ORDER: f64 = 4.0;
    fn model<C: ReferenceCurve + Debug>(ring: Ring, curve: C, elements: usize) -> AleRing<C, 3> {
        let mesh = aligned(curve.segments(), elements, 3);
        AleRing::spatial(ring, curve, mesh)
    }
}

impl Case<3, 14> for AleSpatialTurning {
    type Model<C: ReferenceCurve + Debug> = AleRing<C, 3>;
    const NAME: &'static str = "ALE in space, overlay along t, n and b";
    const ORDER: f64 = 4.0;
    fn model<C: ReferenceCurve + Debug>(ring: Ring, curve: C, elements: usize) -> AleRing<C, 3> {
        let mut model = AleSpatial::model(ring, curve, elements);
        model.directions = OverlayDirections::Reference;
        model
    }
}

impl Case for AbsoluteNodal {
    type Model<C: ReferenceCurve + Debug> = Ancf<C>;
    const NAME: &'static str = "ANCF";
    const ORDER: f64 = 4.0;
    fn model<C: ReferenceCurve + Debug>(ring: Ring, curve: C, elements: usize) -> Ancf<C> {
        Ancf::new(ring, curve, elements, 3)
    }
}

impl Case for CoRotational {
    type Model<C: ReferenceCurve + Debug> = Rcm<C>;
    const NAME: &'static str = "RCM";
    const ELEMENTS: usize = 32;
    // One strain per element. Bending alone has order 4.
    const ORDER: f64 = 2.0;
    fn model<C: ReferenceCurve + Debug>(ring: Ring, curve: C, elements: usize) -> Rcm<C> {
        Rcm::new(ring, curve, elements, 5)
    }
}
