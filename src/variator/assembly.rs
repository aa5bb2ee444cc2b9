//! Packs of cells gathered into the residual, and sampled.

use super::cell::{CellBalance, balance};
use super::layout::Global;
use super::pack::{InPlace, Pack, Standing, Tell, for_kind, motion, nodes, own_directions, rows, tensions};
use super::ring::{Deflecting, GUIDED, Guided, RingForces, TURNING, Turning};
use super::sample::{NoProbe, Probe, Sample, Sampler};
use super::system::VariatorSystem;
use super::travelling::with_ring;
use crate::chain;
use crate::reference_curve::{ReferenceCurve, ReferencePoint, TwoPulley, TwoPulleyFrame};
use crate::scalar::{LANES, Lanes, Real};
use crate::solver::View;
use num_traits::Zero;

/// Sums over the cells of a pulley.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PulleySum<T = f64> {
    pub axial: T,
    pub tilting: [T; 2],
    pub torque: T,
}

impl<T: Real> PulleySum<T> {
    /// Adds `on` times what a cell does.
    #[inline(always)]
    pub fn add(&mut self, cell: &CellBalance<T>, on: T) {
        self.axial += cell.axial * on;
        self.torque += cell.torque * on;
        for (sum, moment) in self.tilting.iter_mut().zip(cell.tilting) {
            *sum += moment * on;
        }
    }
}

impl PulleySum<Lanes> {
    /// Over the lanes.
    fn sum(&self) -> PulleySum {
        PulleySum {
            axial: self.axial.sum(),
            tilting: self.tilting.map(Lanes::sum),
            torque: self.torque.sum(),
        }
    }
}

impl VariatorSystem {
    /// Length of an element, m.
    pub(super) fn element_length(&self, frame: &TwoPulleyFrame<f64>, element: usize) -> f64 {
        let element = &self.mesh.elements[element];
        let segment = if self.mesh.aligned {
            TwoPulley::segment_length(frame, element.segment).v
        } else {
            self.curve.length()
        };
        segment * element.share
    }

    /// The reference curve at a fraction of the segment of an element.
    pub(super) fn reference_point(
        &self,
        frame: &TwoPulleyFrame<f64>,
        element: usize,
        fraction: f64,
    ) -> ReferencePoint<f64> {
        if self.mesh.aligned {
            TwoPulley::point(frame, self.mesh.elements[element].segment, fraction)
        } else {
            self.curve.at(frame, fraction * self.curve.length())
        }
    }

    /// Samples of the stations of each group of cells.
    pub(super) fn sample(&self, view: View<'_>, out: &mut Vec<Sample<Lanes>>) {
        out.resize(self.mesh.groups.len() * self.mesh.points, Sample::default());
        if let Some(travelling) = &self.travelling {
            with_ring!(&**travelling, ring => self.sample_travelling(ring, view, out));
        } else {
            for_kind!(self, sample_packs(view, out));
        }
    }

    fn sample_packs<const KIND: u8, const D: usize, C: Standing>(&self, view: View<'_>, out: &mut [Sample<Lanes>]) {
        let frame = C::stand(&self.curve, self.curve.shape(self.theta(view)).frame(Lanes::zero()));
        let mut places = out.iter_mut();
        for pack in &self.packs {
            self.sampled_balance::<KIND, D, C>(pack, &frame, &InPlace { pack, view }, &mut |sample| {
                *places.next().expect("a place for each station") = sample;
            });
        }
    }

    /// The balance of a pack of cells while `take` sees every station.
    #[inline(never)]
    pub(super) fn sampled_balance<const KIND: u8, const D: usize, C: Standing>(
        &self,
        pack: &Pack,
        frame: &C::Frame<Lanes>,
        unknowns: &impl Tell<Lanes>,
        take: &mut dyn FnMut(Sample<Lanes>),
    ) -> CellBalance<Lanes> {
        let seed = |value, _, _| value;
        self.pack_balance::<_, _, KIND, D, C>(pack, frame, unknowns, [0.0; 2], seed, &mut Sampler(take))
            .0
    }

