//! Stress in the layers of the ring, from tension and curvature along the belt: a law without state.
//!
//! Two ring sets of n layers share the tension T. Each layer has the same speed all around the loop, so on one pulley all
//! layers slip on each other, each against the one below ([`layers`](super::layers)). They slip backwards, because the outer
//! ones have further to go, and friction pulls them forwards: with θ the angle of travel on that arc, the tension T_j outside
//! interface j follows
//!
//! dT_j/dθ = −μ_l (T_j − m_j ṡ²), m_j the mass of the layers outside it,
//!
//! and returns on the other pulley, where the layers stick, taken as linear in the angle. Strands change no T_j. All
//! equations are the same but for the share (n − j)/n of the layers outside. With equal ∮T_j dξ per layer (layers that fit one
//! another are stretched alike) their solution is one function of the place: a layer other than the innermost has T_o/n,
//!
//! T_o = m_r ṡ² + A g(θ), with g the decay and the return, and A from ∮T_o dξ = ∮T dξ.
//!
//! The innermost has the rest, T_o/n + T − T_o: it rubs on the elements. Without friction between layers T_o is constant,
//! and the innermost alone has the changes of T. With the same friction everywhere and a ring that slips on its elements as its
//! layers do, T = T_o and all layers share T equally.
//!
//! Near ratio 1 and at a standstill the layers stick on both pulleys. They then share the changes of T alike, as far as their
//! friction bears it on the shorter arc: T_o = T̄ + c (T − T̄) with c = min(1, μ_l (T̄ − m_r ṡ²) α/(T_max − T_min)), T̄ the mean. In
//! between, T_o passes from one to the other as the loss does.
//!
//! A layer of width w and thickness t has the stress T/(2 w t) ± ½ E t (κ − κ₀) at its outer and at its inner face, with the
//! tension T of both sets, E = EA/(2 n w t), κ the curvature of the ring's centre line and κ₀ that of a layer without stress.
//!
//! Simplifications: friction is rigid-plastic, so a reversal of the load acts at once; the curvature is that of the centre
//! line, although the innermost layer of nine bends 2 % more on the smallest radius; a layer is much wider than thick, so its
//! stiffness in bending lies between E and E/(1 − ν²), an upper bound with 10 % more stress of bending; contact stress on the
//! saddle and at the edges is left out.
//!
//! In a revolution a face has two cycles of stress, one on each pulley. Rainflow counting on the closed loop of two peaks and two
//! valleys combines the higher peak with the lower valley and the other two with each other. At an outer face the peaks are on
//! the arcs, at an inner one the valleys.

use super::layers::Slip;
use super::{Layers, Ring};

/// Ring sets, side by side on the elements.
const SETS: f64 = 2.0;

/// The two arcs, and the two strands.
const PAIR: usize = 2;

/// An element of the ring, in the order of ξ around the loop from the middle of the secondary arc.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RingPart {
    /// Middle, m.
    pub xi: f64,
    /// Length dξ, m.
    pub length: f64,
    /// Mean tension T, N.
    pub tension: f64,
    /// Mean curvature κ of the deflected ring, 1/m.
    pub curvature: f64,
    /// Angle by which the reference curve turns within it, rad: 0 on a strand.
    pub turning: f64,
    /// Pulley of an arc, or strand: 0 is the secondary, and the strand that follows its arc in ξ.
    pub number: usize,
}

impl RingPart {
    fn on_arc(&self) -> bool {
        self.turning > 0.0
    }
}

/// Motion of the ring.
#[derive(Clone, Copy, Debug)]
pub struct RingMotion {
    /// Speed ṡ of the ring along itself, m/s.
    pub speed: f64,
    /// Pitch radii, secondary first, m.
    pub radii: [f64; PAIR],
}

/// Tension T_o along the belt, and the layers' tension.
#[derive(Clone, Copy, Debug)]
pub struct LayerTension {
    slip: Slip,
    /// Wrap angles, secondary first, rad.
    wraps: [f64; PAIR],
    /// m_r ṡ² and the mean of T, N.
    centrifugal: f64,
    mean: f64,
    /// Mean of the shape g.
    mean_shape: f64,
    /// Share c of the changes of T that sticking layers have.
    sticking: f64,
    /// Number n of layers.
    count: f64,
}

