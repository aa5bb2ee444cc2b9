//! Whether a run keeps up with the clock, judged by its work, and which input holds it up. Work is counted and not timed: what a run logs
//! is a function of its inputs.

use crate::archive::Archive;
use crate::solver::newton::Counts;
use crate::variator::pulleys::loads::SHORTEST_STEP;
use crate::variator::run::tuning::{JACOBIAN, JUDGED, RESIDUAL};
use crate::variator::settings::signals::Inputs;

/// Names of the inputs in the order of [`Inputs::values`], and a usual size of each: changes are counted in it.
const INPUTS: [(&str, f64); 8] = [
    ("primary.torque", 100.0),
    ("primary.clampingForce", 1.0e4),
    ("primary.speedSetpoint", 200.0),
    ("primary.pressure", 1.0e6),
    ("secondary.torque", 100.0),
    ("secondary.clampingForce", 1.0e4),
    ("secondary.speedSetpoint", 200.0),
    ("secondary.pressure", 1.0e6),
];

/// Simulated time, work, and how much each input moved since the last judgement.
#[derive(Clone, Debug, Default)]
pub(super) struct Pace {
    simulated: f64,
    residuals: u64,
    jacobians: u64,
    moved: [f64; 8],
    given: Inputs,
}

impl Pace {
    /// A run that starts with these inputs.
    pub fn new(given: &Inputs) -> Self {
        Self {
            given: *given,
            ..Self::default()
        }
    }

    /// Counts a communication step of `simulated` seconds under the inputs `given`, with its work on so many unknowns. Returns a remark
    /// after each second of simulation for which that was too much.
    pub fn count(&mut self, given: &Inputs, simulated: f64, work: Counts, unknowns: usize) -> Option<String> {
        let sizes = INPUTS.iter().map(|(_, size)| size);
        let values = given.values().into_iter().zip(self.given.values());
        for (moved, (size, (now, before))) in self.moved.iter_mut().zip(sizes.zip(values)) {
            *moved += (now - before).abs() / size;
        }
        self.given = *given;
        self.simulated += simulated;
        self.residuals += work.residuals;
        self.jacobians += work.factorizations;
        if self.simulated < JUDGED - SHORTEST_STEP {
            return None;
        }
        let units = self.residuals as f64 + JACOBIAN * self.jacobians as f64;
        let computing = units * unknowns as f64 * RESIDUAL;
        let late = (computing > self.simulated).then(|| self.remark(computing));
        *self = Self::new(given);
        late
    }

    fn remark(&self, computing: f64) -> String {
        let moved = self.moved.iter().zip(INPUTS).filter(|(moved, _)| **moved > 0.0);
        let most = moved.max_by(|a, b| a.0.total_cmp(b.0));
        let cause = most.map_or(String::new(), |(_, (name, _))| {
            format!(
                "{name} varies most: let it vary more slowly, or inputs ramp over the whole step (inputs.ramp = -1); "
            )
        });
        format!(
            "{:.1} s of simulation took {} Jacobians and {} residuals, some {computing:.1} s of computing on a usual processor; \
             {cause}ring.model = ALE0 is faster, and solver.mode = RealTime bounds the work of each millisecond",
            self.simulated, self.jacobians, self.residuals
        )
    }

    /// Writes to an archive, or reads from it.
    pub fn serialize(&mut self, archive: &mut Archive<'_>) {
        archive.real(&mut self.simulated);
        archive.counter(&mut self.residuals);
        archive.counter(&mut self.jacobians);
        for value in self.moved.iter_mut().chain(self.given.each_mut()) {
            archive.real(value);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_of_too_much_work_is_reported_once_with_the_input_that_moves() {
        let mut pace = Pace::new(&Inputs::default());
        let mut reported = Vec::new();
        for k in 0..250 {
            let mut inputs = Inputs::default();
            inputs.secondary.torque += f64::from(k % 2) * 20.0;
            inputs.primary.clamping_force += f64::from(k % 3) * 10.0;
            let work = Counts {
                residuals: if k < 100 { 650 } else { 100 },
                factorizations: 30,
                ..Counts::default()
            };
            reported.extend(pace.count(&inputs, 10e-3, work, 400));
        }
        assert_eq!(reported.len(), 1);
        let expected = "1.0 s of simulation took 3000 Jacobians and 65000 residuals, some 1.5 s of computing on a usual processor; \
                        secondary.torque varies most";
        assert!(reported[0].starts_with(expected), "{reported:?}");
    }
}