    /// The balance of a pack of cells; `seed` makes a scalar of a value, its direction and its slope.
    #[inline(always)]
    pub(super) fn pack_balance<T: Real<Constant = Lanes>, S: Probe<T>, const KIND: u8, const D: usize, C: Standing>(
        &self,
        pack: &Pack,
        frame: &C::Frame<T>,
        unknowns: &impl Tell<Lanes>,
        slopes: [f64; 2],
        seed: impl Fn(Lanes, usize, f64) -> T,
        probe: &mut S,
    ) -> (CellBalance<T>, RingForces<T, D>) {
        let motion = motion::<T, KIND, D>(unknowns, slopes, &seed);
        let place = pack.place::<T, C>(frame);
        let reference = |slot: usize| C::point(frame, pack.segment, place.fraction(slot));
        let (law, ring) = (&self.law, &self.law.parameters.ring);
        if KIND == GUIDED {
            let tensions = tensions(unknowns, &seed);
            let mut ring = Guided::new(ring, &place, &motion.reference, tensions);
            let b = balance(law, &place, &motion, &mut ring, reference, probe);
            return (b, ring.forces());
        }
        let nodes = nodes(unknowns, slopes, &seed);
        if KIND == TURNING {
            let curve = |fraction| C::tangent_angle(frame, pack.segment, fraction);
            let [start, share] = pack.of_segment;
            let ends = [start, start + share];
            let mut ring = Turning::new(ring, &place, &motion.reference, nodes, ends, curve);
            let b = balance(law, &place, &motion, &mut ring, reference, probe);
            (b, ring.forces())
        } else {
            let mut ring = Deflecting::new(ring, &place, &motion.reference, &nodes);
            let b = balance(law, &place, &motion, &mut ring, reference, probe);
            (b, ring.forces())
        }
    }

    pub(super) fn assemble_residual<const KIND: u8, const D: usize, C: Standing>(
        &mut self,
        view: View<'_>,
        out: &mut [f64],
    ) {
        let own = own_directions(KIND, D);
        let frame = C::stand(&self.curve, self.curve.shape(self.theta(view)).frame(Lanes::zero()));
        let [mut drift, mut theta] = [Lanes::zero(); 2];
        let mut sums = [PulleySum::<Lanes>::default(); 2];
        for pack in &self.packs {
            let (b, ring) = self.pack_balance::<_, _, KIND, D, C>(
                pack,
                &frame,
                &InPlace { pack, view },
                [0.0; 2],
                |value, _, _| value,
                &mut NoProbe,
            );
            let rows = rows::<_, KIND, D>(&b, &ring);
            pack.scatter::<KIND, D>(&rows, out);
            let in_use = pack.group.in_use();
            drift += rows[own] * in_use;
            theta += rows[own + 1] * in_use;
            // The pulley's rows need its whole sum first.
            for (sum, on) in sums.iter_mut().zip(pack.group.on) {
                sum.add(&b, on);
            }
            self.transports.set_pack(pack.group.cells[0], &b.transport);
        }
        self.sums = sums.map(|of| of.sum());
        out[self.layout.global(Global::Drift, 0)] += drift.sum();
        out[self.layout.global(Global::Theta, 0)] += theta.sum();
        self.add_fluxes(view, out);
    }

    /// Adds the balance of the amounts: fluxes through the left faces.
    pub(super) fn add_fluxes(&mut self, view: View<'_>, out: &mut [f64]) {
        self.transports.close();
        let cells = self.mesh.cells.len();
        let mut from = self.cells_at[cells - 1][1];
        for (pack, at) in self.cells_at.chunks(LANES).enumerate() {
            let [before, after] = self.transports.beside(LANES * pack);
            for (&[_, into], flux) in at.iter().zip(chain::flux(&before, &after).to_array()) {
                out[into] += view.y_dot[into] - flux;
                out[from] += flux;
                from = into;
            }
        }
    }
}
