//! Two of the paper's proposals (its section 7), measured before they are built: what separate
//! integration of reference and overlay would take, and how many modes an overlay by proper
//! orthogonal decomposition needs.

use nalgebra::{DMatrix, DVector, SymmetricEigen};
use pushbelt::solver::arrow::Arrow;
use pushbelt::solver::sdirk::GAMMA;
use pushbelt::solver::{State, System};
use pushbelt::variator::mesh::layout::Layout;
use pushbelt::variator::run::Variator;
use pushbelt::variator::settings::Inputs;
use pushbelt::variator::settings::RingModel;
use pushbelt_support::bench::STEP;
use pushbelt_support::load_cases::LoadCase;
use pushbelt_support::manoeuvre::Manoeuvre;
use pushbelt_support::steady::{Steady, load_case, stations};
use pushbelt_support::variators::variator;
use serde_json::json;

use crate::{Table, quantiles};

/// Both measurements, of `ALE`.
pub fn measure(table: &mut Table, trace: &[Inputs]) {
    separated(table);
    modes(table, trace);
}

/// Steps at which it is looked at, s.
const STEPS: [f64; 4] = [1e-3, 1e-4, 1e-5, 1e-6];

/// Contraction per sweep of an iteration that solves a stage for one part of the unknowns after the
/// other (block Gauss-Seidel), in the steady state medium, 50 N·m: the spectral radius of J₁₁⁻¹ J₁₂
/// J₂₂⁻¹ J₂₁. Above 1 the iteration diverges, and integration of one part with the other's last
/// values is unstable.
fn separated(table: &mut Table) {
    let parameters = variator(RingModel::Ale);
    let [_, medium, _] = LoadCase::three(&parameters, 50.0);
    let mut steady = load_case(&parameters, &medium);
    let n = steady.state.y.len();
    let layout = steady.system.belt.layout;
    let reference = vec![layout.drift(), layout.theta()];
    let gauge = [0, 1].map(|condition| layout.gauge(condition));
    let overlay = overlay(&layout).map(|(place, _)| place).chain(gauge).collect();
    let jacobians = STEPS.map(|h| jacobian(&mut steady, 1.0 / (GAMMA * h)));
    let rest = |part: &[usize]| (0..n).filter(|i| !part.contains(i)).collect::<Vec<_>>();
    for (name, part) in [("s and Theta | all else", reference), ("overlay | all else", overlay)] {
        let other = rest(&part);
        let found = jacobians.each_ref().map(|jacobian| {
            let block =
                |rows: &[usize], columns: &[usize]| jacobian.select_rows(rows).select_columns(columns);
            let solve = |a: DMatrix<f64>, b: DMatrix<f64>| a.lu().solve(&b).expect("a regular block");
            let there = solve(block(&other, &other), block(&other, &part));
            let back = solve(block(&part, &part), block(&part, &other));
            spectral_radius(&(back * there))
        });
        table.row(
            &format!("separated, {name}: contraction"),
            format!(
                "{:.1e}, {:.1e}, {:.1e}, {:.1e} at steps of 1 ms to 1 us",
                found[0], found[1], found[2], found[3]
            ),
            json!({"steps": STEPS, "contraction": found}),
        );
    }
}

/// Indices of the overlay's unknowns, with the order of the derivative: 0 for a deflection, 1 for a
/// slope.
fn overlay(layout: &Layout) -> impl Iterator<Item = (usize, usize)> {
    (0..layout.elements).flat_map(move |node| [0, 1, 2, 3].map(|k| (layout.node(node, k), k % 2)))
}

/// The Jacobian of a stage, in full; `alpha` = 1/(γh) of a step h.
fn jacobian(steady: &mut Steady, alpha: f64) -> DMatrix<f64> {
    let n = steady.state.y.len();
    let mut arrow = Arrow::new(steady.system.shape());
    let state = steady.state.view();
    steady.system.jacobian(0.0, state, alpha, 1.0 / alpha, &mut arrow);
    let (mut matrix, mut unit) = (DMatrix::zeros(n, n), vec![0.0; n]);
    for (k, mut column) in matrix.column_iter_mut().enumerate() {
        unit[k] = 1.0;
        arrow.multiply(&unit, column.as_mut_slice());
        unit[k] = 0.0;
    }
    matrix
}