/// Calls `of` for each part with its number, the pulley of the arc that it lies on or follows, and the angle turned on that
/// arc at its middle, rad.
fn for_each_angle(parts: &[RingPart], wraps: [f64; PAIR], mut of: impl FnMut(usize, usize, f64)) {
    let [secondary, primary] = wraps;
    // The loop begins in the middle of the secondary arc.
    let mut angle = 0.5 * secondary;
    for (k, part) in parts.iter().enumerate() {
        let middle = angle + 0.5 * part.turning;
        angle += part.turning;
        let (pulley, turned) = if middle <= secondary {
            (0, middle)
        } else if middle <= secondary + primary {
            (1, middle - secondary)
        } else {
            (0, middle - secondary - primary)
        };
        of(k, pulley, turned);
    }
}

/// Wrap angles of the parts' arcs, secondary first, rad.
fn wraps(parts: &[RingPart]) -> [f64; PAIR] {
    let mut wraps = [0.0; PAIR];
    for part in parts.iter().filter(|part| part.on_arc()) {
        wraps[part.number] += part.turning;
    }
    wraps
}

impl LayerTension {
    /// The layers' tension from that of the ring. Writes the shape g to `shapes`, one value for each part.
    pub fn new(ring: &Ring, layers: &Layers, motion: &RingMotion, parts: &[RingPart], shapes: &mut [f64]) -> Self {
        let (mut length, mut sum) = (0.0, 0.0);
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for part in parts {
            length += part.length;
            sum += part.tension * part.length;
            low = low.min(part.tension);
            high = high.max(part.tension);
        }
        let centrifugal = ring.mass_per_length * motion.speed * motion.speed;
        let (mean, wraps) = (sum / length, wraps(parts));
        let borne = layers.friction * (mean - centrifugal).max(0.0) * wraps[0].min(wraps[1]);
        let mut of = Self {
            slip: layers.slip(motion.radii, motion.speed),
            wraps,
            centrifugal,
            mean,
            mean_shape: 1.0,
            sticking: if borne < high - low { borne / (high - low) } else { 1.0 },
            count: f64::from(layers.count),
        };
        let mut shape = 0.0;
        for_each_angle(parts, wraps, |k, pulley, turned| {
            shapes[k] = of.shape(pulley, turned);
            shape += shapes[k] * parts[k].length;
        });
        of.mean_shape = shape / length;
        of
    }

    /// Shape g of T_o − m_r ṡ² for slipping layers after an angle `turned`, rad, on the arc of a pulley.
    fn shape(&self, pulley: usize, turned: f64) -> f64 {
        let Slip {
            pulley: slips, rate, ..
        } = self.slip;
        if pulley == slips {
            return (-rate * turned).exp();
        }
        let end = (-rate * self.wraps[slips]).exp();
        end + (1.0 - end) * turned / self.wraps[pulley]
    }

    /// Tension of the innermost layer and of each other one, of both sets together, N, where the ring's tension is `tension`, N,
    /// and the shape g is `shape`.
    #[must_use]
    pub fn at(&self, tension: f64, shape: f64) -> [f64; 2] {
        let slipping = self.centrifugal + (self.mean - self.centrifugal) * shape / self.mean_shape;
        let sticking = self.mean + self.sticking * (tension - self.mean);
        let outer = sticking + self.slip.share * (slipping - sticking);
        let share = outer / self.count;
        [share + tension - outer, share]
    }
}

/// Face of a layer: its side, +1 outer and −1 inner, of the innermost layer (0) or of another one (1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
    /// 0: the innermost layer, 1: any other.
    pub layer: usize,
    /// +1: outer face, −1: inner face.
    pub side: f64,
}

const FACES: [Face; 4] = [
    Face { layer: 0, side: 1.0 },
    Face { layer: 0, side: -1.0 },
    Face { layer: 1, side: 1.0 },
    Face { layer: 1, side: -1.0 },
];

/// Stress of the face with the largest one over a revolution, Pa.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RingStress {
    /// Largest stress.
    pub max: f64,
    /// Amplitude of the cycle on each pulley, secondary first.
    pub amplitude: [f64; PAIR],
    /// Mean stress of the same cycles.
    pub mean: [f64; PAIR],
}

