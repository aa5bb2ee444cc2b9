//! Derivatives of cells, kept from one Jacobian to the next.
//!
//! Where the belt slips or a gap closes, a Jacobian is needed in nearly every stage, but only few cells change their
//! regime from one to the next: contact, friction, push, flow. The others' derivatives are still good for Newton's
//! method, which needs a direction and not a derivative. So each pack of cells keeps the unknowns and the regime at which
//! it was differentiated.

use crate::chain::{closing_slopes, stack_slopes};
use crate::contact::{FrictionSlopes, friction_slopes, touch};
use crate::scalar::{LANES, Lanes};
use crate::tape::Tape;
use crate::variator::assembly::law_part::LawPart;
use crate::variator::assembly::unknowns::Unknowns;
use crate::variator::cell::directions::{Directions, MOST};
use crate::variator::cell::probe::{AtStation, Probe};
use crate::variator::law::ring_friction::ring_friction_slope;
use crate::variator::mesh::belt_mesh::STATIONS;
use crate::variator::rings::ring::CellRing;

/// Change of a figure at which the derivatives are no longer good, relative to its size and that of the inertia.
const CHANGED: f64 = 0.03;
/// Factor by which 1/(hγ) may be off.
const RESCALED: f64 = 1.5;
/// Angle per metre, and per radian of turn, that stands for the way of displaced centres.
const CENTRE: f64 = 10.0;
/// Angle by which the ring may have turned, rad.
const TURNED: f64 = 3.0e-3;

/// Slopes of the forces at a station, in units of the inertia that resists them in the step.
#[derive(Clone, Copy, Debug, Default)]
struct StationRegime {
    /// Contact of the deeper flank, from 0 (apart) to 1.
    touching: Lanes,
    /// Contact of the other flank, from 0 to 1.
    other_touching: Lanes,
    /// Direction of sliding where the flank touches.
    direction: [Lanes; 2],
    /// Slopes of friction: around, along the flank, and across.
    friction: [Lanes; 3],
    /// Slope of the friction between ring and elements.
    ring_friction: Lanes,
    /// Cell lengths that pass in the time of the step.
    convection: Lanes,
    /// Reference curvature: where arcs move through the mesh it jumps.
    curvature: Lanes,
}

/// Figures of the laws at a station.
const OF_STATION: usize = 8;

impl StationRegime {
    #[inline(always)]
    fn figures(&self) -> [Lanes; OF_STATION] {
        let [around, up] = self.direction;
        let [by_around, by_up, across] = self.friction;
        [
            self.touching,
            around,
            up,
            by_around,
            by_up,
            across,
            self.other_touching,
            self.ring_friction,
        ]
    }
}

/// Slopes of the forces in the stack of a cell.
#[derive(Clone, Copy, Debug, Default)]
struct StackRegime {
    /// Contact of neighbouring elements, from 0 (apart) to 1.
    contact: Lanes,
    /// Slope of the damping force by the density, in units of the stiffness.
    bend: Lanes,
    /// Damping force per rate of strain, in units of the inertia that resists it in the step.
    damping: Lanes,
    /// Share of closing, from 0 (elements part) to 1.
    closing: Lanes,
    /// Slope of the share of closing, times the difference of V.
    closing_bend: Lanes,
}

impl StackRegime {
    #[inline(always)]
    fn figures(&self) -> [Lanes; 5] {
        [self.contact, self.bend, self.damping, self.closing, self.closing_bend]
    }
}

/// Regime of a pack of cells: the slopes of its forces that change much.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Regime {
    stations: [StationRegime; STATIONS],
    stack: StackRegime,
}

/// Whether each of these figures has hardly changed, in every lane.
#[inline(always)]
fn alike<const N: usize>(now: [Lanes; N], then: [Lanes; N]) -> bool {
    now.iter().zip(&then).all(|(&now, &then)| {
        let off = now - then;
        let allowed = then * then + 1.0;
        // |off| < CHANGED·√(1 + then²), in every lane; not so for NaN.
        let (off, allowed) = ((off * off).to_array(), (allowed * (CHANGED * CHANGED)).to_array());
        off.iter().zip(&allowed).all(|(off, allowed)| off < allowed)
    })
}

