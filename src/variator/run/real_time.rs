//! Real time: from tick to tick of bounded work. A tick that ends very far from its solution is not taken: the run goes back to the
//! last state that was solved and on from there in shorter ticks, behind the clock, until longer ones have caught up with it.

use crate::solver::bounded::{Bounded, Tick};
use crate::solver::newton::Counts;
use crate::solver::{State, System};
use crate::tape::Tape;
use crate::variator::run::course::{Course, Held, SHORTEST_STEP};
use crate::variator::run::rounding::Rounding;
use crate::variator::settings::signals::Inputs;
use crate::variator::survey::ledger::Running;

/// Defect up to which a state counts as solved.
const SOLVED: f64 = 400.0;
/// Defect from which on a tick is not taken: the next ones would be further off.
const BACK: f64 = 2.0e4;
/// Energy that may appear or vanish in a tick that isn't solved, J, and as a share of what passes. With 5 J and no share, macro-slip is
/// seen 7 ms late.
const UNACCOUNTED: [f64; 2] = [2.0, 0.2];
/// What a tick that is not taken does to the length of the next ones, what one that is solved does, and the least that is left of it.
const SHORTER: f64 = 0.25;
const LONGER: f64 = 1.5;
const SHORTEST: f64 = 0.01;
/// Share by which ticks are longer until the run has caught up with the clock.
const CATCHING_UP: f64 = 0.5;
/// Longest time that a run is behind the clock, s. What is beyond it is never made up for.
const BEHIND: f64 = 0.02;

/// A stretch of time, s, and the integral of the inputs over it.
#[derive(Clone, Copy, Debug)]
struct Elapsed {
    time: f64,
    inputs: Inputs,
}

impl Elapsed {
    const NONE: Self = Self {
        time: 0.0,
        inputs: Inputs::ZERO,
    };

    /// Adds a time, s, under inputs; a negative one takes it away.
    fn add(&mut self, time: f64, inputs: &Inputs) {
        self.time += time;
        self.inputs = self.inputs.after(time, inputs);
    }

    fn mean(&self) -> Inputs {
        if self.time == 0.0 {
            return Inputs::ZERO;
        }
        Inputs::ZERO.after(1.0 / self.time, &self.inputs)
    }

    /// Drops what is beyond a longest time, s.
    fn shorten(&mut self, longest: f64) {
        if self.time < SHORTEST_STEP {
            *self = Self::NONE;
        } else if self.time > longest {
            let mean = self.mean();
            *self = Self::NONE;
            self.add(longest, &mean);
        }
    }

    fn pass(&mut self, tape: &mut Tape<'_>) {
        tape.real(&mut self.time);
        for value in self.inputs.each_mut() {
            tape.real(value);
        }
    }
}

/// A tick to come: from when to when, how, by what share the laws are rounded, and the inputs over it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plan {
    span: [f64; 2],
    kind: Tick,
    pub rounding: f64,
    pub held: Held,
}

/// A run in real time.
#[derive(Clone, Debug)]
pub(super) struct RealTime {
    ticks: Bounded,
    rounding: Rounding,
    /// The state to go back to, the energies there, and what was lived through since.
    solved: State,
    energies: [f64; 3],
    since: Elapsed,
    /// What is still to be lived through, up to the clock's time.
    behind: Elapsed,
    /// Length of ticks, as a share of the clock's.
    share: f64,
}

impl RealTime {
    /// Memory for a system.
    pub fn new(system: &impl System) -> Self {
        Self {
            ticks: Bounded::new(system),
            rounding: Rounding::default(),
            solved: State::zero(system.shape().len()),
            energies: [0.0; 3],
            since: Elapsed::NONE,
            behind: Elapsed::NONE,
            share: 1.0,
        }
    }

    /// Begins a run from a state, with no energies yet.
    pub fn begin(&mut self, state: &State) {
        self.ticks.counts = Counts::default();
        self.rounding = Rounding::default();
        self.solved.copy_from(state);
        self.energies = [0.0; 3];
        (self.since, self.behind) = (Elapsed::NONE, Elapsed::NONE);
        self.share = 1.0;
    }

