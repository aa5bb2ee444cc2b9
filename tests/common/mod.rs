//! What the variator's tests share: load cases, steady solutions, fields along the belt, runs with their books.
#![allow(dead_code, reason = "each test program uses its own part")]

use pushbelt::contact;
use pushbelt::solver::State;
use pushbelt::solver::newton::{Counts, Newton};
use pushbelt::variator::boundary::SpeedMode;
use pushbelt::variator::instance::{Message, Variator};
use pushbelt::variator::layout::Global;
use pushbelt::variator::mesh::{P, S};
use pushbelt::variator::observe::{Context, Observer};
use pushbelt::variator::parameters::{Mesh, Parameters, RIGID_TILT_STIFFNESS, RingModel};
use pushbelt::variator::sample::Sample;
use pushbelt::variator::signals::{Inputs, Outputs, PulleyInputs, PulleyOutputs, StartState};
use pushbelt::variator::start::{Start, kinematic_state};
use pushbelt::variator::steady::{self, SteadyTask};
use pushbelt::variator::system::VariatorSystem;

/// 2000 rpm, rad/s.
pub const SPEED: f64 = 209.44;

/// Most solves a steady state may take here.
const MAX_SOLVES: usize = 600;

/// Both levels of detail.
pub const MODELS: [RingModel; 2] = [RingModel::Ale0, RingModel::Ale];

/// Elements on each arc and each strand, in `ALE` two cells in each.
pub fn mesh(arc: i32, strand: i32) -> Mesh {
    Mesh {
        aligned: true,
        primary_arc: arc,
        secondary_arc: arc,
        strand,
        cells_per_element: 2,
    }
}

/// The laboratory variator with one of the ring models.
pub fn variator(model: RingModel) -> Parameters {
    Parameters {
        ring_model: model,
        ..Parameters::default()
    }
}

/// The same on a mesh that is enough for a law and too coarse for a claim about accuracy.
pub fn coarse(model: RingModel) -> Parameters {
    let factor = if model == RingModel::Ale0 { 2 } else { 1 };
    Parameters {
        mesh: mesh(8, 6).refined(factor),
        ..variator(model)
    }
}

/// Sheaves that do not tilt.
pub fn rigid(mut parameters: Parameters) -> Parameters {
    parameters.primary.tilt_stiffness = RIGID_TILT_STIFFNESS;
    parameters.secondary.tilt_stiffness = RIGID_TILT_STIFFNESS;
    parameters
}

/// Torque at which a pulley under its axial force slips tangentially all around, N·m.
pub fn full_slip_torque(parameters: &Parameters, pulley: &PulleyOutputs) -> f64 {
    let cos_beta = parameters.geometry.wedge_angle.cos();
    contact::full_slip_torque(&parameters.friction, cos_beta, pulley.axial_force, pulley.radius)
}

/// `found` is `expected` within a relative bound.
#[track_caller]
pub fn assert_close(found: f64, expected: f64, relative: f64, what: &str) {
    assert!(
        (found / expected - 1.0).abs() <= relative,
        "{what}: {found} against {expected}, off by {:.2e}",
        found / expected - 1.0
    );
}

/// `found` lies within a quarter of `pinned`, up or down.
#[track_caller]
pub fn assert_pinned(found: u64, pinned: u64, what: &str) {
    assert!(
        4 * found >= 3 * pinned && 4 * found <= 5 * pinned,
        "{what}: {found}, pinned at {pinned} ± 25 %: if the change is meant, pin the new count"
    );
}

/// One of the nine cases: 2000 rpm, the ratio held by the primary sheave, the secondary clamped 1.3 times as hard as
/// full tangential slip needs.
#[derive(Clone, Copy, Debug)]
pub struct LoadCase {
    /// Ratio by name.
    pub name: &'static str,
    /// Θ.
    pub theta: f64,
    /// Torque the belt takes from the primary shaft, N·m.
    pub torque: f64,
    /// F_S, N.
    pub clamping: f64,
}

