//! The belts of the paper's comparison, as rings of a variator.

use crate::reference_curve::{TwoPulley, ratio_of_theta};
use crate::ring::ancf::AncfElement;
use crate::ring::lagrangian::{LagrangianElement, LagrangianRing};
use crate::ring::rcm::RcmElement;
use crate::travelling::assembly::TravellingCells;
use crate::travelling::order::{self, Travelling};
use crate::travelling::start::state_on_ale;
use pushbelt::ring::mesh::{Spacing, divide};
use pushbelt::variator::ring_models::{
    Ale, Ale0, Assembly, Belt, BeltMesh, BeltRing, CellDivision, Layout, MaterialMesh, eulerian_equations,
};
use pushbelt::variator::settings::{Mesh, Mode, ParameterError, Parameters};
use std::marker::PhantomData;
use std::sync::Arc;

/// `ALE0` or `ALE` on elements spaced evenly at fixed ξ, as in the paper. Arc borders move through
/// the elements, and the reference curvature jumps at the quadrature points that a border passes.
/// Each cell still has one pulley, provided that no arc reaches the quarters of the belt, ξ = L/4
/// and 3L/4.
#[derive(Clone, Copy, Debug)]
pub struct EvenMesh<R>(pub R);

/// `ALE0` or `ALE` with derivatives by forward differentiation, as those of `RCM` and `ANCF`.
#[derive(Clone, Copy, Debug)]
pub struct Forward<R>(pub R);

/// A ring with other equations than those of the FMU.
pub trait OtherEquations: BeltRing {
    /// Equations of a belt with this ring on evenly spaced elements.
    fn even_equations(&self, belt: &Belt) -> Box<dyn Assembly>;

    /// Its equations, differentiated by forward differentiation.
    fn forward_equations(&self, belt: &Belt) -> Box<dyn Assembly>;
}

impl OtherEquations for Ale0 {
    fn even_equations(&self, belt: &Belt) -> Box<dyn Assembly> {
        eulerian_equations(EvenMesh(*self), belt, true)
    }

    fn forward_equations(&self, belt: &Belt) -> Box<dyn Assembly> {
        eulerian_equations(*self, belt, false)
    }
}

impl<const D: usize> OtherEquations for Ale<D> {
    fn even_equations(&self, belt: &Belt) -> Box<dyn Assembly> {
        eulerian_equations(EvenMesh(*self), belt, true)
    }

    fn forward_equations(&self, belt: &Belt) -> Box<dyn Assembly> {
        eulerian_equations(*self, belt, false)
    }
}

impl<R: OtherEquations> BeltRing for Forward<R> {
    fn name(&self) -> &'static str {
        self.0.name()
    }

    fn mesh(&self, sizes: &Mesh) -> BeltMesh {
        self.0.mesh(sizes)
    }

    fn layout(&self, parameters: &Parameters, mesh: &BeltMesh) -> Layout {
        self.0.layout(parameters, mesh)
    }

    fn equations(&self, belt: &Belt) -> Box<dyn Assembly> {
        self.0.forward_equations(belt)
    }
}

impl<R: OtherEquations> BeltRing for EvenMesh<R> {
    fn name(&self) -> &'static str {
        self.0.name()
    }

    /// Each cell has one pulley only if no arc reaches a quarter of the belt.
    fn check(&self, parameters: &Parameters) -> Result<(), ParameterError> {
        let geometry = &parameters.geometry;
        let curve = TwoPulley::new(geometry.center_distance, geometry.belt_length);
        let ratios = parameters.ratio_range();
        let arc = |ratio: f64| {
            let frame = curve.frame::<f64>(ratio_of_theta(ratio));
            let length = |segment| frame.segment_length(segment).v;
            (2.0 * length(0)).max(length(2))
        };
        let longest = arc(*ratios.start()).max(arc(*ratios.end()));
        if longest < 0.5 * geometry.belt_length {
            return self.0.check(parameters);
        }
        Err(ParameterError::new(
            "mesh.aligned",
            false,
            "true, since at an end stop an arc is longer than half the belt",
        ))
    }

    fn mesh(&self, sizes: &Mesh) -> BeltMesh {
        let aligned = self.0.mesh(sizes);
        let cells = CellDivision {
            per_element: aligned.cells_per_element,
            points: aligned.points,
        };
        let elements = divide(TwoPulley::WHOLE, aligned.elements.len(), Spacing::Both(0.0));
        let touches_primary = |_, middle| (0.25..0.75).contains(&middle);
        BeltMesh::of_elements(elements.collect(), cells, touches_primary)
    }

    fn layout(&self, parameters: &Parameters, mesh: &BeltMesh) -> Layout {
        self.0.layout(parameters, mesh)
    }

    fn equations(&self, belt: &Belt) -> Box<dyn Assembly> {
        self.0.even_equations(belt)
    }
}

/// `ALE` with the deflection in D components along the directions of the reference curve, A_i = [t,
/// n, b]_ref in (10).
#[derive(Clone, Copy, Debug)]
pub struct Rotated<const D: usize = 2>;

impl<const D: usize> BeltRing for Rotated<D> {
    fn name(&self) -> &'static str {
        Ale::<D>.name()
    }

    fn mesh(&self, sizes: &Mesh) -> BeltMesh {
        Ale::<D>.mesh(sizes)
    }

    fn layout(&self, parameters: &Parameters, mesh: &BeltMesh) -> Layout {
        Ale::<D>.layout(parameters, mesh)
    }

    fn equations(&self, belt: &Belt) -> Box<dyn Assembly> {
        eulerian_equations(*self, belt, false)
    }
}

