//! The manoeuvre in the resources of the FMU.

use crate::variators::inputs;
use pushbelt::variator::settings::{Inputs, Parameters};

/// Lines of `resources/manoeuvre.csv`: time, torques of P and S, clamping forces of P and S; linear
/// between lines.
#[derive(Debug)]
pub struct Manoeuvre {
    rows: Vec<[f64; 5]>,
}

impl Manoeuvre {
    pub fn read() -> Self {
        let text = include_str!("../../../resources/manoeuvre.csv");
        let rows = text.lines().skip(1).map(|line| {
            let mut values = line.split(',').map(|x| x.parse().expect("a number"));
            std::array::from_fn(|_| values.next().expect("five columns"))
        });
        Self { rows: rows.collect() }
    }

    /// Inputs at time `t`.
    pub fn at(&self, t: f64) -> Inputs {
        let after = self.rows.partition_point(|row| row[0] <= t);
        let right = after.clamp(1, self.rows.len() - 1);
        let (a, b) = (&self.rows[right - 1], &self.rows[right]);
        let share = ((t - a[0]) / (b[0] - a[0])).clamp(0.0, 1.0);
        let value = |k: usize| a[k] + share * (b[k] - a[k]);
        inputs((value(1), value(3)), (value(2), value(4)))
    }

    /// Inputs at the start of every step of `step`, s.
    pub fn trace(&self, step: f64) -> Vec<Inputs> {
        let end = self.rows[self.rows.len() - 1][0];
        let count = (end / step).round() as u32;
        (0..count).map(|k| self.at(f64::from(k) * step)).collect()
    }

    /// Its variator: a vehicle's inertia on the secondary shaft, at a standstill in underdrive.
    pub fn variator(mut parameters: Parameters) -> Parameters {
        parameters.secondary.inertia = 4.0;
        parameters.initial.ratio = 2.2;
        parameters.initial.primary_speed = 0.0;
        parameters
    }
}
