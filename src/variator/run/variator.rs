//! A run of a variator: build from parameters, initialise, advance, read.

use crate::pulley::PerPulley;
use crate::solver::State;
use crate::solver::newton::Counts;
use crate::solver::sdirk::Sdirk;
use crate::tape::Tape;
use crate::variator::belt::ring::BeltRing;
use crate::variator::pulleys::loads::{Boundary, LoadRates, ShaftMode, SheaveMode};
use crate::variator::run::course::Held;
use crate::variator::run::pace::Pace;
use crate::variator::run::real_time::RealTime;
use crate::variator::run::soft_start::SoftStart;
#[cfg(doc)]
use crate::variator::settings::parameters::Solver;
use crate::variator::settings::parameters::{Axial, Drive, Mode, Parameters};
use crate::variator::settings::signals::{Inputs, Outputs, Profile, PulleyInputs, Readings, StartState, Work};
use crate::variator::settings::validation::ParameterError;
use crate::variator::survey::belt_survey::Survey;
use crate::variator::survey::ledger::Ledger;
use crate::variator::survey::observe::{Context, Observer, macro_slip};
use crate::variator::system::VariatorSystem;
use std::sync::Arc;

/// First step from a kinematic state, s.
const COLD_STEP: f64 = 1.0e-6;

/// Time without net compression in a strand after which it is logged again, s: a strand at the limit does not fill the log.
const QUIET: f64 = 1.0;

/// Time after which a change between gripping and slipping through is logged again, s.
const CHATTER: f64 = 0.1;

/// Half the distance in time over which outputs are differentiated, s: the loads of the flanks are linear over it, and
/// it leaves nine digits of a difference.
const MOMENT: f64 = 1.0e-6;

/// A remark for the user's log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// Whether the user should act on it.
    pub warning: bool,
    /// Text of the remark, one sentence.
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
        /// Cause, as the solver reports it.
        reason: String,
    },
}

/// A variator: parameters, mesh and the whole dynamic state in one place. A clone is a snapshot that continues
/// bit for bit as the original does.
///
/// ```
/// use pushbelt::variator::{Variator, settings::{Inputs, Parameters}};
/// let mut variator = Variator::new(Parameters::default())?;
/// let inputs = Inputs::default();
/// variator.initialise(0.0, &inputs)?;
/// variator.advance(1e-3, &inputs)?;
/// assert!((1.0..1.6).contains(&variator.outputs().thrust_ratio));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Variator {
    pub(super) system: VariatorSystem,
    pub(super) ledger: Ledger,
    pub(super) integrator: Sdirk,
    /// Instead of the integrator, in real time.
    pub(super) real_time: Option<Box<RealTime>>,
    pub(super) state: State,
    pub(super) time: f64,
    pub(super) soft_start: SoftStart,
    pub(super) start_state: StartState,
    pub(super) macro_slip: bool,
    /// Last time at which a strand was in net compression, s.
    pub(super) buckled: f64,
    /// Last time at which the belt began or ceased to slip through, s.
    pub(super) slipped: f64,
    pub(super) initial_energy: f64,
    external_torque: PerPulley<f64>,
    pub(super) work: Work,
    /// Inputs in force, the time at which they were given, and how they change from then on.
    pub(super) held: Held,
    pub(super) pace: Pace,
    observer: Observer,
    readings: Box<Readings>,
    pub(super) stale: bool,
    profile_stale: bool,
    pub(super) messages: Vec<Message>,
}

/// Outputs a moment before and after the present, along the tangent of the state.
#[derive(Debug)]
pub struct Moment {
    /// Outputs a moment before.
    pub before: Box<Outputs>,
    /// Outputs a moment after.
    pub after: Box<Outputs>,
    /// Time between the two, s.
    pub span: f64,
}

/// Newton's tolerance at the default solver tolerance, in units of the Newton scale: tenfold changes no output of the
/// manoeuvre in the fourth digit.
pub(super) const NEWTON_TOLERANCE: f64 = 20.0;