/// An element of a ring that travels under the cells.
pub trait TravellingElement: LagrangianElement {
    /// Name of the model.
    const NAME: &'static str;
    /// Default number of elements: the paper's 160 degrees of freedom.
    const USUAL: usize;
    /// Gauss points of an element.
    const POINTS: usize;
}

impl TravellingElement for RcmElement {
    const NAME: &'static str = "RCM";
    const USUAL: usize = 32;
    const POINTS: usize = 5;
}

impl TravellingElement for AncfElement {
    const NAME: &'static str = "ANCF";
    const USUAL: usize = 40;
    const POINTS: usize = 3;
}

/// A ring of elements `E` whose nodes travel with the material.
///
/// The ring is supported at the stations of the cells and sags between them, as far as its elements
/// can follow. With more elements, or a coarser mesh than the default, it oscillates as the
/// stations pass.
#[derive(Clone, Copy, Debug)]
pub struct Travels<E> {
    elements: usize,
    element: PhantomData<fn() -> E>,
}

/// Largest drift of a travelling ring in a step, in element lengths. With twice this value,
/// Newton's method needs twice as many Jacobians. The thrust ratio changes by 3e-4 at four times
/// this value, by 1e-4 at half of it.
const PASSING: f64 = 1.0 / 180.0;

/// Smallest number of elements: an element must turn by less than 1 rad on the smallest arc.
const FEWEST: usize = 16;
/// Largest number of elements.
const MOST: usize = 400;

impl<E: TravellingElement> Travels<E> {
    /// A ring with this number of elements, 16 to 400; 0 is the default number.
    #[must_use]
    pub fn new(elements: usize) -> Self {
        Self {
            elements: if elements == 0 { E::USUAL } else { elements },
            element: PhantomData,
        }
    }

    fn ring(belt: &Belt) -> LagrangianRing<E, TwoPulley> {
        LagrangianRing::new(belt.law.ring.clone(), belt.curve.clone(), belt.layout.nodes, E::POINTS)
    }
}

impl<E: TravellingElement> BeltRing for Travels<E> {
    fn name(&self) -> &'static str {
        E::NAME
    }

    fn check(&self, parameters: &Parameters) -> Result<(), ParameterError> {
        if parameters.is_pull_chain() {
            let range = "1 (PushBelt), unless ring.model is ALE0 or ALE".to_string();
            return Err(ParameterError::new(
                "belt.kind",
                f64::from(parameters.kind as i32),
                range,
            ));
        }
        if parameters.spatial {
            let range = "false, unless ring.model is ALE";
            return Err(ParameterError::new("ring.spatial", true, range));
        }
        if parameters.solver.mode == Mode::RealTime {
            let value = f64::from(Mode::RealTime as i32);
            let range = "1 (Accurate), unless ring.model is ALE0 or ALE";
            return Err(ParameterError::new("solver.mode", value, range.to_string()));
        }
        if (FEWEST..=MOST).contains(&self.elements) {
            return Ok(());
        }
        let range = format!("0 for the ring model's usual number, or {FEWEST} to {MOST}");
        Err(ParameterError::new("ring.elements", self.elements as f64, range))
    }

    fn mesh(&self, sizes: &Mesh) -> BeltMesh {
        let cells = CellDivision {
            per_element: sizes.cells_per_element as usize,
            // A ring with elements of its own sags between the stations, by q d⁴/(384 EI): 2 µm at
            // the largest distance of two stations per cell.
            points: 3,
        };
        BeltMesh::new(sizes, cells)
    }

    /// The nodes have no fixed neighbours among the cells. V and N of each cell come first, then
    /// the nodes, then unknowns that only fill the blocks. The equations reorder them for the
    /// matrix.
    fn layout(&self, parameters: &Parameters, mesh: &BeltMesh) -> Layout {
        let cells = mesh.cells.len();
        let mut layout = Layout {
            nodes: self.elements,
            per_node: E::BLOCK,
            lengths: (0..E::BLOCK).filter(|&k| E::is_length(k)).map(|k| 1 << k).sum(),
            components: 0,
            first_node: 2 * cells,
            next_node: E::BLOCK,
            first_cell: 0,
            next_element: 2 * mesh.cells_per_element,
            next_cell: 2,
            content_beside_next: false,
            ..Layout::deflecting(2, mesh)
        };
        order::set_blocks(&mut layout, mesh, parameters);
        layout
    }

    fn equations(&self, belt: &Belt) -> Box<dyn Assembly> {
        Box::new(TravellingCells::new(belt, Self::ring(belt)))
    }

    fn material_mesh(&self, layout: &Layout, curve: &TwoPulley) -> Option<MaterialMesh> {
        Some(MaterialMesh {
            starts_on: Arc::new(Ale::<2>),
            start: |belt, ale, state| state_on_ale(belt, &Self::ring(belt), ale, state),
            // Contact changes as an element passes a cell.
            longest_drift: PASSING * Travelling::of(layout, curve).length,
            // Steps are short, so the error of the sliding velocity is more restrictive than that
            // of the distance in a step.
            speed_error: 10.0,
        })
    }
}

/// A ring on the aligned or on the even mesh, with the FMU's derivatives or those by forward
/// differentiation.
pub(crate) fn variant<R: OtherEquations + 'static>(
    ring: R,
    aligned: bool,
    forward: bool,
) -> Arc<dyn BeltRing> {
    match (aligned, forward) {
        (true, false) => Arc::new(ring),
        (true, true) => Arc::new(Forward(ring)),
        (false, _) => Arc::new(EvenMesh(ring)),
    }
}
