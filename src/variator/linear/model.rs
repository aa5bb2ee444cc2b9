//! The linear model: slow modes as its states, faster ones as its direct part.

use faer::linalg::solvers::Solve;
use faer::{Mat, Scale};

use super::SHIFT;
use super::descriptor::Descriptor;
use super::loads::{Load, departures, load_columns, loads_in_force};
use super::modes::{SlowModes, slow_modes};
use super::working_point::{LinearError, WorkingPoint};
use crate::solver::{State, System};
use crate::variator::diagnostics::belt::BeltDiagnostics;
use crate::variator::diagnostics::observe::Observer;
use crate::variator::pulleys::loads::Loads;
use crate::variator::run::variator::Variator;
use crate::variator::settings::{Inputs, Outputs, Parameters};

/// ẋ = A x + B u, y = C x + D u about the working point. Each matrix is a list of its rows;
/// deviations in SI units.
#[derive(Clone, Debug)]
pub struct LinearModel {
    /// Specified inputs.
    pub given: Inputs,
    /// Inputs that hold the working point.
    pub inputs: Inputs,
    /// Outputs at the working point.
    pub outputs: Box<Outputs>,
    /// Inputs u, in the order of the columns of B and D.
    pub loads: Vec<Load>,
    /// A, whose states x are coordinates of the slow modes, without units of their own.
    pub a: Vec<Vec<f64>>,
    /// B, a column for each load.
    pub b: Vec<Vec<f64>>,
    /// C, a row for each output that was chosen.
    pub c: Vec<Vec<f64>>,
    /// D: direct effect of the loads on the outputs, by modes that are not in A.
    pub d: Vec<Vec<f64>>,
    /// Eigenvalues of A, 1/s, in the order of the states, the slowest first: real and imaginary
    /// part. A conjugate pair has two states.
    pub poles: Vec<[f64; 2]>,
    /// Differences from the specified working point, one sentence each.
    pub remarks: Vec<String>,
}

/// The linear model about the steady state at the initial ratio and speed: modes below `frequency`,
/// Hz, and the outputs `read`. The torques, and the clamping force of the pulley that reacts, are
/// those that hold the state; they are among the inputs of the model.
///
/// # Errors
/// See [`LinearError`].
pub fn linearise(
    parameters: &Parameters,
    inputs: &Inputs,
    frequency: f64,
    read: &[&dyn Fn(&Outputs) -> f64],
) -> Result<LinearModel, LinearError> {
    about(WorkingPoint::new(parameters, inputs)?, frequency, read)
}

/// The linear model about the present state of `variator`, as [`linearise`]. `inputs` are those
/// that act: where others hold the state, there is a remark in [`LinearModel::remarks`].
///
/// # Errors
/// See [`LinearError`].
pub fn linearise_at(
    variator: &mut Variator,
    inputs: &Inputs,
    frequency: f64,
    read: &[&dyn Fn(&Outputs) -> f64],
) -> Result<LinearModel, LinearError> {
    about(WorkingPoint::find(variator, inputs)?, frequency, read)
}

