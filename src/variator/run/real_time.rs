//! Real time: the accurate integrator with a bound on the work of each millisecond ([`REAL_TIME`]),
//! in short steps of one length. A step that takes more stays open and continues in the next
//! millisecond: the run is then behind the clock, and its inputs wait. Unused work makes up for it
//! later. A step without a solution is begun again with half the length.

use super::simulation::Simulation;
use super::tuning::REAL_TIME;
use crate::archive::Archive;
use crate::solver::newton::{Unsolved, WorkBound};
use crate::solver::sdirk::Sdirk;
use crate::variator::pulleys::loads::{InputProfile, SHORTEST_STEP};
use crate::variator::settings::Inputs;

/// The millisecond of the clock, s, whose work is bounded.
const MILLISECOND: f64 = 1.0e-3;
/// Part of a step by which a number of steps may exceed a whole one: rounding.
const ROUNDING: f64 = 1.0e-9;

#[derive(Clone, Debug)]
pub(super) struct RealTime {
    /// Time of the state, s.
    reached: f64,
    /// Time that was left out since the start, s.
    pub skipped: f64,
    /// Inputs from the state, or the end of the open step, to the clock.
    waiting: InputProfile,
    /// Length of steps as a fraction of the longest, and length of the open step, s, if there is
    /// one.
    fraction: f64,
    open: Option<f64>,
    inputs: InputProfile,
}

impl RealTime {
    /// A run from the state and time of a simulation, in steps by `sdirk`.
    pub fn new(simulation: &Simulation, sdirk: &mut Sdirk) -> Self {
        (sdirk.step, sdirk.newton_widening) = (REAL_TIME.step, 0.0);
        sdirk.newton.bound = WorkBound {
            remaining: 0.0,
            jacobian: REAL_TIME.jacobian,
            geometry: REAL_TIME.geometry,
            overdraft: REAL_TIME.overdraft,
            ..WorkBound::NONE
        };
        let inputs = InputProfile::constant(&simulation.inputs());
        Self {
            reached: simulation.time,
            skipped: 0.0,
            waiting: inputs,
            fraction: 1.0,
            open: None,
            inputs,
        }
    }

    /// Advances the clock by a millisecond or less towards a time, s, and the state within the
    /// work.
    pub fn advance(
        &mut self,
        sdirk: &mut Sdirk,
        simulation: &mut Simulation,
        profile: &InputProfile,
        to: f64,
    ) {
        let from = simulation.time;
        let parts = ((to - from) / MILLISECOND - ROUNDING).ceil();
        let clock = if parts > 1.0 { from + (to - from) / parts } else { to };
        let since = self.reached + self.open.unwrap_or_default();
        self.waiting = joined(&self.waiting, since, from, profile, clock);
        let effort = f64::from(simulation.system.parameters.solver.effort);
        let remaining = &mut sdirk.newton.bound.remaining;
        *remaining =
            remaining.min(REAL_TIME.spare) + effort * REAL_TIME.effort * ((clock - from) / MILLISECOND);
        simulation.time = self.reached;
        simulation.restore(self.inputs);
        let wider = if self.open.is_some() { REAL_TIME.widening } else { 1.0 };
        sdirk.newton_tolerance = wider * REAL_TIME.tolerance;
        while self.behind(clock) > SHORTEST_STEP && self.step(sdirk, simulation, clock) {}
        let skipped = self.behind(clock) - REAL_TIME.behind;
        if skipped > 0.0 {
            // An open step and its inputs move in time. Waiting inputs are then constant.
            self.reached += skipped;
            self.skipped += skipped;
            self.inputs.kink += skipped;
        }
        simulation.time = clock;
    }

    /// Takes or continues a step towards the time `clock`, s. False if the work is used up.
    fn step(&mut self, sdirk: &mut Sdirk, simulation: &mut Simulation, clock: f64) -> bool {
        let length = self.open.unwrap_or_else(|| self.begin_step(simulation, clock));
        let (mut problem, state) = simulation.problem();
        let solved = sdirk.fixed_step(&mut problem, state, self.reached, length);
        self.open = None;
        match solved {
            Ok(()) => {
                let rest = self.behind(clock) - length;
                self.reached = if rest < SHORTEST_STEP {
                    clock
                } else {
                    self.reached + length
                };
                simulation.time = self.reached;
                self.fraction = (2.0 * self.fraction).min(1.0);
            }
            Err(Unsolved::OutOfWork) => self.open = Some(length),
            Err(Unsolved::NoSolution) => {
                sdirk.newton.counts.rejected += 1;
                let end = self.reached + length;
                self.waiting = joined(&self.inputs, self.reached, end, &self.waiting, clock);
                self.fraction = (0.5 * self.fraction).max(REAL_TIME.shortest);
            }
        }
        self.open.is_none()
    }

