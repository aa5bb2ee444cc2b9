//! Whether a run keeps up with the clock, and which input holds it up.

use std::time::Duration;

use crate::variator::settings::signals::Inputs;

/// Simulated time over which a run is judged, s.
const SPAN: f64 = 1.0;

/// Names of the inputs in the order of [`Inputs::values`], and a usual size of each: changes are counted in it.
const INPUTS: [(&str, f64); 6] = [
    ("primary.torque", 100.0),
    ("primary.clampingForce", 1.0e4),
    ("primary.speedSetpoint", 200.0),
    ("secondary.torque", 100.0),
    ("secondary.clampingForce", 1.0e4),
    ("secondary.speedSetpoint", 200.0),
];

/// Simulated time, computing time and how much each input moved since the last judgement.
#[derive(Clone, Debug, Default)]
pub(super) struct Pace {
    simulated: f64,
    computed: Duration,
    moved: [f64; 6],
    given: Option<Inputs>,
}

impl Pace {
    /// Counts a communication step of `simulated` seconds under the inputs `given`. After each second of simulation that took
    /// longer to compute, says so.
    pub fn count(&mut self, given: &Inputs, simulated: f64, computed: Duration) -> Option<String> {
        let before = self.given.replace(*given).unwrap_or(*given);
        let sizes = INPUTS.iter().map(|(_, size)| size);
        let values = given.values().into_iter().zip(before.values());
        for (moved, (size, (now, before))) in self.moved.iter_mut().zip(sizes.zip(values)) {
            *moved += (now - before).abs() / size;
        }
        self.simulated += simulated;
        self.computed += computed;
        if self.simulated < SPAN {
            return None;
        }
        let late = (self.computed.as_secs_f64() > self.simulated).then(|| self.remark());
        *self = Self {
            given: self.given,
            ..Self::default()
        };
        late
    }

    fn remark(&self) -> String {
        let (most, (name, _)) = self
            .moved
            .iter()
            .zip(INPUTS)
            .max_by(|a, b| a.0.total_cmp(b.0))
            .unwrap_or((&0.0, INPUTS[0]));
        let cause = if *most > 0.0 {
            format!("{name} moves most: let it move slower, or inputs ramp over the whole step (inputs.ramp = -1); ")
        } else {
            String::new()
        };
        format!(
            "{:.1} s of simulation took {:.1} s of computing; {cause}ring.model = ALE0 is faster, and solver.mode = RealTime \
             takes the same time for each millisecond",
            self.simulated,
            self.computed.as_secs_f64()
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_that_takes_longer_is_said_once_with_the_input_that_moves() {
        let mut pace = Pace::default();
        let mut said = Vec::new();
        for k in 0..250 {
            let mut inputs = Inputs::default();
            inputs.secondary.torque += f64::from(k % 2) * 20.0;
            inputs.primary.clamping_force += f64::from(k % 3) * 10.0;
            let slow = if k < 100 { 15 } else { 2 };
            said.extend(pace.count(&inputs, 10e-3, Duration::from_millis(slow)));
        }
        assert_eq!(said.len(), 1);
        assert!(
            said[0].starts_with("1.0 s of simulation took 1.5 s of computing; secondary.torque moves most"),
            "{said:?}"
        );
    }
}
