//! A linear model about a steady working point, for controller design.
//!
//! At a steady state the residual F(y, ẏ, q) − G u = 0 with q̇ = y has exact derivatives (the solver's Jacobian for
//! three choices of its slopes). With x = (y, q) this is a descriptor system E ẋ = A x + B u. Its eigenvalues below a
//! chosen frequency are found by shift and inversion; right and left eigenvectors project on them (modal truncation),
//! and what is faster is kept as a direct part D that makes the static gain right. Outputs are differentiated along
//! each mode by central differences.
//!
//! Method: Antoulas, Approximation of Large-Scale Dynamical Systems (2005), sections 9.1 and 9.2.

use faer::linalg::solvers::Solve;
use faer::{Mat, c64};

use crate::pulley::Pulley;
use crate::solver::arrow::{Arrow, ArrowLu, Singular};
use crate::solver::{State, System};
use crate::variator::pulleys::loads::{Boundary, LoadRates, ShaftMode, SheaveMode};
use crate::variator::run::variator::{InitialisationError, Variator};
use crate::variator::settings::parameters::{Axial, Drive, Parameters, SPEED_LAG};
use crate::variator::settings::signals::{Inputs, Outputs, StartState};
use crate::variator::settings::validation::ParameterError;
use crate::variator::survey::observe::{Context, Observer};
use crate::variator::survey::survey::Survey;
use crate::variator::system::VariatorSystem;

/// Time at which the loads are taken, s: they do not change.
const TIME: f64 = 0.0;
/// Modes slower than this, 1/s, are conserved quantities that no load changes: the gauge of the overlay.
const NEUTRAL: f64 = 1.0e-3;
/// Part of the cut-off at which the static gain is taken: it must not meet a neutral mode.
const NEARLY_STATIC: f64 = 1.0e-3;
/// Part of the cut-off to which eigenvalues are shifted: near it rounding moves them least, and the slowest are the
/// nearest to each other.
const SHIFT: f64 = 0.01;
/// Largest Θ̇ of a working point, 1/s.
const STEADY: f64 = 1.0e-4;

/// An input of the linear model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Load {
    /// Clamping force of a pulley, N.
    ClampingForce(Pulley),
    /// External torque on a pulley's shaft, N·m.
    Torque(Pulley),
    /// Speed set point of a pulley, rad/s.
    SpeedSetpoint(Pulley),
}

impl Load {
    /// The field of the inputs.
    pub fn field(self, inputs: &mut Inputs) -> &mut f64 {
        let Inputs { primary, secondary } = inputs;
        let (Self::ClampingForce(j) | Self::Torque(j) | Self::SpeedSetpoint(j)) = self;
        let pulley = match j {
            Pulley::Primary => primary,
            Pulley::Secondary => secondary,
        };
        match self {
            Self::ClampingForce(_) => &mut pulley.clamping_force,
            Self::Torque(_) => &mut pulley.torque,
            Self::SpeedSetpoint(_) => &mut pulley.speed_setpoint,
        }
    }

    /// Name of the FMU's variable.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::ClampingForce(Pulley::Primary) => "primary.clampingForce",
            Self::ClampingForce(Pulley::Secondary) => "secondary.clampingForce",
            Self::Torque(Pulley::Primary) => "primary.torque",
            Self::Torque(Pulley::Secondary) => "secondary.torque",
            Self::SpeedSetpoint(Pulley::Primary) => "primary.speedSetpoint",
            Self::SpeedSetpoint(Pulley::Secondary) => "secondary.speedSetpoint",
        }
    }
}

/// ẋ = A x + B u, y = C x + D u about the working point. Each matrix is a list of its rows; deviations in SI units.
#[derive(Clone, Debug)]
pub struct LinearModel {
    /// Inputs that hold the working point.
    pub inputs: Inputs,
    /// Outputs at the working point.
    pub outputs: Box<Outputs>,
    /// Inputs u, in the order of the columns of B and D.
    pub loads: Vec<Load>,
    /// A; x are coordinates of the slow modes, without units of their own.
    pub a: Vec<Vec<f64>>,
    /// B.
    pub b: Vec<Vec<f64>>,
    /// C, a row for each output asked for.
    pub c: Vec<Vec<f64>>,
    /// D.
    pub d: Vec<Vec<f64>>,
    /// Eigenvalues of A, 1/s: real and imaginary part.
    pub poles: Vec<[f64; 2]>,
}