/// How many times wider it is where steps err as much as is tolerated. What an iteration then leaves is some tenth of such an error,
/// as in CVODE (Hindmarsh et al. 2005). Less so at tighter tolerances: who asks for these compares small differences.
const NEWTON_WIDENING: f64 = 60.0;

pub(super) fn integrator(system: &VariatorSystem) -> Sdirk {
    let solver = &system.parameters.solver;
    let mut integrator = Sdirk::new(system, COLD_STEP, solver.max_step);
    let share = solver.tolerance / 1.0e-4;
    integrator.newton_tolerance = (NEWTON_TOLERANCE * share).clamp(0.05, 100.0);
    integrator.newton_widening = NEWTON_WIDENING * share.min(1.0);
    integrator
}

impl Variator {
    /// A variator with these parameters and the ring of [`Parameters::ring_model`], not yet initialised.
    ///
    /// # Errors
    /// The first parameter that is out of its range.
    pub fn new(parameters: Parameters) -> Result<Self, ParameterError> {
        let ring = parameters.ring_of_model();
        Self::with_ring(parameters, ring)
    }

    /// A variator with these parameters and this ring, not yet initialised.
    ///
    /// # Errors
    /// The first parameter that is out of its range or does not fit the ring.
    pub fn with_ring(parameters: Parameters, ring: Arc<dyn BeltRing>) -> Result<Self, ParameterError> {
        parameters.validate()?;
        ring.check(&parameters)?;
        let system = VariatorSystem::with_ring(&parameters, ring);
        let in_real_time = system.parameters.solver.mode == Mode::RealTime;
        Ok(Self {
            integrator: integrator(&system),
            real_time: in_real_time.then(|| Box::new(RealTime::new(&system))),
            state: State::zero(system.belt.layout.len()),
            ledger: Ledger::default(),
            system,
            time: 0.0,
            soft_start: SoftStart::NONE,
            start_state: StartState::Unloaded,
            macro_slip: false,
            buckled: f64::NEG_INFINITY,
            slipped: f64::NEG_INFINITY,
            initial_energy: 0.0,
            external_torque: PerPulley::default(),
            work: Work::default(),
            held: Held::constant(0.0, &Inputs::default()),
            pace: Pace::default(),
            observer: Observer::default(),
            readings: Box::default(),
            stale: true,
            profile_stale: true,
            messages: Vec::new(),
        })
    }

    pub(super) fn log(&mut self, warning: bool, text: String) {
        self.messages.push(Message { warning, text });
    }

    /// Sets the friction velocity of the present time.
    pub(super) fn soften(&mut self) {
        let sharp = self.system.parameters.friction.velocity;
        let velocity = self.soft_start.friction_velocity(self.time, sharp);
        if self.system.friction_velocity != velocity {
            self.system.friction_velocity = velocity;
            // All kept derivatives are of the same law, so a stored state holds one law only.
            self.system.forget_derivatives();
        }
    }

    /// Begins anew from the present state: sharp friction, a new integrator, no kept derivatives.
    pub(super) fn forget_history(&mut self) {
        self.soft_start = SoftStart::NONE;
        self.soften();
        self.integrator = integrator(&self.system);
        self.system.forget_derivatives();
    }