    /// The tick for a stretch of the clock's time, s. A rough one takes the mean of its inputs, so no impulse is lost; a calm one
    /// their straight line; one behind the clock the mean of all that it is behind.
    pub fn plan(&mut self, course: &Course, [from, to]: [f64; 2]) -> Plan {
        let rounding = self.rounding.share();
        let kind = if rounding > 0.0 { Tick::Rough } else { Tick::Calm };
        let clock = to - from;
        let mean = course.mean([from, to]);
        let behind = self.behind.time;
        self.behind.add(clock, &mean);
        let length = if self.share < 1.0 {
            self.share * clock
        } else if self.since.time > 0.0 {
            clock
        } else {
            clock + behind.min(CATCHING_UP * clock)
        };
        let held = if self.behind.time > clock {
            Held::constant(from, &self.behind.mean())
        } else if kind == Tick::Calm {
            course.line([from, to])
        } else {
            Held::constant(from, &mean)
        };
        Plan {
            span: [to - length, to],
            kind,
            rounding,
            held,
        }
    }

    /// One tick, from a state to the next.
    pub fn tick(&mut self, running: &mut Running<'_>, state: &mut State, plan: &Plan) {
        let before = (running.unaccounted(state.view()), running.ledger.moved);
        let defect = self.ticks.tick(running, state, plan.span, plan.kind);
        let unaccounted = running.unaccounted(state.view()) - before.0;
        let moved = running.ledger.moved - before.1;
        let sound = unaccounted.abs() <= UNACCOUNTED[0] + UNACCOUNTED[1] * moved;
        self.rounding.follow(defect);
        let length = plan.span[1] - plan.span[0];
        if defect > BACK || defect > SOLVED && !sound {
            state.copy_from(&self.solved);
            state.y_dot.fill(0.0);
            running.go_back(self.energies, state.view());
            // What outputs say of a tick that wasn't taken.
            self.ticks.defect = self.ticks.defect.max(BACK);
            self.behind.add(self.since.time, &self.since.mean());
            self.since = Elapsed::NONE;
            self.share = (SHORTER * self.share).max(SHORTEST);
        } else {
            let inputs = &plan.held.at(0.5 * (plan.span[0] + plan.span[1]));
            self.behind.add(-length, inputs);
            self.since.add(length, inputs);
            if defect < SOLVED {
                self.keep(running, state);
                self.share = (LONGER * self.share).min(1.0);
            }
        }
        self.behind.shorten(BEHIND);
    }

    fn keep(&mut self, running: &Running<'_>, state: &State) {
        self.solved.copy_from(state);
        self.energies = running.energies();
        self.since = Elapsed::NONE;
    }

    /// Largest defect since it was asked for.
    pub fn take_defect(&mut self) -> f64 {
        std::mem::take(&mut self.ticks.defect)
    }

    /// Work done since the run began.
    pub fn counts(&self) -> Counts {
        self.ticks.counts
    }

    /// Passes by a tape all that later ticks depend on.
    pub fn pass(&mut self, tape: &mut Tape<'_>) {
        self.ticks.pass(tape);
        self.rounding.pass(tape);
        self.solved.pass(tape);
        for energy in &mut self.energies {
            tape.real(energy);
        }
        self.since.pass(tape);
        self.behind.pass(tape);
        tape.real(&mut self.share);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::variator::run::course::tests::torque;

    /// Two milliseconds of 50 N·m and one of −50 N·m are lived through in ticks of other lengths.
    #[test]
    fn impulses_are_kept_until_the_run_has_caught_up() {
        let mut behind = Elapsed::NONE;
        behind.add(2e-3, &torque(50.0));
        behind.add(1e-3, &torque(-50.0));
        let mut impulse = 0.0;
        for length in [0.25e-3, 1.5e-3, 1.25e-3] {
            let mean = behind.mean();
            assert!((mean.primary.torque - 50.0 / 3.0).abs() < 1e-9, "{mean:?}");
            behind.add(-length, &mean);
            impulse += length * mean.primary.torque;
            behind.shorten(BEHIND);
        }
        assert!((impulse - 50e-3).abs() < 1e-12, "{impulse}");
        assert_eq!((behind.time, behind.inputs), (0.0, Inputs::ZERO));
    }

    #[test]
    fn what_is_too_far_behind_is_left_out() {
        let mut behind = Elapsed::NONE;
        behind.add(2.0 * BEHIND, &torque(50.0));
        behind.shorten(BEHIND);
        assert_eq!(behind.time, BEHIND);
        assert!((behind.mean().primary.torque - 50.0).abs() < 1e-9);
    }
}
