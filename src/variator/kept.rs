//! Derivatives of cells, kept from one Jacobian to the next.
//!
//! Where the belt slips or a gap closes, a Jacobian is needed in nearly every stage, but only few cells change their
//! regime from one to the next: contact, friction, push, flow. The others' derivatives are still good for Newton's
//! method, which needs a direction and not a derivative. So each pack of cells remembers where it was differentiated,
//! and what it was in.

use super::cell::{CellLaw, STATIONS, pressing, ring_load};
use super::pack::{MOST, Unknowns};
use super::sample::Sample;
use crate::chain::CLOSING_SMOOTHING;
use crate::contact::PENETRATION_SMOOTHING;
use crate::scalar::{Lanes, Real};
use crate::tape::Tape;

/// Figures of a station, and of a cell beyond them.
const OF_STATION: usize = 10;
const OF_CELL: usize = 4;
const FIGURES: usize = STATIONS * OF_STATION + OF_CELL;

/// Change of a figure at which the derivatives are no longer good, relative to its size and that of the inertia.
const CHANGED: f64 = 0.03;
/// Factor by which 1/(hγ) may be off.
const RESCALED: f64 = 1.05;
/// Angle by which the ring may have turned, rad: EA times this is a fifth of its tension.
const TURNED: f64 = 1.0e-4;

/// What the derivatives of a pack of cells depend on besides what changes little: for each kind of force its slope, in
/// units of the inertia that resists it in the step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Regime {
    figures: [Lanes; FIGURES],
    taken: usize,
}

impl Regime {
    pub(super) fn new() -> Self {
        Self {
            figures: [Lanes::from(0.0); FIGURES],
            taken: 0,
        }
    }

    /// Takes the figures of what the `difference` of V across a cell does, m/s.
    #[inline(always)]
    pub(super) fn see_difference(&mut self, difference: Lanes) {
        let last = &mut self.figures[STATIONS * OF_STATION + 2..];
        let [_, closing, bend] = (-difference).smooth_plus(CLOSING_SMOOTHING);
        last[0] = closing;
        last[1] = bend * difference;
    }

    /// Whether derivatives taken in `earlier` are good here.
    #[inline(always)]
    fn is_like(&self, earlier: &Self) -> bool {
        self.figures.iter().zip(&earlier.figures).all(|(&now, &then)| {
            let off = now - then;
            let allowed = then * then + 1.0;
            // |off| < CHANGED·√(1 + then²), in every lane; not so for NaN.
            let (off, allowed) = ((off * off).to_array(), (allowed * (CHANGED * CHANGED)).to_array());
            off.iter().zip(&allowed).all(|(off, allowed)| off < allowed)
        })
    }
}

/// Sees the stations of a pack.
pub(super) struct Look<'a> {
    pub law: &'a CellLaw,
    /// 1/(hγ), 1/s.
    pub alpha: f64,
    /// ṡ, m/s.
    pub ring_speed: Lanes,
    pub regime: &'a mut Regime,
}

