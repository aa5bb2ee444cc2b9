//! The state that a run starts from: unloaded or steady as the parameters choose, else the nearest that exists.

use crate::contact::full_slip_torque;
use crate::pulley::{PerPulley, Pulley};
use crate::solver::State;
use crate::solver::continuation::Settled;
use crate::solver::newton::{Counts, Newton, WorkBound};
use crate::variator::belt::ring::BeltRing;
use crate::variator::diagnostics::belt::{BeltDiagnostics, NO_FORCE};
use crate::variator::diagnostics::observe::macro_slip;
use crate::variator::pulleys::loads::{Boundary, ShaftMode};
use crate::variator::run::at_rest::Unsettled;
use crate::variator::run::no_steady_state::NoSteadyState;
use crate::variator::run::outcome::{InitialisationError, Message};
use crate::variator::run::plant::Plant;
use crate::variator::run::soft_start::{LOAD_RAMP, SoftStart};
use crate::variator::run::stepper::{COLD_STEP, WARM_STEP};
use crate::variator::settings::capacity::{Demand, excessive_speed};
use crate::variator::settings::parameters::{Axial, Drive, Initial, Mode};
use crate::variator::settings::signals::{Inputs, StartState};
use crate::variator::steady::equilibrium::{Equilibrium, solve_equilibrium};
use crate::variator::steady::solve::{self, SteadyTask};
use crate::variator::steady::start::{Start, kinematic_state};
use std::sync::Arc;

/// Most Newton solves for a steady state.
const STEADY_SOLVES: usize = 400;

/// Share of the torques below which no smaller one is tried, and the factor to which the largest is found.
const LEAST_SHARE: f64 = 0.05;
const CLOSE_SHARE: f64 = 1.05;
/// Factor from one share to the next while there is none that is carried.
const NEXT_SHARE: f64 = 0.7;

/// Most work of the search for a steady state, in residuals, and that of a Jacobian with its factors. Of some 220 starts, two thirds of them
/// at random with both rings and chains, a steady state took at most 49 000, one at reduced torque 77 000.
const STEADY_WORK: f64 = 2.5e5;
const JACOBIAN_WORK: f64 = 14.0;

/// Share of full slip up to which a torque isn't beyond capacity: braking in underdrive it is, from 0.57 on.
const CARRIED_AT_LEAST: f64 = 0.5;

/// Slip of a pushbelt at capacity, as a first guess: measured variators begin to slip through between 1 and 3 %.
const SLIP_AT_CAPACITY: f64 = 0.015;

/// Pitch radius on the primary pulley as a share of the distance of the axes, for a first guess: 0.35 at ratio 1, 0.2 in
/// underdrive.
const USUAL_RADIUS: f64 = 0.3;

/// Speed of a pulley below which it stands still, rad/s.
const STANDSTILL: f64 = 1.0e-3;

/// Speed of the primary pulley, rad/s, and friction velocity, m/s, of the belt that creeps into a standstill. The axial force is
/// within 2 % of that at half and at double the speed: sliding speeds are far above the friction velocity, a centrifugal tension
/// of some 2 N is far below the ring's, and oil bears as much as between the elements of a belt that slows down.
const CREEP_SPEED: f64 = 20.0;
const CREEP_FRICTION_VELOCITY: f64 = 5.0e-5;

