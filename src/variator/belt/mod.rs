//! The belt: constants of its cells, mesh, layout of the unknowns, reference curve. It is constant
//! in a run.

pub(crate) mod equations;
pub(crate) mod ring;

use crate::pulley::{PerPulley, Pulley, Wedge};
use crate::reference_curve::{COORDINATES, Jet, Path, TwoPulley, TwoPulleyFrame};
use crate::solver::View;
use crate::variator::belt::ring::{BeltRing, MaterialMesh};
use crate::variator::law::arguments::{CellLaw, SheavePlane};
use crate::variator::mesh::belt_mesh::BeltMesh;
use crate::variator::mesh::layout::Layout;
use crate::variator::settings::parameters::Parameters;
use std::sync::Arc;

/// Scale of rows of constraints, of the order of the other entries of a row.
pub const CONSTRAINT_SCALE: f64 = 1.0e6;

/// Change of Θ, and of the turn of displaced centres, per metre of the ring's position, 1/m,
/// roughly.
pub(crate) const THETA_PER_METRE: f64 = 10.0;

/// The constants of a belt.
#[derive(Clone, Debug)]
pub struct Belt {
    /// Model of the ring.
    pub ring: Arc<dyn BeltRing>,
    /// Start and steps, if the ring's nodes move with the material.
    pub material_mesh: Option<MaterialMesh>,
    /// Constants of the cells.
    pub law: CellLaw,
    /// Elements and cells along the belt.
    pub mesh: BeltMesh,
    /// Indices of the unknowns.
    pub layout: Layout,
    /// Reference curve of the ring.
    pub curve: TwoPulley,
    /// Unknowns of the elements of each cell.
    pub cells_at: Vec<CellUnknowns>,
    /// Whether each unknown is the rate of a position.
    pub has_position: Vec<bool>,
}

/// Indices of the unknowns of a cell's elements.
#[derive(Clone, Copy, Debug)]
pub struct CellUnknowns {
    /// Speed V at the left face.
    pub speed: usize,
    /// Content N.
    pub content: usize,
}

impl Belt {
    /// The belt of a variator with this ring.
    ///
    /// # Panics
    /// With parameters that [`Parameters::validate`] rejects.
    #[must_use]
    pub fn new(parameters: &Parameters, ring: Arc<dyn BeltRing>) -> Self {
        let parameters = &parameters.in_force();
        let geometry = &parameters.geometry;
        let curve = TwoPulley::new(geometry.center_distance, geometry.belt_length);
        let radii = curve.radii(1.0).expect("validated geometry closes at ratio 1");
        let (sin, cos) = geometry.wedge_angle.sin_cos();
        let mesh = ring.mesh(&parameters.mesh);
        let layout = ring.layout(parameters, &mesh);
        Self {
            material_mesh: ring.material_mesh(&layout, &curve),
            ring,
            law: CellLaw {
                stack: parameters.belt.clone(),
                ring: parameters.ring.clone(),
                layers: parameters.layers,
                joints: parameters.is_pull_chain().then_some(parameters.joints),
                saddle_mass: if parameters.is_pull_chain() {
                    0.0
                } else {
                    parameters.ring.mass_per_length
                },
                saddle_offset: parameters.saddle_offset(),
                contact: parameters.contact.clone(),
                wedge: Wedge {
                    sin,
                    cos,
                    tan: sin / cos,
                },
                r0: radii.primary - parameters.belt.pitch_offset,
                axes: PerPulley {
                    secondary: 0.0,
                    primary: geometry.center_distance,
                },
                planes: SheavePlane::pair(geometry.pulley_offset),
            },
            cells_at: (0..mesh.cells.len())
                .map(|cell| CellUnknowns {
                    speed: layout.belt_speed(cell),
                    content: layout.content(cell),
                })
                .collect(),
            has_position: layout.has_position(),
            mesh,
            layout,
            curve,
        }
    }

    /// Θ in a state.
    #[must_use]
    pub fn theta(&self, view: View<'_>) -> f64 {
        view.q[self.layout.theta()]
    }

    /// Coordinates of the reference curve in a state, and their motion.
    #[must_use]
    pub fn path(&self, view: View<'_>) -> Path<f64> {
        let mut path = [Jet::constant(0.0); COORDINATES];
        let at = std::iter::once(self.layout.theta()).chain(self.layout.centres());
        for (to, i) in path.iter_mut().zip(at) {
            *to = Jet {
                v: view.q[i],
                d: view.y[i],
                dd: view.y_dot[i],
            };
        }
        Path::from_array(path)
    }

    /// Angular speeds of the pulleys, rad/s.
    #[must_use]
    pub fn shaft_speeds(&self, view: View<'_>) -> PerPulley<f64> {
        PerPulley::from_fn(|pulley| view.y[self.layout.shaft_speed(pulley)])
    }

    /// Middles of the pulleys along z, m.
    #[must_use]
    pub fn middles(&self, view: View<'_>) -> PerPulley<f64> {
        PerPulley::from_fn(|pulley: Pulley| {
            self.law.planes[pulley].middle(view.q[self.layout.sheave(pulley)])
        })
    }

    /// Length of an element, m.
    #[must_use]
    pub fn element_length(&self, frame: &TwoPulleyFrame<f64>, element: usize) -> f64 {
        let element = &self.mesh.elements[element];
        frame.segment_length(element.segment).v * element.length
    }

    /// The gauge conditions: s and Θ duplicate motions of the overlay. The deflections of node 0
    /// and of the opposite node are equal outwards (which determines Θ) and opposite along the
    /// curve (which determines s). In directions of the curve these are the same two conditions in
    /// reverse order: t of node 0 is along y, n along x, and both are reversed at the opposite
    /// node.
    pub fn gauge(&self) -> impl Iterator<Item = GaugeCondition> + use<> {
        let layout = self.layout;
        let components = [(0, [1.0, 1.0]), (1, [1.0, -1.0])];
        components
            .into_iter()
            .filter(move |_| layout.components > 0)
            .map(move |(k, signs)| GaugeCondition {
                multiplier: layout.gauge(k),
                nodes: [0, layout.elements / 2].map(|node| layout.node(node, 2 * k)),
                signs,
            })
    }
}

/// A condition on the velocities a of two nodes, a·`signs` = 0, and its multiplier.
pub struct GaugeCondition {
    /// Unknown of the multiplier.
    pub multiplier: usize,
    /// Unknowns of the two nodes.
    pub nodes: [usize; 2],
    /// Their signs.
    pub signs: [f64; 2],
}
