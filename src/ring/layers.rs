//! Friction between the layers of the ring. A pure law, no state.
//!
//! A ring set is a stack of n thin bands. Each keeps one speed all around the loop, but on an arc of radius R neighbours a
//! thickness t apart would need speeds that differ by v t/R. So on the pulley that holds the layers more firmly they move
//! together, and on the other neighbours slip by v t |1/R_P − 1/R_S|. There the interface below layer j + 1 carries the
//! tension of the n − j layers outside it, in sum (n − 1)/2 of the whole tension. With T − m_r ṡ² the part that presses, per
//! length of that arc this is a drag along the ring, against its own motion v,
//!
//! f = μ_l t |1/R_P − 1/R_S| (n − 1)/2 · ⟨T − m_r ṡ²⟩₊ κ · v/√(v² + v₀²),
//!
//! whose power, integrated over the arc, is μ_l v t |1/R_P − 1/R_S| (n − 1)/2 (T − m_r ṡ²) α. Several sets beside each other
//! share the tension, so they lose what one would.
//!
//! The power is right, where it is taken from is a simplification. In a real ring the layers hand on tension to each other,
//! which turns into a couple on each pulley. A beam has no layers, so here it is a drag on the ring alone: some newtons beside a
//! tension of kilonewtons. The moments of the strands about a pulley miss 0.3 N·m in overdrive at 20 kN.
//!
//! The weaker pulley is the one with the smaller wrap, so the one with the smaller radius. Its share passes from 0 to 1 where
//! the difference of curvatures passes `EVEN`. There the loss is small, and at ratio 1 it is zero with a zero slope.

use crate::scalar::Real;

/// Difference of the curvatures of the two arcs below which they count as equal, 1/m: a ratio of 1.03.
const EVEN: f64 = 0.5;

/// Speed v₀ below which the drag fades, m/s.
const FADING_SPEED: f64 = 0.1;

/// Parameters of the friction between the layers of the ring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layers {
    /// Number n of layers.
    pub count: i32,
    /// Thickness t of a layer, m.
    pub thickness: f64,
    /// Friction coefficient μ_l between layers.
    pub friction: f64,
}

impl Layers {
    /// Drag on the secondary and on the primary arc as a share of the load that presses the ring on them. `radii` are the
    /// pitch radii in that order, m.
    #[inline(always)]
    pub fn drag_shares<T: Real>(&self, [secondary, primary]: [T; 2]) -> [T; 2] {
        let sharper = secondary.recip() - primary.recip();
        let (_, inverse) = (sharper * sharper + EVEN * EVEN).root_and_inverse();
        // |x| as x²/√(x² + δ²): off by ½(δ/x)², zero with a zero slope at zero.
        let difference = sharper * sharper * inverse;
        let half = difference * (0.25 * self.friction * self.thickness * f64::from(self.count - 1));
        let lean = sharper * inverse;
        [half * (lean + 1.0), half * (-lean + 1.0)]
    }
}

/// Direction of the ring's motion along itself at `speed`, m/s: from −1 to 1, smooth at a standstill.
#[inline(always)]
pub(crate) fn direction<T: Real>(speed: T) -> T {
    let (_, inverse) = (speed * speed + FADING_SPEED * FADING_SPEED).root_and_inverse();
    speed * inverse
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAYERS: Layers = Layers {
        count: 9,
        thickness: 1.85e-4,
        friction: 0.05,
    };

    #[test]
    fn drag_is_on_the_smaller_pulley() {
        let [secondary, primary] = LAYERS.drag_shares([0.036, 0.072]);
        let expected = 0.05 * 1.85e-4 * 4.0 * (1.0 / 0.036 - 1.0 / 0.072);
        assert!((secondary / expected - 1.0).abs() < 0.005, "{secondary} {expected}");
        assert!(primary >= 0.0 && primary < 0.002 * secondary, "{primary}");
        assert_eq!(LAYERS.drag_shares([0.072, 0.036]), [primary, secondary]);
    }

    #[test]
    fn there_is_none_at_ratio_1_and_none_without_neighbours() {
        assert_eq!(LAYERS.drag_shares([0.058, 0.058]), [0.0; 2]);
        let near = LAYERS.drag_shares([0.058, 0.058 * 1.0001]);
        assert!(near[0] < 1e-4 * LAYERS.drag_shares([0.036, 0.072])[0], "{near:?}");
        for none in [
            Layers { count: 1, ..LAYERS },
            Layers {
                friction: 0.0,
                ..LAYERS
            },
        ] {
            assert_eq!(none.drag_shares([0.036, 0.072]), [0.0; 2]);
        }
    }
}
