//! The variator as a user holds it: build from parameters, initialise, advance, read.

use super::boundary::{Boundary, LoadRates, SheaveMode, SpeedMode};
use super::layout::Global;
use super::mesh::{P, S};
use super::observe::{Context, Observer, macro_slip};
use super::parameters::{Axial, Drive, Friction, Parameters, RingModel};
use super::signals::{Inputs, Outputs, PulleyInputs};
use super::soft_start::{LOAD_RAMP, SoftStart};
use super::start::{Start, kinematic_state};
use super::steady::{self, SteadyTask};
use super::system::VariatorSystem;
use super::validation::ParameterError;
use crate::solver::State;
use crate::solver::newton::{Counts, Newton};
use crate::solver::sdirk::Sdirk;
use crate::tape::Tape;

/// First step from a kinematic state, s.
const COLD_STEP: f64 = 1.0e-6;

/// First step from a steady state, s.
const WARM_STEP: f64 = 1.0e-4;

/// Shortest time to advance by, s: rates over less are rounding errors.
const SHORTEST_STEP: f64 = 1.0e-9;

/// Time without net compression in a strand after which it is told of again, s: a strand at the limit does not fill the log.
const QUIET: f64 = 1.0;

/// Half the distance in time over which outputs are differentiated, s: the loads of the flanks are linear over it, and
/// it leaves nine digits of a difference.
const MOMENT: f64 = 1.0e-6;

/// Most Newton solves for a steady state.
const STEADY_SOLVES: usize = 400;

/// Speed of the primary pulley below which there is nothing steady to solve for, rad/s.
const STANDSTILL: f64 = 1.0e-3;

/// A remark for the user's log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// Whether the user should act on it.
    pub warning: bool,
    /// One sentence.
    pub text: String,
}

/// Why a variator could not be initialised.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum InitialisationError {
    /// An input is out of its range.
    #[error(transparent)]
    Input(#[from] ParameterError),
    /// No state was found to start from.
    #[error("the initial state could not be found: {0}")]
    NoState(String),
}

/// Why a step could not be done. The state stays at the last successful time.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StepError {
    /// An input is out of its range; nothing was changed.
    #[error(transparent)]
    Input(#[from] ParameterError),
    /// The step size fell below the smallest useful one.
    #[error("the step from {from} s stalled at {reached} s: {reason}")]
    Stalled {
        /// Start of the step, s.
        from: f64,
        /// Last successful time, s.
        reached: f64,
        /// What the solver saw.
        reason: String,
    },
}

/// A variator: parameters, mesh and the whole dynamic state in one place. A clone is a snapshot that continues
/// bit for bit as the original does.
///
/// ```
/// use pushbelt::variator::{instance::Variator, parameters::Parameters, signals::Inputs};
/// let mut variator = Variator::new(Parameters::default())?;
/// let inputs = Inputs::default();
/// variator.initialise(0.0, &inputs)?;
/// variator.advance(1e-3, &inputs)?;
/// assert!((1.0..1.6).contains(&variator.outputs().thrust_ratio));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Variator {
    parameters: Parameters,
    system: VariatorSystem,
    integrator: Sdirk,
    state: State,
    time: f64,
    soft_start: SoftStart,
    macro_slip: bool,
    /// Time at which a strand was last seen in net compression, s.
    buckled: f64,
    initial_energy: f64,
    external_torque: [f64; 2],
    /// Inputs in force, the time at which they were given, and how they change from then on.
    held: Held,
    observer: Observer,
    outputs: Box<Outputs>,
    stale: bool,
    messages: Vec<Message>,
}

/// Inputs from a point of time on.
#[derive(Clone, Copy, Debug)]
struct Held {
    from: f64,
    inputs: Inputs,
    rates: Inputs,
}

/// Outputs a moment before and after the present, along the tangent of the state.
#[derive(Debug)]
pub struct Moment {
    /// A moment before.
    pub before: Box<Outputs>,
    /// A moment after.
    pub after: Box<Outputs>,
    /// Time between the two, s.
    pub span: f64,
}