    /// Sets the boundary conditions that follow from the inputs, and friction.
    pub(super) fn apply(&mut self) {
        self.soften();
        let share = self.soft_start.load_share(self.time);
        let p = &self.system.parameters;
        let Held { from, inputs, rates } = &self.held;
        let shaft = |drive: Drive, input: &PulleyInputs| match drive {
            Drive::Torque => ShaftMode::Torque(share * input.torque),
            Drive::Speed => ShaftMode::Setpoint(input.speed_setpoint),
        };
        let sheave = |axial: Axial, input: &PulleyInputs| match axial {
            Axial::Force => SheaveMode::Force(share * input.clamping_force),
            Axial::Held => SheaveMode::Held,
        };
        let shaft_rate = |drive: Drive, rate: &PulleyInputs| match drive {
            Drive::Torque => share * rate.torque,
            Drive::Speed => rate.speed_setpoint,
        };
        let boundary = Boundary {
            sheave: PerPulley::from_fn(|j| sheave(p.pulley(j).axial, inputs.pulley(j))),
            shaft: PerPulley::from_fn(|j| shaft(p.pulley(j).drive, inputs.pulley(j))),
        };
        let rates = LoadRates {
            force: PerPulley::from_fn(|j| share * rates.pulley(j).clamping_force),
            shaft: PerPulley::from_fn(|j| shaft_rate(p.pulley(j).drive, rates.pulley(j))),
        };
        self.system
            .change_loads(*from, boundary, rates, self.time, &mut self.state.y_dot);
    }

    /// Records the external torques under the present loads.
    pub(super) fn hold_external(&mut self) {
        let torques = self.ledger.last.sums.shaft_torque;
        let boundary = self.system.loads.at(self.time);
        let pulleys = &self.system.pulleys;
        self.external_torque = pulleys.external_torques(&boundary, self.state.view(), torques);
    }