impl Regime {
    /// Whether the slopes of the laws in the regime `earlier` are good in this one.
    #[inline(always)]
    fn has_laws_of(&self, earlier: &Self) -> bool {
        let stations = self.stations.iter().zip(&earlier.stations);
        stations
            .into_iter()
            .all(|(now, then)| alike(now.figures(), then.figures()))
            && alike(self.stack.figures(), earlier.stack.figures())
    }

    /// Whether the belt flows and bends as in the regime `earlier`, when 1/(hγ) was a `ratio` smaller.
    #[inline(always)]
    fn flows_as(&self, earlier: &Self, ratio: f64) -> bool {
        let stations = self.stations.iter().zip(&earlier.stations);
        stations.into_iter().all(|(now, then)| {
            alike(
                [now.convection * ratio, now.curvature],
                [then.convection, then.curvature],
            )
        })
    }

    /// Takes the slopes of the laws of another regime.
    #[inline(always)]
    fn take_laws(&mut self, other: &Self) {
        for (to, from) in self.stations.iter_mut().zip(&other.stations) {
            *to = StationRegime {
                convection: to.convection,
                curvature: to.curvature,
                ..*from
            };
        }
        self.stack = other.stack;
    }
}

/// Records the regime of a pack.
pub(crate) struct RegimeProbe<'a> {
    /// Factor 1/(hγ) of ẏ in the derivatives, 1/s.
    pub alpha: f64,
    pub regime: &'a mut Regime,
}

impl<const D: usize> Probe<Lanes, D> for RegimeProbe<'_> {
    #[inline(always)]
    fn look<R: CellRing<Lanes, D>>(&mut self, at: &AtStation<'_, Lanes, D, R>) {
        let AtStation {
            given, station, forces, ..
        } = at;
        let (law, friction) = (given.law, given.friction);
        let inertia = 1.0 / (law.chain.mass_per_length * self.alpha);
        let regime = &mut self.regime.stations[at.index];
        let (flank, offset) = (&forces.approach.flank, forces.flanks.offset);
        let movable @ [deep, touching] = touch(&law.contact, flank.penetration + offset);
        // In space one flank is deeper in than the other.
        let [flat, other_touching] = if D == 3 {
            touch(&law.contact, flank.penetration - offset)
        } else {
            movable
        };
        let sliding = [flank.tangential, flank.along_flank];
        let FrictionSlopes { direction, slopes } =
            friction_slopes(&law.contact, friction, deep + flat, sliding, inertia);
        regime.touching = touching;
        regime.other_touching = other_touching;
        regime.direction = direction.map(|along| touching * along);
        regime.friction = slopes;
        let kappa = station.ring.reference.kappa;
        regime.ring_friction = ring_friction_slope(friction, forces.pressing, kappa, forces.sliding, inertia);
        regime.convection = station.chain.flow / (station.weight * self.alpha);
        regime.curvature = kappa;
        let stack = &mut self.regime.stack;
        let [density, density_rate, ..] = at.cell.stack_arguments();
        let [contact, bend, damping] = stack_slopes(&law.chain, density, density_rate);
        (stack.contact, stack.bend) = (contact, bend);
        stack.damping = damping * inertia / (station.weight * station.weight);
        [stack.closing, stack.closing_bend] = closing_slopes(at.cell.difference);
    }
}

/// What of a pack's derivatives is evaluated anew.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Renewal {
    Nothing,
    /// Slopes of the laws; the geometry around them stays.
    Laws,
    All,
}

/// What is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Wanted {
    /// What is not good any more.
    Needed,
    /// Slopes of the laws, or all where there are no derivatives of a like step.
    Laws,
    All,
}

/// Where derivatives were evaluated: unknowns, and factors of ẏ and q; NaN where there are none.
#[derive(Clone, Debug)]
pub(crate) struct Origin {
    pub slopes: [f64; 2],
    pub unknowns: Unknowns<Lanes>,
}

impl Origin {
    fn none() -> Self {
        let zero = [Lanes::from(0.0); MOST];
        Self {
            slopes: [f64::NAN; 2],
            unknowns: Unknowns {
                position: zero,
                value: zero,
                rate: zero,
            },
        }
    }

    pub(crate) fn exists(&self) -> bool {
        !self.slopes[0].is_nan()
    }