/// Newton's tolerance at the default solver tolerance, in units of the Newton scale: tenfold changes no output of the
/// manoeuvre in the fourth digit.
const NEWTON_TOLERANCE: f64 = 20.0;

fn integrator(system: &VariatorSystem, parameters: &Parameters) -> Sdirk {
    let solver = &parameters.solver;
    let mut integrator = Sdirk::new(system, COLD_STEP, solver.max_step);
    integrator.newton_tolerance = (NEWTON_TOLERANCE * solver.tolerance / 1.0e-4).clamp(0.05, 100.0);
    integrator
}

impl Variator {
    /// Builds mesh and workspace.
    ///
    /// # Errors
    /// The first parameter that is out of its range.
    pub fn new(parameters: Parameters) -> Result<Self, ParameterError> {
        parameters.validate()?;
        let system = VariatorSystem::new(&parameters);
        let n = system.layout.len();
        let integrator = integrator(&system, &parameters);
        Ok(Self {
            parameters,
            integrator,
            state: State::zero(n),
            system,
            time: 0.0,
            soft_start: SoftStart::NONE,
            macro_slip: false,
            buckled: f64::NEG_INFINITY,
            initial_energy: 0.0,
            external_torque: [0.0; 2],
            held: Held {
                from: 0.0,
                inputs: Inputs::default(),
                rates: Inputs::ZERO,
            },
            observer: Observer::default(),
            outputs: Box::default(),
            stale: true,
            messages: Vec::new(),
        })
    }

    fn say(&mut self, warning: bool, text: String) {
        self.messages.push(Message { warning, text });
    }

    /// Finds the state to start from at `time`.
    ///
    /// What can't be solved starts from the nearest state, with a warning that says what and why.
    ///
    /// # Errors
    /// Inputs out of range, or no state found.
    pub fn initialise(&mut self, time: f64, inputs: &Inputs) -> Result<(), InitialisationError> {
        inputs.validate()?;
        let parameters = self.parameters.clone();
        if parameters.primary.axial == Axial::Held && parameters.secondary.axial == Axial::Held {
            self.say(
                true,
                "both sheaves are held: the belt's tension follows from the start alone, clamping forces are ignored"
                    .into(),
            );
        }
        let primary_speed = match parameters.primary.drive {
            Drive::Speed => inputs.primary.speed_setpoint,
            Drive::Torque => parameters.initial.primary_speed,
        };
        let start = Start {
            ratio: parameters.initial.ratio,
            primary_speed,
            clamping: [inputs.secondary.clamping_force, inputs.primary.clamping_force],
        };
        let cold = |system: &VariatorSystem, start: &Start| {
            kinematic_state(system, start).map_err(|e| InitialisationError::NoState(e.to_string()))
        };
        self.time = time;
        self.buckled = f64::NEG_INFINITY;
        self.soft_start = SoftStart::NONE;
        self.soften();
        self.integrator = integrator(&self.system, &parameters);
        self.system.forget_derivatives();
        let steady = parameters.initial.steady && primary_speed.abs() > STANDSTILL;
        if parameters.ring_model.travels() {
            self.lay_on_ale(inputs)?;
        } else if steady {
            self.state = cold(&self.system, &start)?;
            self.solve_steady(inputs, &start)?;
        } else {
            let unloaded = Start {
                clamping: [0.0; 2],
                ..start
            };
            self.state = cold(&self.system, &unloaded)?;
            self.soft_start = SoftStart { from: time };
        }
        if parameters.secondary.drive == Drive::Speed {
            let i = self.system.layout.global(Global::Speed, S);
            self.state.y[i] = inputs.secondary.speed_setpoint;
        }
        self.state.y_dot.fill(0.0);
        self.held = Held {
            from: time,
            inputs: *inputs,
            rates: Inputs::ZERO,
        };
        self.apply();
        self.system.open_ledger(self.state.view());
        self.macro_slip = macro_slip(&self.system, self.state.view(), &self.system.ledger.last.sums, false);
        if self.macro_slip {
            self.say(
                true,
                "the belt slips through (macro-slip) in the state that the run starts from".into(),
            );
        }
        self.hold_external();
        self.initial_energy =
            self.system.belt_energy(&self.system.ledger.last) + self.system.pulley_energy(self.state.view());
        self.stale = true;
        Ok(())
    }