/// Why there is no linear model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LinearError {
    /// A parameter is out of its range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// No state to start from.
    #[error(transparent)]
    Start(#[from] InitialisationError),
    /// The state is no steady one.
    #[error("this is no steady working point: {0}")]
    Unsteady(String),
    /// The eigenvalues were not found, or right and left ones differ: too near to each other.
    #[error("the eigenvalues were not found: slow modes lie too near to each other")]
    Eigenvalues,
    /// No eigenvalue is below the frequency.
    #[error("no mode is slower than {0} Hz")]
    NoMode(f64),
}

/// A steady state, with the loads that hold it in force.
struct WorkingPoint {
    system: VariatorSystem,
    state: State,
    inputs: Inputs,
    outputs: Box<Outputs>,
}

impl WorkingPoint {
    /// At the initial ratio and speed.
    fn new(parameters: &Parameters, inputs: &Inputs) -> Result<Self, LinearError> {
        if parameters.ring_model.travels() {
            return Err(LinearError::Unsteady(
                "the nodes of this ring model pass under the stations; ALE has a steady state".to_string(),
            ));
        }
        let mut parameters = parameters.clone();
        parameters.initial.steady = true;
        let mut variator = Variator::new(parameters.clone())?;
        variator.initialise(0.0, inputs)?;
        if variator.outputs().start_state != StartState::Steady {
            let warning = variator.take_messages().into_iter().find(|message| message.warning);
            let why = warning.map_or_else(|| "the primary pulley stands still".to_string(), |warning| warning.text);
            return Err(LinearError::Unsteady(why));
        }
        let (mut system, state) = (variator.system().clone(), variator.state().clone());
        let inputs = hold(&mut system, &state, &parameters, inputs)?;
        Ok(Self {
            system,
            state,
            inputs,
            outputs: Box::new(variator.outputs().clone()),
        })
    }
}

/// Eigenvalues of the steady state at the initial ratio and speed below `frequency`, Hz, the one that grows most first:
/// real and imaginary part, 1/s, of each pair the one that turns forward. Runs with long steps damp fast modes, so a
/// run doesn't tell.
///
/// # Errors
/// See [`LinearError`].
pub fn modes(parameters: &Parameters, inputs: &Inputs, frequency: f64) -> Result<Vec<[f64; 2]>, LinearError> {
    let mut point = WorkingPoint::new(parameters, inputs)?;
    let (e, a, _) = descriptor(&mut point.system, &point.state);
    let cut_off = std::f64::consts::TAU * frequency;
    let shift = SHIFT * cut_off;
    let values = inverted(&e, &a, shift)
        .eigenvalues()
        .map_err(|_| LinearError::Eigenvalues)?;
    let mut modes: Vec<[f64; 2]> = values
        .iter()
        .map(|&value| unshifted(shift, value))
        .filter(|lambda| lambda.im >= 0.0 && is_slow(*lambda, cut_off))
        .map(|lambda| [lambda.re, lambda.im])
        .collect();
    modes.sort_by(|a, b| b[0].total_cmp(&a[0]));
    Ok(modes)
}

/// A direction of x = (y, q), with ẏ beside it.
struct Direction {
    y: Vec<f64>,
    y_dot: Vec<f64>,
    q: Vec<f64>,
}