    fn forget(&mut self) {
        self.slopes = [f64::NAN; 2];
    }

    fn set(&mut self, (unknowns, slopes): (&Unknowns<Lanes>, [f64; 2])) {
        self.unknowns.clone_from(unknowns);
        self.slopes = slopes;
    }
}

/// Derivatives of a pack of cells, and the unknowns and regime at which they were evaluated.
#[derive(Clone, Debug)]
pub(crate) struct Kept {
    pub origin: Origin,
    /// Where the slopes of the laws were evaluated, if that was later.
    pub laws_origin: Origin,
    pub regime: Regime,
    /// Rows of the balance, the amount's left out, then the resultant of the contact forces; each a direction after the other.
    pub block: Vec<Lanes>,
    /// The laws' part, of a ring that has derivatives by hand.
    pub laws: Option<LawPart>,
}

impl Kept {
    /// Memory for a block of so many entries.
    pub(crate) fn new(entries: usize, laws: Option<LawPart>) -> Self {
        Self {
            origin: Origin::none(),
            laws_origin: Origin::none(),
            regime: Regime::default(),
            block: vec![Lanes::from(0.0); entries],
            laws,
        }
    }

    /// Drops the derivatives.
    pub(crate) fn forget(&mut self) {
        self.origin.forget();
        self.laws_origin.forget();
    }

    /// Says what of the derivatives is to be evaluated anew where the pack is in this `regime`, and takes unknowns and regime as those
    /// where it is. The element of the ring has this `length`.
    #[inline(always)]
    pub(crate) fn renew<K: Directions>(
        &mut self,
        wanted: Wanted,
        regime: Regime,
        at: (&Unknowns<Lanes>, [f64; 2]),
        length: Lanes,
    ) -> Renewal {
        let renewal = match wanted {
            Wanted::Needed => self.needs::<K>(&regime, at, length),
            Wanted::Laws if self.is_of_like_step(at.1) => Renewal::Laws,
            Wanted::Laws | Wanted::All => Renewal::All,
        };
        // Without its laws' part a pack has all or nothing.
        let renewal = if self.laws.is_none() && renewal == Renewal::Laws {
            Renewal::All
        } else {
            renewal
        };
        match renewal {
            Renewal::Nothing => {}
            Renewal::Laws => {
                self.laws_origin.set(at);
                self.regime.take_laws(&regime);
            }
            Renewal::All => {
                self.origin.set(at);
                self.laws_origin.forget();
                self.regime = regime;
            }
        }
        renewal
    }

    /// Whether there are derivatives, with nearly these factors.
    fn is_of_like_step(&self, slopes: [f64; 2]) -> bool {
        (1.0 / RESCALED..RESCALED).contains(&(slopes[0] / self.origin.slopes[0]))
    }

    /// What of the derivatives is not good any more.
    #[inline(always)]
    fn needs<K: Directions>(
        &self,
        regime: &Regime,
        (unknowns, slopes): (&Unknowns<Lanes>, [f64; 2]),
        length: Lanes,
    ) -> Renewal {
        let ratio = slopes[0] / self.origin.slopes[0];
        let holds = self.is_of_like_step(slopes)
            && self.turned::<K>(unknowns, length) < TURNED
            && regime.flows_as(&self.regime, ratio);
        if !holds {
            Renewal::All
        } else if regime.has_laws_of(&self.regime) {
            Renewal::Nothing
        } else {
            Renewal::Laws
        }
    }

    /// Largest angle by which the ring has turned, or change of Θ or of the centres.
    #[inline(always)]
    fn turned<K: Directions>(&self, now: &Unknowns<Lanes>, length: Lanes) -> f64 {
        let components = K::NODES / 4;
        let moved = |k: usize| now.position[k] - self.origin.unknowns.position[k];
        let mut most = 0.0_f64;
        let mut include = |turn: Lanes| most = turn.to_array().into_iter().fold(most, |most, x| most.max(x.abs()));
        for k in 0..components {
            let (left, right) = (2 * k, 2 * (components + k));
            include(moved(left + 1));
            include(moved(right + 1));
            include((moved(right) - moved(left)) / length);
        }
        include(moved(K::THETA));
        for centre in 1..K::COORDINATES {
            include(moved(K::THETA + centre) * CENTRE);
        }
        most
    }