    /// Starts as `ALE` would: a ring that travels is laid on it.
    fn lay_on_ale(&mut self, inputs: &Inputs) -> Result<(), InitialisationError> {
        let mut ale = Self::new(Parameters {
            ring_model: RingModel::Ale,
            ..self.parameters.clone()
        })?;
        ale.initialise(self.time, inputs)?;
        self.messages.append(&mut ale.messages);
        self.soft_start = ale.soft_start;
        self.state = self.system.lay_on(&ale.system, &ale.state);
        Ok(())
    }

    fn steady_task(&self, inputs: &Inputs, torque_share: f64) -> SteadyTask {
        let p = &self.parameters;
        let torques = [
            inputs.secondary.torque * torque_share,
            inputs.primary.torque * torque_share,
        ];
        let speed = match (p.secondary.drive, p.primary.drive) {
            (Drive::Speed, Drive::Speed) => [SpeedMode::Fixed; 2],
            (Drive::Speed, Drive::Torque) => [SpeedMode::Fixed, SpeedMode::Torque(torques[P])],
            (Drive::Torque, Drive::Speed) => [SpeedMode::Torque(torques[S]), SpeedMode::Fixed],
            (Drive::Torque, Drive::Torque) => [SpeedMode::Balanced(torques[S], torques[P]), SpeedMode::Fixed],
        };
        let reaction = if p.secondary.axial == Axial::Held && p.primary.axial == Axial::Force {
            S
        } else {
            P
        };
        SteadyTask {
            ratio: p.initial.ratio,
            reaction,
            clamping: [inputs.secondary.clamping_force, inputs.primary.clamping_force],
            speed,
            slip: self.slip_guess(inputs, torque_share),
            warm: false,
        }
    }

    /// One and a half percent at capacity, in the direction of the power.
    fn slip_guess(&self, inputs: &Inputs, torque_share: f64) -> f64 {
        let p = &self.parameters;
        let torque = match p.primary.drive {
            Drive::Torque => inputs.primary.torque,
            Drive::Speed => -inputs.secondary.torque / p.initial.ratio,
        };
        let radius = 0.3 * p.geometry.center_distance;
        let capacity = 2.0 * p.friction.pulley.max(1.0e-3) * inputs.secondary.clamping_force.max(1.0) * radius;
        let direction = if p.initial.primary_speed < 0.0 { -1.0 } else { 1.0 };
        0.015 * direction * (torque_share * torque / capacity).clamp(-1.0, 1.0)
    }