fn about(
    mut point: WorkingPoint,
    frequency: f64,
    read: &[&dyn Fn(&Outputs) -> f64],
) -> Result<LinearModel, LinearError> {
    let loads = loads_in_force(&point.system.parameters);
    let descriptor = Descriptor::new(&mut point.system, &point.state);
    let b = load_columns(&mut point, &loads, descriptor.a.nrows());
    let cut_off = std::f64::consts::TAU * frequency;
    let shift = SHIFT * cut_off;
    let factors = descriptor.factors(shift);
    let SlowModes { right, left, poles } = slow_modes(&descriptor, &factors, cut_off)?;
    if right.ncols() == 0 {
        return Err(LinearError::NoMode(frequency));
    }
    // Oblique projection on the slow modes.
    let projection = (&left * &descriptor.e * &right).partial_piv_lu();
    let slow_a = projection.solve(&left * &descriptor.a * &right);
    let slow_b = projection.solve(&left * &b);
    let rates = &right * &slow_a;
    // Response of the whole system to each load less that of the slow modes, which is large here,
    // and sliding depends on it nonlinearly.
    let whole = factors.solve(&b);
    let identity = Mat::<f64>::identity(poles.len(), poles.len());
    let slow = (identity * Scale(shift) - &slow_a).partial_piv_lu().solve(&slow_b);
    let (rest, rest_rates) = (&whole - &right * &slow, &whole * Scale(shift) - &rates * &slow);
    let mut differentiate = |load: Option<Load>, x: &Mat<f64>, rates: &Mat<f64>, k: usize| {
        derivatives_along(&mut point, load, &descriptor.direction(x, rates, k), read)
    };
    let c = (0..poles.len()).map(|k| differentiate(None, &right, &rates, k));
    let c: Vec<Vec<f64>> = c.collect();
    let d = loads.iter().enumerate();
    let d: Vec<Vec<f64>> = d
        .map(|(l, load)| differentiate(Some(*load), &rest, &rest_rates, l))
        .collect();
    Ok(LinearModel {
        remarks: departures(&loads, &point),
        given: point.given,
        inputs: point.inputs,
        outputs: point.outputs,
        loads,
        a: rows(&slow_a),
        b: rows(&slow_b),
        c: transposed(&c, read.len()),
        d: transposed(&d, read.len()),
        poles,
    })
}

fn rows(matrix: &Mat<f64>) -> Vec<Vec<f64>> {
    let rows = matrix.row_iter();
    rows.map(|row| row.iter().copied().collect()).collect()
}

/// The rows, so many, of the matrix with these columns.
fn transposed(columns: &[Vec<f64>], rows: usize) -> Vec<Vec<f64>> {
    (0..rows)
        .map(|i| columns.iter().map(|column| column[i]).collect())
        .collect()
}

/// Derivatives of outputs along a direction of the state, in which a load changes by one, by
/// central differences over which the laws are nearly linear.
fn derivatives_along(
    point: &mut WorkingPoint,
    load: Option<Load>,
    direction: &State,
    read: &[&dyn Fn(&Outputs) -> f64],
) -> Vec<f64> {
    let WorkingPoint {
        system, state, inputs, ..
    } = point;
    let n = direction.y.len();
    let (mut velocity, mut position) = (vec![0.0; n], vec![0.0; n]);
    system.newton_scale(1.0e-6, &mut velocity);
    system.newton_scale(1.0, &mut position);
    let mut largest = f64::MIN_POSITIVE;
    for i in 0..n {
        largest = largest.max((direction.y[i] / velocity[i]).abs());
        if system.has_position()[i] {
            largest = largest.max((direction.q[i] / position[i]).abs());
        }
    }
    let step = 1.0 / largest;
    // A clamping force is not negative, so there is none below that of a pulley under pressure
    // alone.
    let offset = if load.is_some_and(|load| load.unit() == "N") {
        step
    } else {
        0.0
    };
    let mut outputs_after = |step: f64| {
        let mut state = state.clone();
        for i in 0..n {
            state.y[i] += step * direction.y[i];
            state.y_dot[i] += step * direction.y_dot[i];
            state.q[i] += step * direction.q[i];
        }
        let mut inputs = *inputs;
        if let Some(load) = load {
            load.add(offset + step, &mut inputs);
        }
        system.loads = Loads::held(&inputs);
        let diagnostics = BeltDiagnostics::new(system, state.view());
        let mut outputs = Outputs::default();
        Observer::default().observe(system, 0.0, state.view(), &diagnostics, &mut outputs);
        outputs
    };
    let (after, before) = (outputs_after(step), outputs_after(-step));
    let slope = |read: &&dyn Fn(&Outputs) -> f64| (read(&after) - read(&before)) / (2.0 * step);
    read.iter().map(slope).collect()
}