/// Finds the state to start from at `time`: steady or unloaded as the parameters choose, else the nearest that exists, with a warning that
/// gives it and the reason. Returns what it is, and the first step from it, s.
pub(super) fn find_start(
    plant: &mut Plant,
    messages: &mut Vec<Message>,
    time: f64,
    inputs: &Inputs,
) -> Result<(StartState, f64), InitialisationError> {
    let mut search = StartSearch {
        plant,
        messages,
        inputs,
    };
    search.plant.start_work = Counts::default();
    search.clamp_initial_ratio();
    let start = search.start_point();
    let found = search.find_state(time, &start)?;
    search.warn_of_held_sheaves(found);
    let is_solved = matches!(
        found,
        StartState::Steady | StartState::ReducedTorque | StartState::NoEquilibrium
    ) && start.primary_speed.abs() > STANDSTILL;
    if plant.system.parameters.solver.mode == Mode::RealTime && plant.soft_start.from == time {
        // A ring without tension is a mechanism, too rough for steps of bounded work.
        if let Err(why) = plant.clamp_softly(inputs) {
            messages.push(no_clamping(&why));
        }
    }
    let is_own = plant.system.belt.ring.starts_on().is_none();
    Ok((found, if is_solved && is_own { WARM_STEP } else { COLD_STEP }))
}

fn no_clamping(why: &Unsettled) -> Message {
    Message {
        warning: true,
        text: format!("the belt was not clamped before the start: {why}"),
    }
}

/// The search for the state that a run starts from.
struct StartSearch<'a> {
    plant: &'a mut Plant,
    messages: &'a mut Vec<Message>,
    inputs: &'a Inputs,
}