    fn solve_steady(&mut self, inputs: &Inputs, start: &Start) -> Result<(), InitialisationError> {
        let mut newton = Newton::new(&self.system);
        let task = self.steady_task(inputs, 1.0);
        let p = &self.parameters;
        let free = p.primary.axial == Axial::Force && p.secondary.axial == Axial::Force;
        let equilibrium = p.initial.equilibrium && free;
        let cold = self.state.clone();
        let mut outcome = steady::solve(&mut self.system, &mut newton, &mut self.state, &task, STEADY_SOLVES);
        if outcome.is_err() {
            // Torque beyond capacity has no steady state: the largest share of it that has one is the nearest.
            let mut share = 1.0;
            while outcome.is_err() && share > 0.05 {
                share *= 0.7;
                self.state = cold.clone();
                let mut reduced = self.steady_task(inputs, share);
                reduced.clamping = task.clamping;
                outcome = steady::solve(&mut self.system, &mut newton, &mut self.state, &reduced, STEADY_SOLVES);
            }
            match outcome {
                Ok(_) => self.say(
                    true,
                    format!(
                        "no steady state at the given torques (beyond the capacity of the clamping forces): the run starts \
                         from the steady state at {:.0} % of them",
                        100.0 * share
                    ),
                ),
                Err(report) => {
                    self.state = cold;
                    self.soft_start = SoftStart { from: self.time };
                    self.state = kinematic_state(&self.system, &Start { clamping: [0.0; 2], ..*start })
                        .map_err(|e| InitialisationError::NoState(e.to_string()))?;
                    self.say(
                        true,
                        format!(
                            "no steady state was found (pseudo-time step {:.1e} s after {} solves): the run starts unloaded and \
                             the loads ramp in over {LOAD_RAMP} s",
                            report.step, report.solves
                        ),
                    );
                    return Ok(());
                }
            }
        }
        self.integrator.step = WARM_STEP;
        let reaction = self
            .system
            .holding_force(P, self.state.view(), self.system.belt_load(P).0);
        if equilibrium {
            let at_ratio = self.state.clone();
            let range = self.ratio_range();
            match steady::solve_equilibrium(&mut self.system, &mut newton, &mut self.state, &task, range) {
                Ok(ratio) if ratio <= range.0 * 1.0001 || ratio >= range.1 * 0.9999 => self.say(
                    true,
                    format!(
                        "the clamping forces drive the variator to an end stop: the run starts at the ratio {ratio:.4}"
                    ),
                ),
                Ok(ratio) => self.say(
                    false,
                    format!("equilibrium of the clamping forces at the ratio {ratio:.6}"),
                ),
                Err(_) => {
                    self.state = at_ratio;
                    self.say(
                        true,
                        format!(
                            "no equilibrium of the two clamping forces was found: the run starts from the steady state at the \
                             initial ratio, where the primary force would have to be {reaction:.1} N"
                        ),
                    );
                }
            }
        }
        if free {
            self.say(
                false,
                format!(
                    "steady start: primary clamping force less axial belt force is {:.1} N",
                    inputs.primary.clamping_force - self.system.surveyed(self.state.view()).sums.axial[P]
                ),
            );
        }
        Ok(())
    }

    /// Geometric ratios between the end stops.
    fn ratio_range(&self) -> (f64, f64) {
        let p = &self.parameters;
        let e = p.belt.pitch_offset;
        let fits = |ratio: f64| {
            self.system.curve.radii(ratio).is_ok_and(|(r_p, r_s)| {
                let inside = |radius: f64, pulley: &super::parameters::Pulley| {
                    (pulley.min_radius..=pulley.max_radius).contains(&(radius - e))
                };
                inside(r_p, &p.primary) && inside(r_s, &p.secondary)
            })
        };
        let edge = |mut inside: f64, mut outside: f64| {
            for _ in 0..50 {
                let middle = (inside * outside).sqrt();
                if fits(middle) {
                    inside = middle;
                } else {
                    outside = middle;
                }
            }
            inside
        };
        (edge(p.initial.ratio, 0.05), edge(p.initial.ratio, 20.0))
    }

    /// Puts the friction velocity of this time in force.
    fn soften(&mut self) {
        let sharp = self.parameters.friction.velocity;
        let velocity = self.soft_start.friction_velocity(self.time, sharp);
        let in_force = &mut self.system.law.parameters.friction.velocity;
        if *in_force != velocity {
            *in_force = velocity;
            // All that are kept are of the same law, so a stored state needs to know one only.
            self.system.forget_derivatives();
        }
    }

