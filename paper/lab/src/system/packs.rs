//! Neighbouring elements, one in each lane of a register.

use pushbelt::scalar::{LANES, Lanes, Real, Tangent};
use pushbelt::solver::View;
use pushbelt::solver::arrow::{Arrow, Shape};
use pushbelt_paper::ring::kinematics::Motion;
use pushbelt_paper::ring::model::{Coordinates, RingFormulation};
use std::array;

/// Directions differentiated in one pass over a pack of elements.
const PASS: usize = 5;

/// Shape of the matrix of a ring alone.
pub(super) fn shape<M: RingFormulation<D, N>, const D: usize, const N: usize>(model: &M) -> Shape {
    Shape {
        blocks: model.elements(),
        block: M::BLOCK,
        border: 2,
    }
}

/// Motion of an element's unknowns: `read` returns unknown k of the element from a vector, `seed`
/// makes a scalar from a value, its direction and its derivative.
#[inline(always)]
pub(super) fn coordinates<W, T: Real, const N: usize>(
    view: View<'_>,
    [alpha, beta]: [f64; 2],
    read: impl Fn(&[f64], usize) -> W,
    seed: impl Fn(W, usize, f64) -> T,
) -> Coordinates<T, N> {
    array::from_fn(|k| Motion {
        value: seed(read(view.q, k), k, beta),
        rate: seed(read(view.y, k), k, 1.0),
        acceleration: seed(read(view.y_dot, k), k, alpha),
    })
}

/// Neighbouring elements, one in each lane of a register.
#[derive(Clone, Debug)]
pub(super) struct ElementPack<const N: usize> {
    /// The first element.
    pub(super) first: usize,
    /// Unknowns of each element.
    pub(super) elements: Vec<[usize; N]>,
    /// Places in the matrix of each element's derivatives.
    pub(super) entries: Vec<[[usize; N]; N]>,
    /// Unknowns by lane; the first element is repeated in unused lanes.
    lanes: [[usize; LANES]; N],
}

impl<const N: usize> ElementPack<N> {
    pub(super) fn all<M: RingFormulation<D, N>, const D: usize>(model: &M) -> Vec<Self> {
        let shape = shape::<M, D, N>(model);
        let elements: Vec<_> = (0..model.elements()).map(|element| model.directions(element)).collect();
        let entry = |i, j| shape.index(i, j).expect("an entry in the band");
        let chunks = elements.chunks(LANES).enumerate();
        chunks
            .map(|(k, elements)| Self {
                first: k * LANES,
                elements: elements.to_vec(),
                entries: elements.iter().map(|at| at.map(|i| at.map(|j| entry(i, j)))).collect(),
                lanes: array::from_fn(|i| {
                    array::from_fn(|lane| elements.get(lane).unwrap_or(&elements[0])[i])
                }),
            })
            .collect()
    }

    /// Motion of its unknowns.
    #[inline(always)]
    pub(super) fn motion<T: Real>(
        &self,
        view: View<'_>,
        slopes: [f64; 2],
        seed: impl Fn(Lanes, usize, f64) -> T,
    ) -> Coordinates<T, N> {
        coordinates(view, slopes, |of, k| Lanes::new(self.lanes[k].map(|i| of[i])), seed)
    }

    /// Adds its derivatives to the matrix; false if the model evaluates its elements one by one.
    pub(super) fn add_slopes<M: RingFormulation<D, N>, const D: usize>(
        &self,
        model: &M,
        view: View<'_>,
        slopes: [f64; 2],
        out: &mut Arrow,
    ) -> bool {
        for first in (0..N).step_by(PASS) {
            let seed = |value, direction: usize, slope| {
                Tangent::<PASS>::seed(value, direction.wrapping_sub(first), slope)
            };
            let Some(rows) = model.balance_of_many(&self.motion(view, slopes, seed)) else {
                return false;
            };
            for (i, row) in rows.iter().enumerate() {
                for (j, slopes) in (first..N).zip(row.eps) {
                    for (entries, slope) in self.entries.iter().zip(slopes.to_array()) {
                        out.add_at(entries[i][j], slope);
                    }
                }
            }
        }
        true
    }
}