impl StartSearch<'_> {
    fn log(&mut self, warning: bool, text: String) {
        self.messages.push(Message { warning, text });
    }

    /// Moves an initial ratio beyond an end stop to the stop.
    fn clamp_initial_ratio(&mut self) {
        let (lowest, highest) = self.plant.system.parameters.ratio_range();
        let given = self.plant.system.parameters.initial.ratio;
        let ratio = given.clamp(lowest, highest);
        if ratio != given {
            self.plant.system.parameters.initial.ratio = ratio;
            self.log(
                false,
                format!(
                    "initial.ratio = {given} lies beyond an end stop, where only a loaded belt rests: the run starts at {ratio:.6}"
                ),
            );
        }
    }

    /// The kinematic state to start from: a set point of a shaft's speed comes before `initial.primarySpeed`.
    fn start_point(&mut self) -> Start {
        let inputs = self.inputs;
        let parameters = &self.plant.system.parameters;
        let Initial {
            ratio,
            primary_speed: given,
            ..
        } = parameters.initial;
        let primary_speed = match (parameters.primary.drive, parameters.secondary.drive) {
            (Drive::Speed, _) => inputs.primary.speed_setpoint,
            (Drive::Torque, Drive::Speed) => inputs.secondary.speed_setpoint * ratio,
            (Drive::Torque, Drive::Torque) => given,
        };
        if primary_speed != given {
            self.log(
                false,
                format!(
                    "a shaft follows its set point: the run starts near {primary_speed} rad/s at the primary pulley, not at \
                     initial.primarySpeed = {given} rad/s"
                ),
            );
        }
        Start {
            ratio,
            primary_speed,
            clamping: self
                .plant
                .system
                .parameters
                .closing_forces(inputs, [ratio, primary_speed]),
        }
    }

    /// Warns where both sheaves are held: clamping forces have no effect in the run.
    fn warn_of_held_sheaves(&mut self, found: StartState) {
        if !self.plant.system.parameters.holds_both_sheaves() {
            return;
        }
        let text = if matches!(
            found,
            StartState::Steady | StartState::ReducedTorque | StartState::Clamped
        ) {
            "both sheaves are held: the belt's tension follows from secondary.clampingForce at the start, later clamping \
             forces are ignored"
        } else {
            "both sheaves are held in a start without load: the belt has no tension and carries next to nothing, clamping \
             forces are ignored"
        };
        self.log(true, text.into());
    }

    /// Sets the state that a run starts from.
    fn find_state(&mut self, time: f64, start: &Start) -> Result<StartState, InitialisationError> {
        self.plant.time = time;
        self.plant.end_soft_start();
        if let Some(ring) = self.plant.system.belt.ring.starts_on() {
            self.start_on(ring, start)
        } else if !self.plant.system.parameters.initial.steady {
            self.start_slack(start)
        } else if start.primary_speed.abs() > STANDSTILL {
            self.start_cold(start)?;
            match self.solve_steady() {
                Ok(found) => Ok(found),
                Err(why @ (NoSteadyState::Beyond(_) | NoSteadyState::TooFast(_))) => {
                    Err(InitialisationError::NoState(why.to_string()))
                }
                Err(why) => self.start_without_steady_state(&why, start),
            }
        } else {
            self.start_at_rest(start)
        }
    }

    /// Starts at a standstill: as a belt that crept, or else clamped from the unloaded state.
    fn start_at_rest(&mut self, start: &Start) -> Result<StartState, InitialisationError> {
        if self.may_creep(start)
            && let Some(found) = self.stop_creeping(start)?
        {
            return Ok(found);
        }
        self.start_unloaded(start)?;
        match self.plant.clamp_at_rest(self.inputs) {
            Ok(true) => Ok(StartState::Clamped),
            Ok(false) => self.start_slack(start),
            Err(why) => {
                self.messages.push(no_clamping(&why));
                self.start_unloaded(start)?;
                Ok(StartState::Unloaded)
            }
        }
    }

    /// Whether a start at a standstill may be that of a belt that crept: both pulleys stand still under clamping forces, and a sheave
    /// is held or the torques drive the belt.
    fn may_creep(&self, start: &Start) -> bool {
        let (p, inputs) = (&self.plant.system.parameters, self.inputs);
        let stands = p.secondary.drive == Drive::Torque || inputs.secondary.speed_setpoint.abs() <= STANDSTILL;
        let free = p.primary.drive == Drive::Torque && p.secondary.drive == Drive::Torque;
        let torque = inputs.primary.torque + inputs.secondary.torque / start.ratio;
        let driven = free && torque * creep_speed(start) > 0.0;
        stands && self.plant.is_clamped(inputs) && (p.holds_a_sheave() || driven)
    }

    /// Starts at rest with the forces of a belt that creeps at the torques: Coulomb friction leaves the forces of a belt at rest
    /// open, so they are those of the motion before. None with a warning where there is no such state, and none where both sheaves are
    /// under force and friction holds the torques: a belt that crept would roll back.
    fn stop_creeping(&mut self, start: &Start) -> Result<Option<StartState>, InitialisationError> {
        let creep = Start {
            primary_speed: creep_speed(start),
            ..*start
        };
        let mut creeping = self.plant.clone();
        creeping.state = self.kinematic_state(&creep)?;
        creeping.system.parameters.friction.velocity = CREEP_FRICTION_VELOCITY;
        let before = self.messages.len();
        let found = StartSearch {
            plant: &mut creeping,
            messages: self.messages,
            inputs: self.inputs,
        }
        .solve_steady();
        let belt = BeltDiagnostics::of(&creeping.system, creeping.state.view())
            .sums
            .shaft_torque;
        self.plant.take_start(creeping);
        let holds = (self.inputs.primary.torque + belt.primary) * creep.primary_speed <= 0.0;
        if found.is_ok() && holds && !self.plant.system.parameters.holds_a_sheave() {
            self.messages.truncate(before);
            return Ok(None);
        }
        let stopped = found.and_then(|found| match self.plant.bring_to_rest(self.inputs) {
            Ok(()) => Ok(found),
            Err(why) => Err(NoSteadyState::NotStopped(why)),
        });
        match stopped {
            Ok(StartState::Steady) => Ok(Some(StartState::Clamped)),
            Ok(found) => Ok(Some(found)),
            Err(why) => {
                self.log(
                    true,
                    format!("{why}: the run starts at rest without the forces of a belt that has run before"),
                );
                Ok(None)
            }
        }
    }

    fn kinematic_state(&self, start: &Start) -> Result<State, InitialisationError> {
        kinematic_state(&self.plant.system.belt, start).map_err(|e| InitialisationError::NoState(e.to_string()))
    }

    /// Starts in the kinematic state, the secondary pulley at its set point if it has one.
    fn start_cold(&mut self, start: &Start) -> Result<(), InitialisationError> {
        self.plant.state = self.kinematic_state(start)?;
        if self.plant.system.parameters.secondary.drive == Drive::Speed {
            let i = self.plant.system.belt.layout.shaft_speed(Pulley::Secondary);
            self.plant.state.y[i] = self.inputs.secondary.speed_setpoint;
        }
        Ok(())
    }

    /// Starts unloaded; loads and friction come in softly.
    fn start_unloaded(&mut self, start: &Start) -> Result<(), InitialisationError> {
        let unloaded = Start {
            clamping: PerPulley::default(),
            ..*start
        };
        self.start_cold(&unloaded)?;
        self.plant.soft_start = SoftStart { from: self.plant.time };
        Ok(())
    }

    /// Starts unloaded; at a standstill the belt has come to hang.
    fn start_slack(&mut self, start: &Start) -> Result<StartState, InitialisationError> {
        self.start_unloaded(start)?;
        if start.primary_speed.abs() <= STANDSTILL && self.plant.let_hang().is_err() {
            self.start_unloaded(start)?;
        }
        Ok(StartState::Unloaded)
    }

    /// Starts in the state of another ring.
    fn start_on(&mut self, ring: Arc<dyn BeltRing>, start: &Start) -> Result<StartState, InitialisationError> {
        let parameters = &self.plant.system.parameters;
        ring.check(parameters)?;
        let mut other = Plant::new(parameters, ring);
        let mut search = StartSearch {
            plant: &mut other,
            messages: self.messages,
            inputs: self.inputs,
        };
        let found = search.find_state(self.plant.time, start)?;
        self.plant.soft_start = other.soft_start;
        self.plant.start_work = other.start_work;
        let belt = &self.plant.system.belt;
        self.plant.state = belt.ring.start_from(belt, &other.system.belt, &other.state);
        Ok(found)
    }

    fn steady_task(&self, torque_share: f64) -> SteadyTask {
        let (p, inputs) = (&self.plant.system.parameters, self.inputs);
        let own = inputs.secondary.torque * torque_share;
        let primary = inputs.primary.torque * torque_share;
        let (of_secondary, of_primary) = match (p.secondary.drive, p.primary.drive) {
            (Drive::Speed, Drive::Speed) => (ShaftMode::Fixed, ShaftMode::Fixed),
            (Drive::Speed, Drive::Torque) => (ShaftMode::Fixed, ShaftMode::Torque(primary)),
            (Drive::Torque, Drive::Speed) => (ShaftMode::Torque(own), ShaftMode::Fixed),
            (Drive::Torque, Drive::Torque) => (ShaftMode::Balanced { own, primary }, ShaftMode::Fixed),
        };
        let reaction = if p.secondary.axial == Axial::Held && p.primary.axial == Axial::Force {
            Pulley::Secondary
        } else {
            Pulley::Primary
        };
        SteadyTask {
            ratio: p.initial.ratio,
            reaction,
            clamping: PerPulley::from_fn(|pulley| inputs.pulley(pulley).force(&p.pulley(pulley).cylinder)),
            shaft: PerPulley {
                secondary: of_secondary,
                primary: of_primary,
            },
            slip: self.slip_guess(torque_share),
            warm: false,
        }
    }

    /// Slip in the direction of the power, in proportion to the torque.
    fn slip_guess(&self, torque_share: f64) -> f64 {
        let direction = self
            .plant
            .system
            .belt
            .shaft_speeds(self.plant.state.view())
            .primary
            .signum();
        SLIP_AT_CAPACITY * direction * (torque_share * self.of_full_slip()).clamp(-1.0, 1.0)
    }

    /// The torque at the primary pulley as a share of about what the secondary clamping force carries in full slip.
    fn of_full_slip(&self) -> f64 {
        let (p, inputs) = (&self.plant.system.parameters, self.inputs);
        let torque = match p.primary.drive {
            Drive::Torque => inputs.primary.torque,
            Drive::Speed => -inputs.secondary.torque / p.initial.ratio,
        };
        let speed = self.plant.system.belt.shaft_speeds(self.plant.state.view()).primary;
        let (force, radius) = (
            p.closing_forces(inputs, [p.initial.ratio, speed]).secondary,
            USUAL_RADIUS * p.geometry.center_distance,
        );
        torque / full_slip_torque(&p.friction, self.plant.system.belt.law.wedge[1], force, radius).max(1.0e-6)
    }

    /// Solves for the steady state of the parameters, or for the nearest one; returns which it is, or why there is none.
    fn solve_steady(&mut self) -> Result<StartState, NoSteadyState> {
        let mut newton = Newton::new(&self.plant.system);
        newton.bound = WorkBound {
            left: STEADY_WORK,
            jacobian: [JACOBIAN_WORK, 0.0],
            overdraft: f64::INFINITY,
            ..WorkBound::NONE
        };
        let found = self.solve_within(&mut newton);
        self.plant.start_work += newton.counts;
        found
    }

    /// [`StartSearch::solve_steady`] within the work of `newton`.
    fn solve_within(&mut self, newton: &mut Newton) -> Result<StartState, NoSteadyState> {
        let task = self.steady_task(1.0);
        let clamped = task.reaction.other();
        let speed = self.plant.system.belt.shaft_speeds(self.plant.state.view()).primary;
        let (parameters, at) = (&self.plant.system.parameters, [task.ratio, speed]);
        let force = parameters.closing_forces(self.inputs, at)[clamped];
        if force < NO_FORCE {
            return Err(NoSteadyState::Unclamped(
                clamped,
                parameters.name_of_closing(clamped),
                force,
            ));
        }
        if let Some(why) = excessive_speed(parameters, self.inputs, at) {
            return Err(NoSteadyState::TooFast(why));
        }
        let demand = Demand::new(parameters, self.inputs, clamped, at);
        let found = match self.carry(newton, demand)? {
            1.0 => StartState::Steady,
            share => {
                self.warn_of_reduced_torque(share);
                StartState::ReducedTorque
            }
        };
        let p = &self.plant.system.parameters;
        let free = p.primary.axial == Axial::Force && p.secondary.axial == Axial::Force;
        let found = if p.initial.equilibrium && free {
            self.balance_forces(newton, found)
        } else {
            found
        };
        if free {
            let Plant { system, state, .. } = &*self.plant;
            let axial = BeltDiagnostics::of(system, state.view()).sums.axial.primary;
            let closing = task.clamping.primary + system.pulleys().push(Pulley::Primary, state.view());
            self.log(
                false,
                format!(
                    "steady start: primary clamping force less axial belt force is {:.1} N",
                    closing - axial
                ),
            );
        }
        Ok(found)
    }

    /// Starts unloaded, with a warning that has the reason `why`.
    fn start_without_steady_state(
        &mut self,
        why: &NoSteadyState,
        start: &Start,
    ) -> Result<StartState, InitialisationError> {
        self.log(
            true,
            format!("{why}: the run starts unloaded and the loads ramp in over {LOAD_RAMP} s"),
        );
        self.start_unloaded(start)?;
        Ok(StartState::NotFound)
    }

    /// Warns that the run starts with this `share` of the given torques.
    fn warn_of_reduced_torque(&mut self, share: f64) {
        let why = if self.of_full_slip().abs() > CARRIED_AT_LEAST {
            " (beyond the capacity of the clamping forces)"
        } else {
            " was found"
        };
        self.log(
            true,
            format!(
                "no steady state at the given torques{why}: the run starts from the steady state at {:.0} % of them",
                100.0 * share
            ),
        );
    }

    /// Solves for the steady state at the given torques, or at nearly the largest share of them that has one: torque
    /// beyond capacity has none, and isn't tried. The share.
    fn carry(&mut self, newton: &mut Newton, demand: Option<Demand>) -> Result<f64, NoSteadyState> {
        let cold = self.plant.state.clone();
        let (mut share, mut beyond) = (1.0, 1.0);
        loop {
            let task = self.steady_task(share);
            if let Some(demand) = demand.filter(|demand| demand.is_beyond(share)) {
                if share <= LEAST_SHARE {
                    return Err(NoSteadyState::Beyond(demand));
                }
            } else {
                match self.solve(newton, &task, STEADY_SOLVES) {
                    // Beyond capacity a pulley that slips for ever may be steady too.
                    Ok(_) if share == 1.0 || share <= LEAST_SHARE || !self.slips() => break,
                    Err(report) if share <= LEAST_SHARE || task.shaft == Boundary::HELD.shaft => {
                        return Err(NoSteadyState::NotFound(report, demand));
                    }
                    _ => {}
                }
                self.plant.state.clone_from(&cold);
            }
            (beyond, share) = (share, NEXT_SHARE * share);
        }
        while beyond > CLOSE_SHARE * share {
            let middle = (share * beyond).sqrt();
            let task = SteadyTask {
                warm: true,
                ..self.steady_task(middle)
            };
            let carried = self.plant.state.clone();
            let is_beyond = demand.is_some_and(|demand| demand.is_beyond(middle));
            if !is_beyond && self.solve(newton, &task, STEADY_SOLVES / 4).is_ok() && !self.slips() {
                share = middle;
            } else {
                beyond = middle;
                self.plant.state = carried;
            }
        }
        Ok(share)
    }

    /// Solves a task from the present state, in place.
    fn solve(&mut self, newton: &mut Newton, task: &SteadyTask, max_solves: usize) -> Result<Settled, Settled> {
        let Plant { system, state, .. } = &mut *self.plant;
        solve::solve(system, newton, state, task, max_solves)
    }

    /// Whether the belt slips through, from the state alone.
    fn slips(&self) -> bool {
        let view = self.plant.state.view();
        macro_slip(
            &self.plant.system,
            view,
            &BeltDiagnostics::of(&self.plant.system, view).sums,
            false,
        )
    }

    /// Solves for the ratio too at which the clamping forces balance. `found` is the state that the search starts from.
    fn balance_forces(&mut self, newton: &mut Newton, found: StartState) -> StartState {
        let task = self.steady_task(1.0);
        let Plant { system, state, .. } = &*self.plant;
        let holding = solve::reaction(system, state.view(), Pulley::Primary)
            + system.pulleys().push(Pulley::Primary, state.view());
        let at_ratio = self.plant.state.clone();
        let range = self.plant.system.parameters.ratio_range();
        match solve_equilibrium(&mut self.plant.system, newton, &mut self.plant.state, &task, range) {
            Ok(Equilibrium { ratio, at_stop: true }) => {
                self.log(
                    true,
                    format!(
                        "the clamping forces drive the variator to an end stop: the run starts at the ratio {ratio:.4}"
                    ),
                );
                StartState::Steady
            }
            Ok(Equilibrium { ratio, .. }) => {
                self.log(
                    false,
                    format!("equilibrium of the clamping forces at the ratio {ratio:.6}"),
                );
                StartState::Steady
            }
            Err(_) => {
                self.plant.state = at_ratio;
                self.log(
                    true,
                    format!(
                        "no equilibrium of the two clamping forces was found: the run starts from the steady state at the \
                         initial ratio, where the primary force would have to be {holding:.1} N"
                    ),
                );
                if found == StartState::Steady {
                    StartState::NoEquilibrium
                } else {
                    found
                }
            }
        }
    }
}

/// Speed of the primary pulley of the belt that creeps into a standstill, rad/s: forward unless the given speed is negative.
fn creep_speed(start: &Start) -> f64 {
    CREEP_SPEED.copysign(start.primary_speed)
}
