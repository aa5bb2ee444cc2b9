//! For tests of the laws: the default parameters of each law, and an integral.

pub use pushbelt::contact::{Contact, Friction};
pub use pushbelt::pulley::Travel;
pub use pushbelt::stack::PushElements;

use pushbelt::ring::mesh::gauss;
use pushbelt::variator::settings::Parameters;

pub fn belt() -> PushElements {
    Parameters::default().belt
}

pub fn contact() -> Contact {
    Parameters::default().contact
}

pub fn friction() -> Friction {
    Parameters::default().friction
}

/// cos β of the default variator.
pub fn cos_beta() -> f64 {
    Parameters::default().geometry.wedge_angle.cos()
}

/// ∫f dx by five Gauss points in each of `panels` parts.
pub fn integral(f: impl Fn(f64) -> f64, [from, to]: [f64; 2], panels: u32) -> f64 {
    let half = 0.5 * (to - from) / f64::from(panels);
    let panel = |k: u32| {
        let middle = from + (2.0 * f64::from(k) + 1.0) * half;
        gauss(5).iter().map(|(x, w)| w * f(middle + x * half)).sum::<f64>()
    };
    (0..panels).map(panel).sum::<f64>() * half
}