/// Extremes of the stress of a face, times its side: the largest on each arc, the smallest on each strand.
#[derive(Clone, Copy, Debug)]
struct Extremes {
    face: Face,
    max: f64,
    arcs: [f64; PAIR],
    strands: [f64; PAIR],
}

impl Extremes {
    fn none(face: Face) -> Self {
        Self {
            face,
            max: f64::NEG_INFINITY,
            arcs: [f64::NEG_INFINITY; PAIR],
            strands: [f64::INFINITY; PAIR],
        }
    }

    fn add(&mut self, part: &RingPart, stress: f64) {
        self.max = self.max.max(stress);
        let sided = stress * self.face.side;
        if part.on_arc() {
            let arc = &mut self.arcs[part.number];
            *arc = arc.max(sided);
        } else {
            let strand = &mut self.strands[part.number];
            *strand = strand.min(sided);
        }
    }

    /// The cycles by rainflow counting: the larger extreme of the arcs with the smaller one of the strands.
    fn cycles(&self) -> RingStress {
        let (low, high) = (
            self.strands[0].min(self.strands[1]),
            self.strands[0].max(self.strands[1]),
        );
        let larger = usize::from(self.arcs[1] > self.arcs[0]);
        let base: [f64; PAIR] = std::array::from_fn(|arc| if arc == larger { low } else { high });
        RingStress {
            max: self.max,
            amplitude: std::array::from_fn(|arc| (0.5 * (self.arcs[arc] - base[arc])).max(0.0)),
            mean: std::array::from_fn(|arc| 0.5 * self.face.side * (self.arcs[arc] + base[arc])),
        }
    }
}

/// Stress of the layers' faces.
#[derive(Clone, Copy, Debug)]
pub struct FaceStress {
    /// 1/(2 w t), 1/m².
    per_area: f64,
    /// ½ E t, N/m.
    bending: f64,
    /// κ₀, 1/m.
    residual: f64,
}

impl FaceStress {
    /// For layers of a ring; `None` if they have no thickness.
    #[must_use]
    pub fn new(ring: &Ring, layers: &Layers) -> Option<Self> {
        let area = SETS * layers.width * layers.thickness;
        (area > 0.0).then(|| Self {
            per_area: area.recip(),
            bending: 0.5 * layers.thickness * ring.axial_stiffness / (area * f64::from(layers.count)),
            residual: layers.residual_curvature,
        })
    }

    /// Stress of a layer's face on the given side under its tension, N, at the curvature, 1/m; Pa.
    #[must_use]
    pub fn at(&self, side: f64, tension: f64, curvature: f64) -> f64 {
        tension * self.per_area + side * self.bending * (curvature - self.residual)
    }
}

/// Stress of the face with the largest one over a revolution; writes its stress in each part to `along`, Pa. All are zero
/// for layers without thickness.
pub fn ring_stress(
    ring: &Ring,
    layers: &Layers,
    motion: &RingMotion,
    parts: &[RingPart],
    along: &mut [f64],
) -> RingStress {
    along.fill(0.0);
    let Some(stress) = FaceStress::new(ring, layers) else {
        return RingStress::default();
    };
    let tension = LayerTension::new(ring, layers, motion, parts, along);
    // A ring of one layer has the innermost only.
    let faces = if layers.count > 1 { FACES.len() } else { PAIR };
    let mut extremes = FACES.map(Extremes::none);
    for (part, shape) in parts.iter().zip(&*along) {
        let tensions = tension.at(part.tension, *shape);
        for of in extremes.iter_mut().take(faces) {
            let Face { layer, side } = of.face;
            of.add(part, stress.at(side, tensions[layer], part.curvature));
        }
    }
    let worst = extremes[..faces]
        .iter()
        .fold(&extremes[0], |worst, of| if of.max > worst.max { of } else { worst });
    let Face { layer, side } = worst.face;
    for (part, along) in parts.iter().zip(along) {
        let tensions = tension.at(part.tension, *along);
        *along = stress.at(side, tensions[layer], part.curvature);
    }
    worst.cycles()
}

#[cfg(test)]
mod tests;