impl Look<'_> {
    /// Takes the figures of a station.
    pub(super) fn take(&mut self, s: &Sample<Lanes>) {
        let p = &self.law.parameters;
        let inertia = 1.0 / (p.belt.mass_per_length * self.alpha);
        let v0 = p.friction.velocity;
        let figures = &mut self.regime.figures[OF_STATION * self.regime.taken..];
        // Flanks; in space one is deeper in than the other.
        let flank = |depth: Lanes| depth.smooth_plus(PENETRATION_SMOOTHING);
        let ([deep, touching, _], [flat, other, _]) =
            (flank(s.penetration + s.offset), flank(s.penetration - s.offset));
        let square = s.sliding * s.sliding + s.flank_sliding * s.flank_sliding + v0 * v0;
        let speed = square.sqrt();
        let drag = (deep + flat) * (p.friction.pulley * p.contact.stiffness * inertia) / speed;
        let (u, w) = (s.sliding / speed, s.flank_sliding / speed);
        figures[0] = touching;
        figures[1] = touching * u;
        figures[2] = touching * w;
        figures[3] = drag * (-(u * u) + 1.0);
        figures[4] = drag * (-(w * w) + 1.0);
        figures[5] = drag * u * w;
        figures[6] = other;
        // Ring on elements.
        let speed = (s.ring_sliding * s.ring_sliding + v0 * v0).sqrt();
        let side = s.ring_sliding / speed;
        let load = ring_load(pressing(&p.ring, s.tension, self.ring_speed));
        figures[7] = load * s.curvature[0] * (p.friction.ring * inertia) * (-(side * side) + 1.0) / speed;
        // Convection: what passes in the time of the step.
        figures[8] = s.flow / (s.weight * self.alpha);
        // Where arcs move through the mesh.
        figures[9] = s.curvature[0];
        // Stack.
        let width = p.belt.contact_strain;
        let [strain, contact, bend] = (s.density - 1.0).smooth_plus(width);
        let viscous = (s.push * (1.0 / p.belt.push_stiffness) - strain) / contact;
        let last = &mut self.regime.figures[STATIONS * OF_STATION..];
        last[0] = contact;
        last[1] = bend * viscous;
        self.regime.taken += 1;
    }
}

/// Derivatives of a pack of cells, and where they were taken.
#[derive(Clone, Debug)]
pub(super) struct Kept {
    /// Factors of ẏ and q in the derivatives; NaN where there are none.
    pub slopes: [f64; 2],
    pub unknowns: Unknowns<Lanes>,
    pub regime: Regime,
    /// Rows of the balance, the amount's left out, a direction after the other.
    pub block: Vec<Lanes>,
}

impl Kept {
    /// Memory for a block of so many entries.
    pub(super) fn new(entries: usize) -> Self {
        let zero = [Lanes::from(0.0); MOST];
        Self {
            slopes: [f64::NAN; 2],
            unknowns: Unknowns {
                position: zero,
                value: zero,
                rate: zero,
            },
            regime: Regime::new(),
            block: vec![Lanes::from(0.0); entries],
        }
    }

    pub(super) fn forget(&mut self) {
        self.slopes = [f64::NAN; 2];
    }

    /// Whether they are good in `regime`, where the ring has an element of this `length` and deflects in so many
    /// components; `theta` is the direction of Θ.
    #[inline(always)]
    pub(super) fn holds(
        &self,
        regime: &Regime,
        unknowns: &Unknowns<Lanes>,
        length: Lanes,
        [components, theta]: [usize; 2],
        alpha: f64,
    ) -> bool {
        let ratio = alpha / self.slopes[0];
        (1.0 / RESCALED..RESCALED).contains(&ratio)
            && self.turned(unknowns, length, [components, theta]) < TURNED
            && regime.is_like(&self.regime)
    }

    /// Largest angle by which the ring has turned, or change of Θ.
    #[inline(always)]
    fn turned(&self, now: &Unknowns<Lanes>, length: Lanes, [components, theta]: [usize; 2]) -> f64 {
        let moved = |k: usize| now.position[k] - self.unknowns.position[k];
        let mut most = 0.0_f64;
        let mut see = |turn: Lanes| most = turn.to_array().into_iter().fold(most, |most, x| most.max(x.abs()));
        for k in 0..components {
            let (left, right) = (2 * k, 2 * (components + k));
            see(moved(left + 1));
            see(moved(right + 1));
            see((moved(right) - moved(left)) / length);
        }
        see(moved(theta));
        most
    }

    /// Passes by a tape where `directions` derivatives were taken; they can be taken there again. Lanes beyond `used`
    /// repeat the last.
    pub(super) fn pass(&mut self, tape: &mut Tape<'_>, directions: usize, used: usize) {
        for slope in &mut self.slopes {
            tape.real(slope);
        }
        let Unknowns { position, value, rate } = &mut self.unknowns;
        for values in [position, value, rate] {
            for value in &mut values[..directions] {
                let mut lanes = value.to_array();
                for lane in &mut lanes[..used] {
                    tape.real(lane);
                }
                *value = Lanes::new(std::array::from_fn(|lane| lanes[lane.min(used - 1)]));
            }
        }
    }
}