    /// Boundary conditions from the inputs, and friction.
    fn apply(&mut self) {
        self.soften();
        let share = self.soft_start.load_share(self.time);
        let p = &self.parameters;
        let Held { from, inputs, rates } = &self.held;
        let speed = |drive: Drive, input: &PulleyInputs| match drive {
            Drive::Torque => SpeedMode::Torque(share * input.torque),
            Drive::Speed => SpeedMode::Setpoint(input.speed_setpoint),
        };
        let sheave = |axial: Axial, input: &PulleyInputs| match axial {
            Axial::Force => SheaveMode::Force(share * input.clamping_force),
            Axial::Held => SheaveMode::Held,
        };
        let speed_rate = |drive: Drive, rate: &PulleyInputs| match drive {
            Drive::Torque => share * rate.torque,
            Drive::Speed => rate.speed_setpoint,
        };
        let boundary = Boundary {
            sheave: [
                sheave(p.secondary.axial, &inputs.secondary),
                sheave(p.primary.axial, &inputs.primary),
            ],
            speed: [
                speed(p.secondary.drive, &inputs.secondary),
                speed(p.primary.drive, &inputs.primary),
            ],
        };
        let rates = LoadRates {
            force: [
                share * rates.secondary.clamping_force,
                share * rates.primary.clamping_force,
            ],
            speed: [
                speed_rate(p.secondary.drive, &rates.secondary),
                speed_rate(p.primary.drive, &rates.primary),
            ],
        };
        self.system
            .change_loads(*from, boundary, rates, self.time, &mut self.state.y_dot);
    }

    fn hold_external(&mut self) {
        let sums = &self.system.ledger.last.sums;
        self.external_torque = [S, P].map(|j| self.system.external_torque(j, self.state.view(), sums.torque[j]));
    }

    /// Advances to time `to` with constant inputs.
    ///
    /// # Errors
    /// Inputs out of range, or a step that can't be done.
    pub fn advance(&mut self, to: f64, inputs: &Inputs) -> Result<(), StepError> {
        self.advance_along(to, inputs, &Inputs::ZERO)
    }

    /// Advances to time `to` with inputs that change in proportion to time: `inputs` now, with the time derivatives
    /// `rates`. A clamping force that falls ends at zero. Less than a nanosecond is left to the next call.
    ///
    /// # Errors
    /// Inputs out of range, or a step that can't be done.
    pub fn advance_along(&mut self, to: f64, inputs: &Inputs, rates: &Inputs) -> Result<(), StepError> {
        inputs.validate()?;
        if to - self.time < SHORTEST_STEP {
            return Ok(());
        }
        let from = self.time;
        self.held = Held {
            from,
            inputs: *inputs,
            rates: *rates,
        };
        self.stale = true;
        while to - self.time >= SHORTEST_STEP {
            let end = to.min(self.time + self.soft_start.piece(self.time));
            self.apply();
            let outcome = self
                .integrator
                .advance(&mut self.system, &mut self.state, self.time, end);
            if let Err(stalled) = outcome {
                self.time = stalled.time;
                self.system.move_loads(self.time);
                let cause = if stalled.newton {
                    "Newton's method found no solution"
                } else {
                    "the error stayed too large"
                };
                return Err(StepError::Stalled {
                    from,
                    reached: stalled.time,
                    reason: format!("{cause} at a step of {:.1e} s", stalled.step),
                });
            }
            self.time = end;
        }
        self.time = to;
        let sums = self.system.ledger.last.sums;
        self.macro_slip = macro_slip(&self.system, self.state.view(), &sums, self.macro_slip);
        if sums.strand_force < 0.0 {
            if to - self.buckled > QUIET {
                let force = sums.strand_force;
                self.say(
                    true,
                    format!(
                        "at {to} s the net force in a strand is {force:.0} N: a real push strand would buckle (said again only \
                         after {QUIET} s without)"
                    ),
                );
            }
            self.buckled = to;
        }
        self.system.move_loads(to);
        self.external_torque = [S, P].map(|j| self.system.external_torque(j, self.state.view(), sums.torque[j]));
        Ok(())
    }