/// The linear model about the steady state at the initial ratio and speed: modes below `frequency`, Hz, and the outputs
/// that `read` picks. The clamping force of the pulley that reacts and the torques are those that hold the state; the
/// model tells them in its inputs.
///
/// # Errors
/// See [`LinearError`].
pub fn linearise(
    parameters: &Parameters,
    inputs: &Inputs,
    frequency: f64,
    read: &[&dyn Fn(&Outputs) -> f64],
) -> Result<LinearModel, LinearError> {
    let mut point = WorkingPoint::new(parameters, inputs)?;
    let (system, state) = (&mut point.system, &point.state);
    let loads = loads(parameters);

    let (e, a, columns) = descriptor(system, state);
    let b = load_columns(system, &loads, a.nrows());
    let cut_off = std::f64::consts::TAU * frequency;
    let (right, left) = slow_modes(&e, &a, cut_off)?;
    if right.ncols() == 0 {
        return Err(LinearError::NoMode(frequency));
    }
    // Oblique projection on the slow modes.
    let factor = (&left * &e * &right).partial_piv_lu();
    let a_slow = factor.solve(&left * &a * &right);
    let b_slow = factor.solve(&left * &b);

    let n = system.belt.layout.len();
    let split = |column: &[f64], rate: &[f64]| Direction {
        y: column[..n].to_vec(),
        y_dot: rate[..n].to_vec(),
        q: {
            let mut q = vec![0.0; n];
            for (k, &i) in columns.iter().enumerate() {
                q[i] = column[n + k];
            }
            q
        },
    };
    let column = |matrix: &Mat<f64>, k: usize| -> Vec<f64> { (0..matrix.nrows()).map(|i| matrix[(i, k)]).collect() };
    let mut differentiate = |direction: &Direction| slopes(system, state, direction, read);
    let rates = &right * &a_slow;
    let c: Vec<Vec<f64>> = (0..right.ncols())
        .map(|k| differentiate(&split(&column(&right, k), &column(&rates, k))))
        .collect();
    // D from the whole system's gain where it is nearly static.
    let sigma = NEARLY_STATIC * cut_off;
    let whole = shifted(&e, &a, sigma).partial_piv_lu().solve(&b);
    let slow = (Mat::<f64>::identity(a_slow.nrows(), a_slow.nrows()) * faer::Scale(sigma) - &a_slow)
        .partial_piv_lu()
        .solve(&b_slow);
    let d: Vec<Vec<f64>> = (0..loads.len())
        .map(|l| {
            // What the slow modes leave, before outputs are differentiated: they are large here and sliding bends with
            // them.
            let mut x = column(&whole, l);
            let mut rate: Vec<f64> = x.iter().map(|x| sigma * x).collect();
            for k in 0..right.ncols() {
                for i in 0..x.len() {
                    x[i] -= right[(i, k)] * slow[(k, l)];
                    rate[i] -= rates[(i, k)] * slow[(k, l)];
                }
            }
            differentiate(&split(&x, &rate))
        })
        .collect();
    let values = a_slow.eigenvalues().map_err(|_| LinearError::Eigenvalues)?;
    let rows = |matrix: &Mat<f64>| -> Vec<Vec<f64>> {
        let row = |i| (0..matrix.ncols()).map(|j| matrix[(i, j)]).collect();
        (0..matrix.nrows()).map(row).collect()
    };
    let transposed = |columns: &[Vec<f64>]| -> Vec<Vec<f64>> {
        (0..read.len())
            .map(|i| columns.iter().map(|column| column[i]).collect())
            .collect()
    };
    Ok(LinearModel {
        inputs: point.inputs,
        outputs: point.outputs,
        loads,
        a: rows(&a_slow),
        b: rows(&b_slow),
        c: transposed(&c),
        d: transposed(&d),
        poles: values.iter().map(|value| [value.re, value.im]).collect(),
    })
}

/// Puts the loads in force that hold the state; returns them as inputs.
fn hold(
    system: &mut VariatorSystem,
    state: &State,
    parameters: &Parameters,
    inputs: &Inputs,
) -> Result<Inputs, LinearError> {
    let mut held = *inputs;
    let sums = Survey::of(system, state.view()).sums;
    let mut boundary = system.loads.at(TIME);
    for (j, pulley, values) in [
        (Pulley::Primary, &parameters.primary, &mut held.primary),
        (Pulley::Secondary, &parameters.secondary, &mut held.secondary),
    ] {
        if pulley.axial == Axial::Force {
            values.clamping_force = system.pulleys.holding_force(j, state.view(), sums.axial[j]);
            boundary.sheave[j] = SheaveMode::Force(values.clamping_force);
        }
        boundary.shaft[j] = match pulley.drive {
            Drive::Torque => {
                values.torque = -sums.torque[j];
                ShaftMode::Torque(values.torque)
            }
            Drive::Speed => {
                values.speed_setpoint = state.y[system.belt.layout.shaft_speed(j)];
                ShaftMode::Setpoint(values.speed_setpoint)
            }
        };
    }
    load(system, boundary);
    let n = system.belt.layout.len();
    let mut residual = vec![0.0; n];
    system.residual(TIME, state.view(), &mut residual);
    // As Newton's method would correct it over a second.
    let mut matrix = Arrow::new(system.shape());
    system.jacobian(TIME, state.view(), 1.0, 1.0, &mut matrix);
    let mut factors = ArrowLu::new(system.shape());
    let singular = |error: Singular| LinearError::Unsteady(error.to_string());
    factors.factor(&matrix).map_err(singular)?;
    factors.solve(&mut residual);
    let theta = system.belt.layout.theta();
    let drift = residual[theta].abs();
    if drift > STEADY {
        return Err(LinearError::Unsteady(format!(
            "the ratio moves by {drift:.1e} a second"
        )));
    }
    Ok(held)
}

fn load(system: &mut VariatorSystem, boundary: Boundary) {
    let mut rates = vec![0.0; system.belt.layout.len()];
    system.change_loads(0.0, boundary, LoadRates::default(), 0.0, &mut rates);
}