impl LoadCase {
    /// The case of Θ and torque.
    pub fn new(parameters: &Parameters, name: &'static str, theta: f64, torque: f64) -> Self {
        let system = VariatorSystem::new(parameters);
        let (primary, _) = system.curve.radii(ratio(theta)).expect("the belt closes");
        let radius = primary - parameters.belt.pitch_offset;
        let cos_beta = parameters.geometry.wedge_angle.cos();
        let per_force = contact::full_slip_torque(&parameters.friction, cos_beta, 1.0, radius);
        Self {
            name,
            theta,
            torque,
            clamping: (1.3 * torque / per_force).max(6000.0),
        }
    }

    /// Underdrive, medium, overdrive at one torque.
    pub fn three(parameters: &Parameters, torque: f64) -> [Self; 3] {
        [("underdrive", -0.4), ("medium", 0.0), ("overdrive", 0.4)]
            .map(|(name, theta)| Self::new(parameters, name, theta, torque))
    }

    /// What the steady solver is asked for.
    pub fn task(&self) -> SteadyTask {
        SteadyTask {
            speed: [SpeedMode::Transmit(self.torque), SpeedMode::Fixed],
            ..given(ratio(self.theta), P, self.clamping, 0.01)
        }
    }
}

/// i_g of Θ.
pub fn ratio(theta: f64) -> f64 {
    (1.0 - theta) / (1.0 + theta)
}

/// A task at a given ratio and given speeds; `reaction` is the pulley whose sheave holds the ratio.
pub fn given(ratio: f64, reaction: usize, clamping: f64, slip: f64) -> SteadyTask {
    SteadyTask {
        ratio,
        reaction,
        clamping: [clamping; 2],
        speed: [SpeedMode::Fixed; 2],
        slip,
        warm: false,
    }
}

/// A steady state.
#[derive(Clone, Debug)]
pub struct Steady {
    /// The system with its boundary conditions.
    pub system: VariatorSystem,
    /// The state.
    pub state: State,
    /// What it tells.
    pub outputs: Outputs,
    /// What it took.
    pub counts: Counts,
}

/// A station with its cell.
#[derive(Clone, Copy, Debug)]
pub struct At {
    /// Segment: half secondary arc, upper strand, primary arc, lower strand, half secondary arc.
    pub segment: usize,
    /// Ring element.
    pub element: usize,
    /// What is there.
    pub sample: Sample,
}

impl Steady {
    /// Every station around the loop.
    pub fn stations(&self) -> Vec<At> {
        let mesh = &self.system.mesh;
        let survey = self.system.surveyed(self.state.view());
        survey
            .stations(mesh)
            .map(|(cell, sample)| At {
                segment: mesh.elements[cell.element].segment,
                element: cell.element,
                sample,
            })
            .collect()
    }

    /// Sum of supplied powers less losses as a share of the driving power.
    pub fn power_defect(&self) -> f64 {
        let o = &self.outputs;
        let driving = o.primary.power.max(o.secondary.power);
        (o.primary.power + o.secondary.power - o.losses.total()) / driving
    }

    /// Wrap angles α_S, α_P of the belt's own radii, rad. (Θ is the radius at one point of S: a stretched ring is
    /// larger than its reference curve.)
    pub fn wrap(&self) -> [f64; 2] {
        let difference = self.outputs.primary.radius - self.outputs.secondary.radius;
        let half = (difference / self.system.law.parameters.geometry.center_distance).acos();
        [2.0 * half, std::f64::consts::TAU - 2.0 * half]
    }
}

