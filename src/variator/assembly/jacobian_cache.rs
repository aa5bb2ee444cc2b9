//! Cache of the cells' derivatives; the next Jacobian reuses those that are still valid.
//!
//! Each pack of cells stores the unknowns at which it was differentiated. Where the belt slips or a gap closes, a Jacobian is needed in
//! nearly every stage, but the geometry hardly changes from one to the next. Then only the constitutive tangents are updated, which is
//! accurate enough for a simplified Newton method.

use crate::archive::Archive;
use crate::scalar::{LANES, Lanes};
use crate::variator::assembly::law_part::{LawPart, LawWork, height};
use crate::variator::assembly::unknowns::{Part, Unknowns};
use crate::variator::belt::equations::ReusePolicy;
use crate::variator::cell::directions::Directions;
use crate::variator::cell::laws::LawTangents;

/// Factor by which 1/(hγ) may have changed.
const RESCALED: f64 = 1.5;
/// Equivalent angle of a displacement of the centres, rad/m, and of their turn, rad/rad.
const CENTRE: f64 = 10.0;
/// Angle by which the ring may have rotated, rad.
const TURNED: f64 = 3.0e-3;

/// Part of a pack's derivatives that was evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CacheUpdate {
    /// None: the cached derivatives are reused.
    None,
    /// The constitutive tangents; the geometry is reused.
    Tangents,
    /// All derivatives.
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
        Self {
            slopes: [f64::NAN; 2],
            unknowns: Unknowns::zero(),
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

/// Derivatives of a pack of cells, with the unknowns at which they were evaluated.
#[derive(Clone, Debug)]
pub(crate) struct JacobianCache {
    pub origin: Origin,
    /// Where the tangents of the laws were evaluated, if later.
    pub laws_origin: Origin,
    /// The tangents there.
    tangents: LawTangents,
    /// The derivatives at the origin, direction by direction for each row: rows of the balance without that of the
    /// amount, then the resultant of the contact forces.
    pub block: Vec<Lanes>,
    /// The laws' part, for a ring with analytic derivatives.
    pub laws: Option<LawPart>,
}

impl JacobianCache {
    /// Memory for the derivatives of a pack.
    pub(crate) fn new<K: Directions>(laws: Option<LawPart>) -> Self {
        Self {
            origin: Origin::none(),
            laws_origin: Origin::none(),
            tangents: LawTangents::zero(),
            block: vec![Lanes::from(0.0); height::<K>() * K::COUNT],
            laws,
        }
    }

    /// Drops the derivatives.
    pub(crate) fn forget(&mut self) {
        self.origin.forget();
        self.laws_origin.forget();
    }

    /// The derivatives with the last evaluated tangents of the laws.
    pub(crate) fn derivatives<'a, K: Directions>(&'a self, work: &'a mut LawWork) -> &'a [Lanes] {
        match &self.laws {
            Some(laws) if self.laws_origin.exists() => laws.with_tangents::<K>(&self.tangents, &self.block, work),
            _ => &self.block,
        }
    }

    /// Determines which derivatives to evaluate with these `tangents` of the laws, and records unknowns and tangents. `length`
    /// is that of the ring element.
    #[inline(always)]
    pub(crate) fn update<K: Directions>(
        &mut self,
        policy: ReusePolicy,
        tangents: &LawTangents,
        at: (&Unknowns<Lanes>, [f64; 2]),
        length: Lanes,
    ) -> CacheUpdate {
        let is_valid = match policy {
            ReusePolicy::WhereValid => self.has_similar_step(at.1) && self.turned::<K>(at.0, length) < TURNED,
            ReusePolicy::Geometry => self.has_similar_step(at.1),
            ReusePolicy::None => false,
        };
        if is_valid && *tangents == self.tangents {
            return CacheUpdate::None;
        }
        self.tangents = *tangents;
        // Without a laws' part all derivatives are evaluated or none.
        if is_valid && self.laws.is_some() {
            self.laws_origin.set(at);
            CacheUpdate::Tangents
        } else {
            self.origin.set(at);
            self.laws_origin.forget();
            CacheUpdate::All
        }
    }

    /// Whether there are derivatives with nearly these factors.
    fn has_similar_step(&self, slopes: [f64; 2]) -> bool {
        self.origin.exists() && (1.0 / RESCALED..RESCALED).contains(&(slopes[0] / self.origin.slopes[0]))
    }

    /// Largest rotation of the ring or change of Θ or of the centres, as an angle.
    #[inline(always)]
    fn turned<K: Directions>(&self, now: &Unknowns<Lanes>, length: Lanes) -> f64 {
        let components = K::NODES / 4;
        let moved = |k: usize| now.read(Part::Position, k) - self.origin.unknowns.read(Part::Position, k);
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

    /// Writes the unknowns of the derivatives, in this number of `directions`, to an archive, or reads them from it.
    pub(crate) fn serialize(&mut self, archive: &mut Archive<'_>, directions: usize, used: usize) {
        self.origin.serialize(archive, directions, used);
        if self.laws.is_some() {
            self.laws_origin.serialize(archive, directions, used);
        }
    }
}

impl Origin {
    /// Writes the unknowns, in this number of `directions`, to an archive, or reads them from it: cell by cell for the first
    /// `used` lanes, so that a build with another number of lanes can read them. Lanes beyond `used` repeat the last. The
    /// derivatives are then evaluated again.
    fn serialize(&mut self, archive: &mut Archive<'_>, directions: usize, used: usize) {
        let mut slopes = [self.slopes; LANES];
        for (lane, slopes) in slopes[..used].iter_mut().enumerate() {
            for slope in &mut *slopes {
                archive.any(slope);
            }
            // Where there are no derivatives, the unknowns are not in use.
            let exists = slopes.iter().all(|slope| slope.is_finite());
            for values in &mut self.unknowns.0 {
                for value in &mut values[..directions] {
                    let mut lanes = value.to_array();
                    if exists {
                        archive.real(&mut lanes[lane]);
                    } else {
                        archive.any(&mut lanes[lane]);
                    }
                    *value = Lanes::new(lanes);
                }
            }
        }
        for values in &mut self.unknowns.0 {
            for value in &mut values[..directions] {
                let lanes = value.to_array();
                *value = Lanes::new(std::array::from_fn(|lane| lanes[lane.min(used - 1)]));
            }
        }
        // Cells of one pack have the same factors. If they were in two packs of another build, the factors may differ;
        // then there are no derivatives.
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

    /// Bytes that packs of `widths` cells write for three directions, with numbers that identify the cells.
    fn written(widths: &[usize], slopes: impl Fn(usize) -> [f64; 2]) -> Vec<u8> {
        let mut archive = Archive::writer();
        let mut first = 0;
        for &used in widths {
            let mut origin = Origin::none();
            origin.slopes = slopes(first);
            for k in 0..3 {
                let of = |part: u32| {
                    let number = |lane: usize| f64::from(part) + k as f64 + 10.0 * (first + lane.min(used - 1)) as f64;
                    Lanes::new(std::array::from_fn(number))
                };
                for (values, part) in origin.unknowns.0.iter_mut().zip([1000, 2000, 3000]) {
                    values[k] = of(part);
                }
            }
            origin.serialize(&mut archive, 3, used);
            first += used;
        }
        archive.into_bytes()
    }

    fn read(bytes: &[u8], used: usize) -> Origin {
        let mut archive = Archive::reader(bytes);
        let mut origin = Origin::none();
        origin.serialize(&mut archive, 3, used);
        archive.finish().expect("as many as were written");
        origin
    }

    #[test]
    fn packs_of_another_width_are_read() {
        let wide = written(&[LANES], |_| [4.0, 0.25]);
        let narrow = written(&[1; LANES], |_| [4.0, 0.25]);
        assert_eq!(wide, narrow);
        let origin = read(&narrow, LANES);
        assert_eq!(origin.slopes, [4.0, 0.25]);
        for lane in 0..LANES {
            assert_eq!(
                origin.unknowns.read(Part::Value, 2).to_array()[lane],
                2002.0 + 10.0 * lane as f64
            );
        }
        let part = read(&written(&[1], |_| [4.0, 0.25]), 1);
        assert_eq!(
            part.unknowns.read(Part::Rate, 0).to_array(),
            [3000.0; LANES],
            "the last is repeated"
        );
    }

    #[test]
    fn packs_of_different_factors_have_no_derivatives() {
        let origin = read(&written(&[1; LANES], |first| [4.0 + first as f64, 0.25]), LANES);
        assert!(origin.slopes[0].is_nan());
        assert_eq!(
            origin.unknowns.read(Part::Position, 0).to_array()[LANES - 1],
            1000.0 + 10.0 * (LANES - 1) as f64
        );
        let none = read(&written(&[LANES], |_| [f64::NAN; 2]), LANES);
        assert!(none.slopes[0].is_nan());
    }
}