    /// Writes to a tape, or reads from it, where the derivatives were evaluated, in so many `directions`.
    pub(crate) fn pass(&mut self, tape: &mut Tape<'_>, directions: usize, used: usize) {
        self.origin.pass(tape, directions, used);
        if self.laws.is_some() {
            self.laws_origin.pass(tape, directions, used);
        }
    }
}

impl Origin {
    /// Writes to a tape, or reads from it, the unknowns, in so many `directions`: cell
    /// by cell, for the first `used` lanes, so that another number of lanes reads them too. The derivatives can be evaluated
    /// there again. Lanes beyond `used` repeat the last.
    fn pass(&mut self, tape: &mut Tape<'_>, directions: usize, used: usize) {
        let mut slopes = [self.slopes; LANES];
        let Unknowns { position, value, rate } = &mut self.unknowns;
        for (lane, slopes) in slopes[..used].iter_mut().enumerate() {
            for slope in slopes {
                tape.real(slope);
            }
            for values in [&mut *position, &mut *value, &mut *rate] {
                for value in &mut values[..directions] {
                    let mut lanes = value.to_array();
                    tape.real(&mut lanes[lane]);
                    *value = Lanes::new(lanes);
                }
            }
        }
        for values in [position, value, rate] {
            for value in &mut values[..directions] {
                let lanes = value.to_array();
                *value = Lanes::new(std::array::from_fn(|lane| lanes[lane.min(used - 1)]));
            }
        }
        // Cells of one pack share the factors. Those of two packs of another build may not: then there are no derivatives.
        let bits = |slopes: [f64; 2]| slopes.map(f64::to_bits);
        if slopes[..used].iter().all(|of| bits(*of) == bits(slopes[0])) {
            self.slopes = slopes[0];
        } else {
            self.forget();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What packs of `widths` cells write for three directions, with numbers that tell the cells apart.
    fn written(widths: &[usize], slopes: impl Fn(usize) -> [f64; 2]) -> Vec<u8> {
        let mut tape = Tape::writer();
        let mut first = 0;
        for &used in widths {
            let mut kept = Origin::none();
            kept.slopes = slopes(first);
            for k in 0..3 {
                let of = |part: u32| {
                    let number = |lane: usize| f64::from(part) + k as f64 + 10.0 * (first + lane.min(used - 1)) as f64;
                    Lanes::new(std::array::from_fn(number))
                };
                kept.unknowns.position[k] = of(1000);
                kept.unknowns.value[k] = of(2000);
                kept.unknowns.rate[k] = of(3000);
            }
            kept.pass(&mut tape, 3, used);
            first += used;
        }
        tape.into_bytes()
    }

    fn read(bytes: &[u8], used: usize) -> Origin {
        let mut tape = Tape::reader(bytes);
        let mut kept = Origin::none();
        kept.pass(&mut tape, 3, used);
        tape.finish().expect("as many as were written");
        kept
    }

    #[test]
    fn packs_of_another_width_are_read() {
        let wide = written(&[LANES], |_| [4.0, 0.25]);
        let narrow = written(&[1; LANES], |_| [4.0, 0.25]);
        assert_eq!(wide, narrow);
        let kept = read(&narrow, LANES);
        assert_eq!(kept.slopes, [4.0, 0.25]);
        for lane in 0..LANES {
            assert_eq!(kept.unknowns.value[2].to_array()[lane], 2002.0 + 10.0 * lane as f64);
        }
        let part = read(&written(&[1], |_| [4.0, 0.25]), 1);
        assert_eq!(
            part.unknowns.rate[0].to_array(),
            [3000.0; LANES],
            "the last is repeated"
        );
    }

    #[test]
    fn packs_of_different_factors_keep_no_derivatives() {
        let kept = read(&written(&[1; LANES], |first| [4.0 + first as f64, 0.25]), LANES);
        assert!(kept.slopes[0].is_nan());
        assert_eq!(
            kept.unknowns.position[0].to_array()[LANES - 1],
            1000.0 + 10.0 * (LANES - 1) as f64
        );
        let none = read(&written(&[LANES], |_| [f64::NAN; 2]), LANES);
        assert!(none.slopes[0].is_nan());
    }
}