/// The steady state of a task. `speeds` are ω_S and ω_P; a speed that the task leaves free is a first guess.
pub fn steady(parameters: &Parameters, task: &SteadyTask, speeds: [f64; 2]) -> Steady {
    parameters.validate().expect("valid parameters");
    let mut system = VariatorSystem::new(parameters);
    let start = Start {
        ratio: task.ratio,
        primary_speed: speeds[P],
        clamping: task.clamping,
    };
    let mut state = kinematic_state(&system, &start).expect("the belt closes");
    for j in [S, P] {
        state.y[system.layout.global(Global::Speed, j)] = speeds[j];
    }
    let mut newton = Newton::new(&system);
    if let Err(report) = steady::solve(&mut system, &mut newton, &mut state, task, MAX_SOLVES) {
        panic!("no steady state of {task:?} at {speeds:?} rad/s: {report:?}");
    }
    let context = Context {
        external_torque: [0.0; 2],
        macro_slip: false,
        initial_energy: 0.0,
        start_state: StartState::Steady,
    };
    let mut outputs = Outputs::default();
    let survey = system.surveyed(state.view());
    Observer::default().observe(&system, state.view(), &survey, &context, &mut outputs);
    Steady {
        system,
        state,
        outputs,
        counts: newton.counts,
    }
}

/// The steady state of a load case.
pub fn load_case(parameters: &Parameters, case: &LoadCase) -> Steady {
    steady(parameters, &case.task(), [SPEED / ratio(case.theta), SPEED])
}

/// Inputs of torque and clamping force over pulleys, and speed set points of 2000 rpm.
pub fn inputs(primary: (f64, f64), secondary: (f64, f64)) -> Inputs {
    let pulley = |(torque, clamping_force)| PulleyInputs {
        torque,
        clamping_force,
        speed_setpoint: SPEED,
    };
    Inputs {
        primary: pulley(primary),
        secondary: pulley(secondary),
    }
}

/// A run that keeps its books: energy and element amount at every output point.
#[derive(Clone, Debug)]
pub struct Run {
    /// The variator.
    pub variator: Variator,
    /// Inputs, constant until changed.
    pub inputs: Inputs,
    /// Largest |energy residual| over what is allowed, 2e-3·∫|power| dt + 1e-3·(largest stored energy).
    pub residual: f64,
    /// Largest relative change of the element amount.
    pub amount_change: f64,
    /// What the variator said.
    pub messages: Vec<Message>,
    largest_energy: f64,
    amount: f64,
}

impl Run {
    /// Initialises.
    pub fn new(parameters: Parameters, inputs: Inputs) -> Self {
        let mut variator = Variator::new(parameters).expect("valid parameters");
        variator.initialise(0.0, &inputs).expect("a state to start from");
        let mut run = Self {
            amount: amount(&variator),
            variator,
            inputs,
            residual: 0.0,
            amount_change: 0.0,
            messages: Vec::new(),
            largest_energy: 0.0,
        };
        run.look();
        run
    }

    fn look(&mut self) {
        let moved = self.variator.system().ledger.moved;
        let time = self.variator.time();
        let o = self.variator.outputs();
        for (value, name) in [
            (o.thrust_ratio, "thrust ratio"),
            (o.slip, "slip"),
            (o.primary.speed, "primary speed"),
            (o.secondary.speed, "secondary speed"),
            (o.push_force_max, "push force"),
            (o.ring_tension_max, "ring tension"),
        ] {
            assert!(value.is_finite(), "{name} = {value} at {time} s");
        }
        self.largest_energy = self.largest_energy.max(o.stored_energy);
        let allowed = 2.0e-3 * moved + 1.0e-3 * self.largest_energy;
        self.residual = self.residual.max(o.energy_residual.abs() / allowed);
        let change = (amount(&self.variator) / self.amount - 1.0).abs();
        self.amount_change = self.amount_change.max(change);
        self.messages.extend(self.variator.take_messages());
    }

    /// Advances by `span` in communication steps of `step`; `see` is called after each.
    pub fn watch(&mut self, span: f64, step: f64, mut see: impl FnMut(f64, &Outputs)) {
        let from = self.variator.time();
        let steps = (span / step).round().max(1.0) as u32;
        for k in 1..=steps {
            let to = from + span * f64::from(k) / f64::from(steps);
            self.variator.advance(to, &self.inputs).expect("the run goes on");
            self.look();
            see(to, self.variator.outputs());
        }
    }

    /// Advances by `span` in communication steps of `step`; the outputs at the end.
    pub fn go(&mut self, span: f64, step: f64) -> Outputs {
        self.watch(span, step, |_, _| {});
        self.variator.outputs().clone()
    }