    /// Outputs on both sides of the present, for their time derivatives: the state moves along y' = ẏ, q' = y, and ẏ as
    /// it did between the stages of the last step. Allocates.
    pub fn moment(&mut self) -> Moment {
        let [before, after] = [-MOMENT, MOMENT].map(|after| {
            let mut state = self.state.clone();
            for i in 0..state.y.len() {
                state.q[i] += after * state.y[i];
                state.y[i] += after * state.y_dot[i];
                state.y_dot[i] += after * self.integrator.slope_rate(i);
            }
            self.system.move_loads(self.time + after);
            let survey = self.system.surveyed(state.view());
            let torque = survey.sums.torque;
            let context = Context {
                external_torque: [S, P].map(|j| self.system.external_torque(j, state.view(), torque[j])),
                macro_slip: self.macro_slip,
                initial_energy: self.initial_energy,
            };
            let mut outputs = Box::<Outputs>::default();
            self.observer
                .observe(&self.system, state.view(), &survey, &context, &mut outputs);
            outputs
        });
        self.system.move_loads(self.time);
        Moment {
            before,
            after,
            span: 2.0 * MOMENT,
        }
    }

    /// Passes by a tape all that later steps and outputs depend on. To read, build a variator from the same parameters.
    pub fn pass(&mut self, tape: &mut Tape<'_>) {
        if tape.is_reading() {
            // For the kinds of boundary conditions: the loads themselves are on the tape.
            self.apply();
        }
        let State { y, y_dot, q } = &mut self.state;
        for values in [y, y_dot, q] {
            tape.reals(values);
        }
        self.integrator.pass(tape);
        self.system.pass_loads(tape);
        self.system.pass_kept(tape);
        let ledger = &mut self.system.ledger;
        let [torque_s, torque_p] = &mut self.external_torque;
        for value in [
            &mut self.time,
            &mut self.soft_start.from,
            &mut self.system.law.parameters.friction.velocity,
            &mut self.buckled,
            &mut self.initial_energy,
            &mut ledger.supplied,
            &mut ledger.lost,
            &mut ledger.moved,
            torque_s,
            torque_p,
            &mut self.parameters.friction.pulley,
            &mut self.parameters.friction.ring,
        ] {
            tape.real(value);
        }
        tape.flag(&mut self.macro_slip);
        if tape.is_reading() {
            self.put_friction();
            self.system.retake_derivatives();
            self.system.take_stock(self.state.view());
            self.stale = true;
        }
    }

    /// Present time, s.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Parameters in force.
    #[must_use]
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// The assembled system, for reports and tests.
    #[must_use]
    pub fn system(&self) -> &VariatorSystem {
        &self.system
    }

    /// The dynamic state, for reports and tests.
    #[must_use]
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Work done since the start.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.integrator.newton.counts
    }

    /// Changes the two tunable friction coefficients.
    ///
    /// # Errors
    /// A coefficient out of its range; nothing was changed.
    pub fn set_friction(&mut self, pulley: f64, ring: f64) -> Result<(), ParameterError> {
        let mut changed = self.parameters.clone();
        changed.friction.pulley = pulley;
        changed.friction.ring = ring;
        changed.validate()?;
        self.parameters = changed;
        self.put_friction();
        self.system.take_stock(self.state.view());
        self.integrator.newton.forget();
        self.system.forget_derivatives();
        self.stale = true;
        Ok(())
    }

    /// Puts the two tunable coefficients in force.
    fn put_friction(&mut self) {
        let Friction { pulley, ring, .. } = self.parameters.friction;
        let in_force = &mut self.system.law.parameters.friction;
        (in_force.pulley, in_force.ring) = (pulley, ring);
    }

    /// Outputs at the present time.
    pub fn outputs(&mut self) -> &Outputs {
        if self.stale {
            let context = Context {
                external_torque: self.external_torque,
                macro_slip: self.macro_slip,
                initial_energy: self.initial_energy,
            };
            let survey = &self.system.ledger.last;
            self.observer
                .observe(&self.system, self.state.view(), survey, &context, &mut self.outputs);
            self.stale = false;
        }
        &self.outputs
    }

    /// Takes the messages that have come up since the last call.
    pub fn take_messages(&mut self) -> Vec<Message> {
        std::mem::take(&mut self.messages)
    }
}
