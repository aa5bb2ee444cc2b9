//! Whether a run keeps up with the clock, by its work, and the input that prevents it. Work is
//! counted and not timed, so messages are a function of the inputs.

use super::tuning::JUDGEMENT;
use crate::archive::Archive;
use crate::solver::newton::Counts;
use crate::variator::pulleys::loads::SHORTEST_STEP;
use crate::variator::settings::{INPUTS, Inputs};

/// Simulated time, work, and change of each input since the last judgement.
#[derive(Clone, Debug, Default)]
pub(super) struct RealTimeMonitor {
    simulated: f64,
    residuals: u64,
    jacobians: u64,
    moved: [f64; 8],
    given: Inputs,
}

impl RealTimeMonitor {
    /// A run that starts with these inputs.
    pub fn new(given: &Inputs) -> Self {
        Self {
            given: *given,
            ..Self::default()
        }
    }

    /// Counts a communication step of `simulated` seconds under the inputs `given`, with its work.
    /// Returns a remark after each second of simulation with too much work.
    pub fn count(&mut self, given: &Inputs, simulated: f64, work: Counts, unknowns: usize) -> Option<String> {
        let values = given.values().into_iter().zip(self.given.values());
        for ((moved, input), (now, before)) in self.moved.iter_mut().zip(INPUTS).zip(values) {
            *moved += (now - before).abs() / input.size;
        }
        self.given = *given;
        self.simulated += simulated;
        self.residuals += work.residuals;
        self.jacobians += work.factorizations;
        if self.simulated < JUDGEMENT.time - SHORTEST_STEP {
            return None;
        }
        let units = self.residuals as f64 + JUDGEMENT.jacobian * self.jacobians as f64;
        let computing = units * unknowns as f64 * JUDGEMENT.residual;
        let late = (computing > self.simulated).then(|| self.remark(computing));
        *self = Self::new(given);
        late
    }

    fn remark(&self, computing: f64) -> String {
        let moved = self.moved.iter().zip(INPUTS).filter(|(moved, _)| **moved > 0.0);
        let most = moved.max_by(|a, b| a.0.total_cmp(b.0));
        let cause = most.map_or(String::new(), |(_, input)| {
            format!(
                "{} varies most: let it vary more slowly, or inputs ramp over the whole step (inputs.ramp = -1); ",
                input.name
            )
        });
        format!(
            "{:.1} s of simulation took {} Jacobians and {} residuals, some {computing:.1} s of computing on a usual processor; \
             {cause}ring.model = ALE0 is faster, and solver.mode = RealTime bounds the work of each millisecond",
            self.simulated, self.jacobians, self.residuals
        )
    }

    pub fn serialize(&mut self, archive: &mut Archive<'_>) {
        archive.real(&mut self.simulated);
        archive.counter(&mut self.residuals);
        archive.counter(&mut self.jacobians);
        for value in self.moved.iter_mut().chain(self.given.each_mut()) {
            archive.real(value);
        }
    }
}