    /// Advances by `span` in communication steps of `step` with inputs that change at `rates`.
    pub fn ramp(&mut self, span: f64, step: f64, rates: &Inputs) {
        let from = self.variator.time();
        let steps = (span / step).round().max(1.0) as u32;
        let start = self.inputs;
        let after = |time: f64| {
            let moved = |value: &PulleyInputs, rate: &PulleyInputs| PulleyInputs {
                torque: value.torque + time * rate.torque,
                clamping_force: value.clamping_force + time * rate.clamping_force,
                speed_setpoint: value.speed_setpoint + time * rate.speed_setpoint,
            };
            Inputs {
                primary: moved(&start.primary, &rates.primary),
                secondary: moved(&start.secondary, &rates.secondary),
            }
        };
        for k in 0..steps {
            let at = |k: u32| span * f64::from(k) / f64::from(steps);
            self.variator
                .advance_along(from + at(k + 1), &after(at(k)), rates)
                .expect("the run goes on");
            self.look();
        }
        self.inputs = after(span);
    }

    /// Whether a warning contains `text`.
    pub fn warned(&self, text: &str) -> bool {
        self.messages.iter().any(|m| m.warning && m.text.contains(text))
    }

    /// Whether a message contains `text`, be it a warning or a remark.
    pub fn told(&self, text: &str) -> bool {
        self.messages.iter().any(|m| m.text.contains(text))
    }

    /// The books of energy and of the element amount, at every output point so far.
    #[track_caller]
    pub fn assert_books(&self) {
        self.assert_amount();
        assert!(
            self.residual <= 1.0,
            "energy residual {:.2} times what is allowed, up to {} s",
            self.residual,
            self.variator.time()
        );
    }

    /// No element is lost.
    #[track_caller]
    pub fn assert_amount(&self) {
        assert!(
            self.amount_change <= 1.0e-10,
            "the amount of elements changed by {:e}",
            self.amount_change
        );
    }
}

/// Element amount Σ N, m.
fn amount(v: &Variator) -> f64 {
    let layout = v.system().layout;
    (0..layout.cells()).map(|i| v.state().y[layout.amount(i)]).sum()
}

/// Lines of `resources/manoeuvre.csv`: torque and clamping force of P, then of S, linear between lines.
#[derive(Debug)]
pub struct Manoeuvre {
    rows: Vec<[f64; 5]>,
}

impl Manoeuvre {
    /// Reads the file.
    pub fn read() -> Self {
        let text = include_str!("../../resources/manoeuvre.csv");
        let rows = text.lines().skip(1).map(|line| {
            let mut values = line.split(',').map(|x| x.parse().expect("a number"));
            std::array::from_fn(|_| values.next().expect("five columns"))
        });
        Self { rows: rows.collect() }
    }

    /// When it ends, s.
    pub fn end(&self) -> f64 {
        self.rows[self.rows.len() - 1][0]
    }

    /// Inputs at time `t`.
    pub fn at(&self, t: f64) -> Inputs {
        let right = self
            .rows
            .partition_point(|row| row[0] <= t)
            .clamp(1, self.rows.len() - 1);
        let (a, b) = (&self.rows[right - 1], &self.rows[right]);
        let share = ((t - a[0]) / (b[0] - a[0])).clamp(0.0, 1.0);
        let value = |k: usize| a[k] + share * (b[k] - a[k]);
        inputs((value(1), value(3)), (value(2), value(4)))
    }

    /// The variator it is meant for: a vehicle's inertia on the secondary shaft, at a standstill in underdrive.
    pub fn variator(mut parameters: Parameters) -> Parameters {
        parameters.secondary.inertia = 4.0;
        parameters.initial.ratio = 2.2;
        parameters.initial.primary_speed = 0.0;
        parameters
    }

    /// The same, in the steady state near which it is when the over-torque comes.
    pub fn before_over_torque(parameters: Parameters) -> Parameters {
        let mut parameters = Self::variator(parameters);
        parameters.initial.ratio = 0.8;
        parameters.initial.primary_speed = 120.0;
        parameters
    }
}
