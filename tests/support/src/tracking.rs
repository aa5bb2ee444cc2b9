//! Comparison of two runs under the same load.

use crate::loads::{Driven, LoadHistory};
use pushbelt::variator::settings::{Outputs, Parameters};

pub type Tracked = (&'static str, fn(&Outputs) -> f64);

/// Outputs that are compared, by name: speeds, ratio, slip, thrust ratio.
pub const TRACKED: [Tracked; 5] = [
    ("primary speed", |o| o.primary.speed),
    ("secondary speed", |o| o.secondary.speed),
    ("ratio", |o| o.ratio_geometric),
    ("slip", |o| o.slip),
    ("thrust ratio", |o| o.thrust_ratio),
];

/// Outputs of a run at each communication step.
#[derive(Clone, Debug, Default)]
pub struct Trace {
    pub rows: Vec<[f64; TRACKED.len()]>,
    pub slipping: Vec<bool>,
    /// Largest defect of a step.
    pub defect: f64,
    /// Energy residual as a share of the transmitted energy.
    pub unaccounted: f64,
}

/// A variator under a load at a ratio for `seconds`; `see` is called with the variator after each
/// step.
///
/// # Panics
/// If a step fails.
pub fn trace(
    load: LoadHistory,
    parameters: &Parameters,
    ratio: f64,
    seconds: f64,
    mut see: impl FnMut(&mut Driven),
) -> Trace {
    let mut driven = Driven::new(load, parameters.clone(), ratio);
    let mut trace = Trace::default();
    for _ in 0..(seconds / load.step()).round() as usize {
        driven.step();
        see(&mut driven);
        let outputs = driven.variator.outputs();
        trace.rows.push(TRACKED.map(|(_, read)| read(outputs)));
        trace.slipping.push(outputs.macro_slip);
        trace.defect = trace.defect.max(outputs.work.defect);
    }
    let residual = driven.variator.outputs().energy_residual;
    trace.unaccounted = residual / driven.variator.energy_balance().moved;
    trace
}

impl Trace {
    /// Root mean squares of the differences from `exact`.
    pub fn off(&self, exact: &Self) -> [f64; TRACKED.len()] {
        std::array::from_fn(|k| {
            let squares = self.rows.iter().zip(&exact.rows).map(|(a, b)| (a[k] - b[k]).powi(2));
            (squares.sum::<f64>() / exact.rows.len() as f64).sqrt()
        })
    }

    pub fn ranges(&self) -> [f64; TRACKED.len()] {
        std::array::from_fn(|k| {
            let column = || self.rows.iter().map(|row| row[k]);
            column().fold(f64::NEG_INFINITY, f64::max) - column().fold(f64::INFINITY, f64::min)
        })
    }

    /// The first step in which the belt slips through.
    pub fn first_slip(&self) -> Option<usize> {
        self.slipping.iter().position(|&slips| slips)
    }
}