    /// Advances to time `to` with inputs that are held, after the ramp of [`Solver::input_ramp`].
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
        let mut way = self.set_out(to, inputs, rates)?;
        while !way.is_over() {
            self.step_along(&mut way)?;
        }
        self.arrive(&way);
        Ok(())
    }

    /// Logs when the belt begins to slip through, and when it grips again.
    pub(super) fn report_slip(&mut self) {
        let to = self.time;
        let sums = &self.ledger.last.sums;
        let slips = macro_slip(&self.system, self.state.view(), sums, self.macro_slip);
        if slips != self.macro_slip {
            self.macro_slip = slips;
            if to - self.slipped > CHATTER {
                let what = if slips {
                    "begins to slip through (macro-slip)"
                } else {
                    "grips again"
                };
                self.log(false, format!("at {to} s the belt {what}"));
            }
            self.slipped = to;
        }
    }

    /// Warns of a strand whose net force is compression.
    pub(super) fn report_buckling(&mut self) {
        let to = self.time;
        let force = self.ledger.last.sums.strand_force;
        if force < 0.0 {
            if to - self.buckled > QUIET {
                self.log(
                    true,
                    format!(
                        "at {to} s the net force in a strand is {force:.0} N: a real push strand would buckle (said again only \
                         after {QUIET} s without)"
                    ),
                );
            }
            self.buckled = to;
        }
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
            let boundary = self.system.loads.at(self.time + after);
            let survey = Survey::of(&self.system, state.view());
            let torques = survey.sums.shaft_torque;
            let context = self.context(self.system.pulleys.external_torques(&boundary, state.view(), torques));
            let mut outputs = Box::<Outputs>::default();
            self.observer
                .observe(&self.system, state.view(), &survey, &context, &mut outputs);
            outputs
        });
        Moment {
            before,
            after,
            span: 2.0 * MOMENT,
        }
    }

    /// Writes to a tape, or reads from it, all that later steps and outputs depend on. To read, build a variator from the same
    /// parameters.
    pub fn serialize(&mut self, tape: &mut Tape<'_>) {
        if tape.is_reading() {
            // For the kinds of boundary conditions: the loads themselves are on the tape.
            self.apply();
        }
        self.state.serialize(tape);
        self.integrator.serialize(tape);
        if let Some(real_time) = &mut self.real_time {
            real_time.serialize(tape);
        }
        self.system.serialize(tape);
        let ledger = &mut self.ledger;
        let [torque_s, torque_p] = self.external_torque.each_mut();
        for value in [
            &mut self.time,
            &mut self.soft_start.from,
            &mut self.system.friction_velocity,
            &mut self.buckled,
            &mut self.slipped,
            &mut self.initial_energy,
            &mut ledger.supplied,
            &mut ledger.lost,
            &mut ledger.moved,
            torque_s,
            torque_p,
            &mut self.system.parameters.friction.pulley,
            &mut self.system.parameters.friction.ring,
        ] {
            tape.real(value);
        }
        // Where the next ramp starts.
        let mut present = self.held.at(self.time);
        for value in present.each_mut() {
            tape.real(value);
        }
        if tape.is_reading() {
            self.held = Held::constant(self.time, &present);
        }
        let Work {
            steps,
            jacobians,
            residuals,
            defect,
            behind,
            rollbacks,
        } = &mut self.work;
        for count in [steps, jacobians, residuals, rollbacks] {
            tape.integer(count);
        }
        self.pace.serialize(tape);
        tape.real(defect);
        tape.real(behind);
        tape.flag(&mut self.macro_slip);
        let mut start = self.start_state as i32;
        tape.integer(&mut start);
        match StartState::from_number(start) {
            Some(start) => self.start_state = start,
            None => tape.reject(),
        }
        if tape.is_reading() {
            self.system.restore_derivatives();
            self.ledger.last.update(&self.system, self.state.view());
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
        &self.system.parameters
    }

    /// The assembled system, for reports and tests.
    #[must_use]
    pub fn system(&self) -> &VariatorSystem {
        &self.system
    }

    /// The energy balance, and the belt at the end of the last step, for reports and tests.
    #[must_use]
    pub fn ledger(&self) -> &Ledger {
        &self.ledger
    }

    /// The dynamic state, for reports and tests.
    #[must_use]
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Work done since the start of the run.
    #[must_use]
    pub fn counts(&self) -> Counts {
        let mut counts = self.integrator.newton.counts;
        if let Some(real_time) = &self.real_time {
            counts += real_time.counts();
        }
        counts
    }

    /// Changes the two tunable friction coefficients.
    ///
    /// # Errors
    /// A coefficient out of its range; nothing was changed.
    pub fn set_friction(&mut self, pulley: f64, ring: f64) -> Result<(), ParameterError> {
        let mut changed = self.system.parameters.clone();
        changed.friction.pulley = pulley;
        changed.friction.ring = ring;
        changed.validate_friction()?;
        self.system.parameters.friction = changed.friction;
        self.ledger.last.update(&self.system, self.state.view());
        self.integrator.newton.forget_rate();
        // All kept derivatives are of the same law, see `soften`.
        self.system.forget_derivatives();
        self.stale = true;
        Ok(())
    }

    /// Values that outputs need beside the state.
    fn context(&self, external_torque: PerPulley<f64>) -> Context {
        Context {
            external_torque,
            macro_slip: self.macro_slip,
            supplied: self.ledger.supplied,
            lost: self.ledger.lost,
            initial_energy: self.initial_energy,
            start_state: self.start_state,
            work: self.work,
        }
    }

    /// Outputs at the present time.
    pub fn outputs(&mut self) -> &Outputs {
        &self.readings(false).outputs
    }

    /// Fields along the belt at the present time.
    pub fn profile(&mut self) -> &Profile {
        &self.readings(true).profile
    }

    /// Outputs at the present time, and if `profile` is set the profile, whose evaluation costs as much as all of them.
    pub(crate) fn readings(&mut self, profile: bool) -> &Readings {
        let survey = &self.ledger.last;
        if self.stale {
            let context = self.context(self.external_torque);
            let outputs = &mut self.readings.outputs;
            self.observer
                .observe(&self.system, self.state.view(), survey, &context, outputs);
            (self.stale, self.profile_stale) = (false, true);
        }
        if profile && self.profile_stale {
            let profile = &mut self.readings.profile;
            self.observer
                .profile(&self.system.belt, self.state.view(), survey, profile);
            self.profile_stale = false;
        }
        &self.readings
    }

    /// Returns the messages since the last call, and removes them.
    pub fn take_messages(&mut self) -> Vec<Message> {
        std::mem::take(&mut self.messages)
    }
}