/// The inputs that are in force.
fn loads(parameters: &Parameters) -> Vec<Load> {
    let mut loads = Vec::new();
    for (j, pulley) in [
        (Pulley::Primary, &parameters.primary),
        (Pulley::Secondary, &parameters.secondary),
    ] {
        loads.push(match pulley.drive {
            Drive::Torque => Load::Torque(j),
            Drive::Speed => Load::SpeedSetpoint(j),
        });
        if pulley.axial == Axial::Force {
            loads.push(Load::ClampingForce(j));
        }
    }
    loads
}

/// E, A, and the unknowns whose positions follow the velocities in x. The drift position s stays out: nothing depends
/// on it.
fn descriptor(system: &mut VariatorSystem, state: &State) -> (Mat<f64>, Mat<f64>, Vec<usize>) {
    let n = system.belt.layout.len();
    let drift = system.belt.layout.drift();
    let columns: Vec<usize> = (0..n).filter(|&i| system.has_position()[i] && i != drift).collect();
    let mut dense = |alpha: f64, beta: f64| {
        let mut arrow = Arrow::new(system.shape());
        system.jacobian(TIME, state.view(), alpha, beta, &mut arrow);
        let (mut unit, mut image) = (vec![0.0; n], vec![0.0; n]);
        let mut matrix = Mat::<f64>::zeros(n, n);
        for j in 0..n {
            unit[j] = 1.0;
            arrow.multiply(&unit, &mut image);
            unit[j] = 0.0;
            for i in 0..n {
                matrix[(i, j)] = image[i];
            }
        }
        matrix
    };
    let (by_y, by_rate, by_place) = (dense(0.0, 0.0), dense(1.0, 0.0), dense(0.0, 1.0));
    let size = n + columns.len();
    let (mut e, mut a) = (Mat::<f64>::zeros(size, size), Mat::<f64>::zeros(size, size));
    for i in 0..n {
        for j in 0..n {
            e[(i, j)] = by_rate[(i, j)] - by_y[(i, j)];
            a[(i, j)] = -by_y[(i, j)];
        }
        for (k, &j) in columns.iter().enumerate() {
            a[(i, n + k)] = by_y[(i, j)] - by_place[(i, j)];
        }
    }
    for (k, &j) in columns.iter().enumerate() {
        e[(n + k, n + k)] = 1.0;
        a[(n + k, j)] = 1.0;
    }
    // Elements on the belt are neither gained nor lost: as a constraint in place of one of the balances that together
    // say so. Left among the modes, it would be one with the eigenvalue 0, and rounding mixes it with slow ones.
    let cells = system.belt.layout.cells();
    let balance = system.belt.layout.amount(cells - 1);
    for j in 0..size {
        (e[(balance, j)], a[(balance, j)]) = (0.0, 0.0);
    }
    for cell in 0..cells {
        a[(balance, system.belt.layout.amount(cell))] = 1.0;
    }
    (e, a, columns)
}

/// B: where loads stand in the residual, with the other sign.
fn load_columns(system: &VariatorSystem, loads: &[Load], size: usize) -> Mat<f64> {
    let mut b = Mat::<f64>::zeros(size, loads.len());
    for (l, load) in loads.iter().enumerate() {
        let (row, factor) = match *load {
            Load::ClampingForce(j) => (system.belt.layout.sheave(j), 1.0),
            Load::Torque(j) => (system.belt.layout.shaft_speed(j), 1.0),
            Load::SpeedSetpoint(j) => (
                system.belt.layout.shaft_speed(j),
                system.pulleys.parameters(j).inertia / SPEED_LAG,
            ),
        };
        b[(row, l)] = factor;
    }
    b
}

/// σE − A.
fn shifted(e: &Mat<f64>, a: &Mat<f64>, sigma: f64) -> Mat<f64> {
    e * faer::Scale(sigma) - a
}

/// (σE − A)⁻¹E.
fn inverted(e: &Mat<f64>, a: &Mat<f64>, sigma: f64) -> Mat<f64> {
    shifted(e, a, sigma).partial_piv_lu().solve(e)
}

/// The eigenvalue of the pencil that belongs to `value` of [`inverted`].
fn unshifted(sigma: f64, value: c64) -> c64 {
    c64::new(sigma, 0.0) - c64::new(1.0, 0.0) / value
}

