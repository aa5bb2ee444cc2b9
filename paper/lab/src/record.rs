//! Runs of a ring alone, sampled at equal intervals.

use crate::motion::advance;
use crate::system::RingSystem;
use pushbelt::solver::State;
use pushbelt::solver::newton::Counts;
use pushbelt::solver::sdirk::Sdirk;
use pushbelt_paper::ring::model::{Energy, RingFormulation};

/// A ring at one time.
pub struct RingSample {
    pub time: f64,
    pub theta: f64,
    /// s, m.
    pub drift: f64,
    pub energy: Energy,
    pub state: State,
}

/// A run, sampled at equal intervals from its start on.
pub struct Record {
    pub samples: Vec<RingSample>,
    pub counts: Counts,
}

impl Record {
    /// Largest change of the energy, J.
    pub fn energy_drift(&self) -> f64 {
        let start = self.samples[0].energy.total();
        let off = |sample: &RingSample| (sample.energy.total() - start).abs();
        self.samples.iter().map(off).fold(0.0, f64::max)
    }

    /// Smallest and largest Θ.
    pub fn ratios(&self) -> (f64, f64) {
        self.samples
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), sample| {
                (low.min(sample.theta), high.max(sample.theta))
            })
    }

    /// Largest |s|, m.
    pub fn largest_drift(&self) -> f64 {
        self.samples.iter().map(|sample| sample.drift.abs()).fold(0.0, f64::max)
    }
}

/// Runs from `state` for `count` times `step`, s. Ends early if the integrator fails or |Θ| exceeds
/// `limit`.
pub fn record<M: RingFormulation>(
    system: &mut RingSystem<M>,
    mut state: State,
    first_step: f64,
    step: f64,
    count: usize,
    limit: f64,
) -> Record {
    let sample = |system: &RingSystem<M>, state: &State, time: f64| RingSample {
        time,
        theta: state.q[system.theta()],
        drift: state.q[system.drift()],
        energy: system.energy(state.view()),
        state: state.clone(),
    };
    let mut integrator = Sdirk::new(system, first_step, 1.0e-3);
    let mut samples = vec![sample(system, &state, 0.0)];
    for k in 0..count {
        let span = [k, k + 1].map(|k| k as f64 * step);
        if advance(&mut integrator, system, &mut state, span).is_err()
            || state.q[system.theta()].abs() > limit
        {
            break;
        }
        samples.push(sample(system, &state, span[1]));
    }
    Record {
        samples,
        counts: integrator.newton.counts,
    }
}