    /// Applies the inputs of the next step: a straight line with their mean. Returns its length, s:
    /// steps to the time `clock` are equal.
    fn begin_step(&mut self, simulation: &mut Simulation, clock: f64) -> f64 {
        let rest = self.behind(clock);
        let count = (rest / (self.fraction * REAL_TIME.step) - ROUNDING).ceil().max(1.0);
        let length = rest / count;
        self.inputs = line(&self.waiting, [self.reached, self.reached + length]);
        simulation.apply(self.inputs);
        length
    }

    /// How far the state is behind the clock, s.
    pub fn behind(&self, clock: f64) -> f64 {
        clock - self.reached
    }

    pub fn serialize(&mut self, archive: &mut Archive<'_>) {
        self.waiting.serialize(archive);
        self.inputs.serialize(archive);
        archive.real(&mut self.reached);
        archive.real(&mut self.skipped);
        archive.bounded_real(&mut self.fraction, REAL_TIME.shortest, 1.0);
        archive.option(&mut self.open);
    }
}

/// Mean of one profile from `from` to `middle` and another one to `to`, s, which keeps the impulse;
/// one of them where the other has no length.
fn joined(first: &InputProfile, from: f64, middle: f64, second: &InputProfile, to: f64) -> InputProfile {
    if middle - from <= SHORTEST_STEP {
        return *second;
    }
    if to - middle <= SHORTEST_STEP {
        return *first;
    }
    let fraction = (middle - from) / (to - from);
    let means = [mean(first, [from, middle]), mean(second, [middle, to])];
    InputProfile::constant(&Inputs::ZERO.after(fraction, &means[0]).after(1.0 - fraction, &means[1]))
}

fn mean(profile: &InputProfile, [from, to]: [f64; 2]) -> Inputs {
    let kink = profile.kink.clamp(from, to);
    let part = |start: f64, end: f64, sum: Inputs| {
        sum.after((end - start) / (to - from), &profile.evaluate(0.5 * (start + end)))
    };
    part(kink, to, part(from, kink, Inputs::ZERO))
}

/// The straight line from the inputs at one time to those at another, s, shifted to their mean.
fn line(profile: &InputProfile, [from, to]: [f64; 2]) -> InputProfile {
    let length = to - from;
    let rates = Inputs::ZERO
        .after(1.0 / length, &profile.evaluate(to))
        .after(-1.0 / length, &profile.evaluate(from));
    InputProfile {
        kink: from,
        inputs: mean(profile, [from, to]).after(-0.5 * length, &rates),
        rates: [rates; 2],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::variator::Variator;
    use crate::variator::pulleys::loads::tests::torque;
    use crate::variator::settings::parameters::{Mode, Parameters};

    /// Ramps to 50 N·m and on to -50 N·m, each in a quarter of a millisecond, have the same impulse.
    #[test]
    fn no_impulse_is_lost() {
        let ramp = |from: f64, present: f64, given: f64| {
            let [present, given] = [present, given].map(torque);
            InputProfile::new(0.25e-3, [from, from + 1e-3], &present, &given, &Inputs::ZERO)
        };
        let (first, second) = (ramp(0.0, 0.0, 50.0), ramp(1e-3, 50.0, -50.0));
        let impulse = |profile: &InputProfile, from: f64, to: f64| {
            let line = line(profile, [from, to]);
            let [start, end] = [from, to].map(|time| line.evaluate(time).primary.torque);
            0.5 * (start + end) * (to - from)
        };
        let both = joined(&first, 0.7e-3, 1e-3, &second, 2e-3);
        let found =
            impulse(&first, 0.0, 0.2e-3) + impulse(&first, 0.2e-3, 0.7e-3) + impulse(&both, 0.7e-3, 2e-3);
        let expected = (50e-3 - 6.25e-3) - 50e-3 + 12.5e-3;
        assert!((found - expected).abs() < 1e-12, "{found}, not {expected}");
        assert_eq!(joined(&first, 1e-3, 1e-3, &second, 2e-3), second);
    }

    #[test]
    fn an_open_step_moves_with_its_inputs() {
        let mut parameters = Parameters::default();
        parameters.friction.velocity = 5e-5;
        let solver = &mut parameters.solver;
        (solver.mode, solver.effort, solver.input_ramp) = (Mode::RealTime, 1, -1.0);
        let mut variator = Variator::new(parameters).expect("valid parameters");
        let mut inputs = Inputs::default();
        variator.initialise(0.0, &inputs).expect("a start");
        let mut moved = 0;
        for k in 1..=150 {
            inputs.primary.torque = if k % 2 == 0 { 60.0 } else { -60.0 };
            variator.advance(1e-3 * f64::from(k), &inputs).expect("a step");
            let run = variator.stepper.real_time.as_ref().expect("real time");
            if run.open.is_some() {
                assert!((run.inputs.kink - run.reached).abs() < 1e-12, "{k}");
                moved += i32::from(run.behind(variator.time()) > REAL_TIME.behind - 1e-9);
            }
        }
        assert!(moved > 0, "no time was left out");
    }
}