/// Real bases of the right and of the left (as rows) invariant subspaces with |λ| below `cut_off`, neutral modes left
/// out: λ = σ − 1/μ for the eigenvalues μ of (σE − A)⁻¹E.
fn slow_modes(e: &Mat<f64>, a: &Mat<f64>, cut_off: f64) -> Result<(Mat<f64>, Mat<f64>), LinearError> {
    let shift = SHIFT * cut_off;
    let inverted = inverted(e, a, shift);
    // One of each pair of conjugates.
    let pairs = |matrix: &Mat<f64>| -> Result<Vec<(c64, Vec<c64>)>, LinearError> {
        let eigen = matrix.eigen().map_err(|_| LinearError::Eigenvalues)?;
        let (values, vectors) = (eigen.S().column_vector(), eigen.U());
        let lambda = |k: usize| unshifted(shift, values[k]);
        let column = |k: usize| (0..matrix.nrows()).map(|i| vectors[(i, k)]).collect();
        let upper = (0..values.nrows()).filter(|&k| lambda(k).im >= 0.0);
        Ok(upper.map(|k| (lambda(k), column(k))).collect())
    };
    let mut right = pairs(&inverted)?;
    right.retain(|(lambda, _)| is_slow(*lambda, cut_off));
    right.sort_by(|(a, _), (b, _)| a.norm().total_cmp(&b.norm()));
    // Left eigenvectors w of (σE − A)⁻¹E; those of the pencil are w (σE − A)⁻¹. Rounding may move an eigenvalue across
    // the cut-off, so each finds its nearest.
    let mut others = pairs(&inverted.transpose().to_owned())?;
    let mut left = Vec::with_capacity(right.len());
    for (lambda, _) in &right {
        let far = |k: usize| (others[k].0 - *lambda).norm();
        let nearest = (0..others.len())
            .min_by(|&i, &j| far(i).total_cmp(&far(j)))
            .ok_or(LinearError::Eigenvalues)?;
        let (other, vector) = others.swap_remove(nearest);
        if (other - *lambda).norm() > 0.1 * lambda.norm() || is_oscillation(other) != is_oscillation(*lambda) {
            return Err(LinearError::Eigenvalues);
        }
        left.push((other, vector));
    }
    let transposed = shifted(e, a, shift).transpose().to_owned().partial_piv_lu();
    let left = transposed.solve(&real_basis(&left, a.nrows())).transpose().to_owned();
    Ok((real_basis(&right, a.nrows()), left))
}

/// Slower than `cut_off`, and not neutral.
fn is_slow(lambda: c64, cut_off: f64) -> bool {
    (NEUTRAL..cut_off).contains(&lambda.norm())
}

fn is_oscillation(lambda: c64) -> bool {
    lambda.im > 1.0e-9 * lambda.norm()
}

/// Real and imaginary parts of eigenvectors.
fn real_basis(modes: &[(c64, Vec<c64>)], rows: usize) -> Mat<f64> {
    let mut columns: Vec<Vec<f64>> = Vec::new();
    for (lambda, vector) in modes {
        columns.push(vector.iter().map(|x| x.re).collect());
        if is_oscillation(*lambda) {
            columns.push(vector.iter().map(|x| x.im).collect());
        }
    }
    Mat::from_fn(rows, columns.len(), |i, j| columns[j][i])
}

/// Derivatives of outputs along a direction, by central differences of a size that the laws take as straight.
fn slopes(
    system: &mut VariatorSystem,
    state: &State,
    direction: &Direction,
    read: &[&dyn Fn(&Outputs) -> f64],
) -> Vec<f64> {
    let n = system.belt.layout.len();
    let (mut velocity, mut place) = (vec![0.0; n], vec![0.0; n]);
    system.newton_scale(1.0e-6, &mut velocity);
    system.newton_scale(1.0, &mut place);
    let mut largest = f64::MIN_POSITIVE;
    for i in 0..n {
        largest = largest.max((direction.y[i] / velocity[i]).abs());
        if system.has_position()[i] {
            largest = largest.max((direction.q[i] / place[i]).abs());
        }
    }
    let step = 1.0 / largest;
    let beside = |step: f64| {
        let mut state = state.clone();
        for i in 0..n {
            state.y[i] += step * direction.y[i];
            state.y_dot[i] += step * direction.y_dot[i];
            state.q[i] += step * direction.q[i];
        }
        let survey = Survey::of(system, state.view());
        let boundary = system.loads.at(TIME);
        let context = Context {
            external_torque: system
                .pulleys
                .external_torques(&boundary, state.view(), survey.sums.torque),
            macro_slip: false,
            supplied: 0.0,
            lost: 0.0,
            initial_energy: 0.0,
            start_state: StartState::Steady,
        };
        let mut outputs = Outputs::default();
        Observer::default().observe(system, state.view(), &survey, &context, &mut outputs);
        outputs
    };
    let (after, before) = (beside(step), beside(-step));
    let slope = |read: &&dyn Fn(&Outputs) -> f64| (read(&after) - read(&before)) / (2.0 * step);
    read.iter().map(slope).collect()
}