fn spectral_radius(matrix: &DMatrix<f64>) -> f64 {
    let eigenvalues = matrix.complex_eigenvalues();
    eigenvalues.iter().fold(0.0, |most, x| most.max(x.norm()))
}

/// Numbers of modes that are tried.
const MODES: [usize; 6] = [8, 16, 32, 64, 96, 128];
/// Communication steps between snapshots; tests lie in the middle between two.
const EVERY: usize = 10;

/// Modes of the overlay from every tenth communication point of the manoeuvre, and what is lost
/// where states in between are put on them: the largest change of ring tension, as a share of the
/// mean tension, in the median state and in the worst one of ten.
fn modes(table: &mut Table, trace: &[Inputs]) {
    let parameters = Manoeuvre::variator(variator(RingModel::Ale));
    let mut variator = Variator::new(parameters).expect("valid parameters");
    variator.initialise(0.0, &trace[0]).expect("a start");
    // A slope counts with the length of an element, some 10 mm.
    let overlay: Vec<(usize, f64)> = overlay(&variator.system().belt.layout)
        .map(|(place, order)| (place, if order == 0 { 1.0 } else { 1e-2 }))
        .collect();
    let (mut training, mut tests) = (Vec::new(), Vec::new());
    for (k, inputs) in trace.iter().enumerate() {
        variator.advance((k + 1) as f64 * STEP, inputs).expect("a step");
        if k % EVERY == 0 {
            let q = &variator.state().q;
            training.push(DVector::from_iterator(
                overlay.len(),
                overlay.iter().map(|(i, l)| q[*i] * l),
            ));
        } else if k % (5 * EVERY) == EVERY / 2 {
            tests.push(variator.state().clone());
        }
    }
    let mean = training.iter().sum::<DVector<f64>>() / training.len() as f64;
    let mut covariance = DMatrix::zeros(overlay.len(), overlay.len());
    for q in &training {
        let off = q - &mean;
        covariance.ger(1.0, &off, &off, 1.0);
    }
    let SymmetricEigen {
        eigenvectors,
        eigenvalues,
    } = covariance.symmetric_eigen();
    let mut order: Vec<usize> = (0..overlay.len()).collect();
    order.sort_by(|&a, &b| eigenvalues[b].total_cmp(&eigenvalues[a]));
    let tensions = |state: &State| -> Vec<f64> {
        let stations = stations(variator.system(), state);
        stations.iter().map(|at| at.sample.tension).collect()
    };
    for count in MODES {
        let basis = eigenvectors.select_columns(&order[..count]);
        let lost: Vec<f64> = tests
            .iter()
            .map(|state| {
                let q = DVector::from_iterator(overlay.len(), overlay.iter().map(|(i, l)| state.q[*i] * l));
                let put = &mean + &basis * (basis.transpose() * (q - &mean));
                let mut reduced = state.clone();
                for ((i, l), q) in overlay.iter().zip(&put) {
                    reduced.q[*i] = q / l;
                }
                let (full, reduced) = (tensions(state), tensions(&reduced));
                let scale = full.iter().sum::<f64>().abs() / full.len() as f64;
                full.iter()
                    .zip(&reduced)
                    .fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()))
                    / scale
            })
            .collect();
        let [median, tenth] = quantiles(&lost, [0.5, 0.9]);
        table.row(
            &format!("overlay on {count} of {} modes: tension lost", overlay.len()),
            format!(
                "{:.1} % in the median state, {:.1} % in the worst of ten",
                100.0 * median,
                100.0 * tenth
            ),
            json!({"modes": count, "median": median, "ninth_decile": tenth}),
        );
    }
}
