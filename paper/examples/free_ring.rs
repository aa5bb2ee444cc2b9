//! The free ring of the paper's 5.3, as a benchmark for beam codes: a steel band without supports,
//! 0.70 m around, 0.185 mm × 9.5 mm, E = 2.1e11 N/m², ρ = 7800 kg/m³, stress-free when straight.
//!
//! `cargo run --release --package pushbelt-paper --example free_ring -- --model rcm --shape
//! two-arc`
//!
//! - `--shape circle`: a small oscillation about the circle in its first bending mode. A thin ring
//!   has f₂ = (1/2π) √(36/5) √(EI/(m R⁴)) = 9.534 Hz.
//! - `--shape two-arc`: from rest on a belt's shape around two pulleys (Θ = 0.4, axes 0.155 m
//!   apart); an independent nonlinear code, Exudyn, has 9.26 Hz with 40 elements and 9.22 Hz with
//!   80.
//!
//! The frequency is that of the zero crossings of the ovality ∮(x − x̄)² − (y − ȳ)² dξ.

use clap::{Parser, ValueEnum};
use cpu_time::ProcessTime;
use nalgebra::Vector2;
use pushbelt::solver::State;
use pushbelt::solver::sdirk::Sdirk;
use pushbelt_paper::reference_curve::{ReferenceCurve, TwoPulley};
use pushbelt_paper::ring::Ring;
use pushbelt_paper::ring::ale_ring::AleRing;
use pushbelt_paper::ring::ancf::Ancf;
use pushbelt_paper::ring::mesh::RingMesh;
use pushbelt_paper::ring::model::RingFormulation;
use pushbelt_paper::ring::rcm::Rcm;
use pushbelt_paper_lab::{Circle, RingSystem, advance};
use std::error::Error;
use std::f64::consts::TAU;
use std::time::Duration;

const LENGTH: f64 = 0.70;
const RADIUS: f64 = LENGTH / TAU;
const STEADY: &str = "the ring has not crossed roundness twice: give it more --time";

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Model {
    /// Deflection from a circle in the Eulerian view (bending measure linear in it).
    Ale,
    /// Co-rotational, redundant coordinates.
    Rcm,
    /// Absolute nodal coordinates.
    Ancf,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Shape {
    Circle,
    TwoArc,
}

/// Free oscillation of a steel band.
#[derive(Debug, Parser)]
struct Arguments {
    #[arg(long, default_value = "ale")]
    model: Model,
    #[arg(long, default_value = "circle")]
    shape: Shape,
    /// Number of elements; 40, or 32 of the co-rotational model, have 160 degrees of freedom.
    #[arg(long)]
    elements: Option<usize>,
    /// Time to simulate, s.
    #[arg(long, default_value_t = 0.25)]
    time: f64,
    /// Sampling interval and largest step, s.
    #[arg(long, default_value_t = 2.5e-4)]
    interval: f64,
    /// Position error of a step, in units of the length.
    #[arg(long, default_value_t = 1.0e-5)]
    tolerance: f64,
    /// Tolerance of Newton's method, in units of 1e-9 of the length.
    #[arg(long, default_value_t = 1.0)]
    newton: f64,
}

fn band() -> Ring {
    let (e, rho, width, thickness) = (2.1e11, 7800.0, 9.5e-3_f64, 0.185e-3_f64);
    Ring {
        mass_per_length: rho * thickness * width,
        axial_stiffness: e * thickness * width,
        bending_stiffness: e * width * thickness.powi(3) / 12.0,
        lateral_bending_stiffness: e * thickness * width.powi(3) / 12.0,
        damping: 0.0,
    }
}

fn ovality<M: RingFormulation>(system: &RingSystem<M>, state: &State) -> f64 {
    let mean = |f: &dyn Fn(Vector2<f64>) -> f64| system.integrate(state.view(), |p| f(p.r)) / LENGTH;
    let (x, y) = (mean(&|r| r.x), mean(&|r| r.y));
    mean(&|r| (r.x - x).powi(2) - (r.y - y).powi(2))
}

fn start<M: RingFormulation>(system: &mut RingSystem<M>, shape: Shape) -> Result<State, Box<dyn Error>> {
    match shape {
        Shape::Circle => {
            let mut state = system.rest(0.0);
            // Inextensible: a cos 2θ radially, −½ a sin 2θ tangentially; a = 1e-3 R.
            let speed = 1.0e-3 * RADIUS * TAU * 9.534;
            system.set_in_motion(&mut state, |xi| {
                let (sin, cos) = (xi / RADIUS).sin_cos();
                let (sin2, cos2) = (2.0 * xi / RADIUS).sin_cos();
                (Vector2::new(-cos, sin) * cos2 - Vector2::new(sin, cos) * (0.5 * sin2)) * speed
            })?;
            Ok(state)
        }
        Shape::TwoArc => {
            let curve = TwoPulley::new(0.155, LENGTH);
            let frame = curve.frame::<f64>(0.4);
            // The circle's leftmost point is unchanged.
            let shift = curve.at(&frame, 0.0).r + Vector2::new(RADIUS, 0.0);
            let mut state = system.rest_on(0.0, &|xi| {
                let point = curve.at(&frame, xi);
                [point.r - shift, point.t]
            });
            // Cubic elements across an arc's border are stretched. This relaxes before the bending
            // starts.
            system
                .settle(&mut state, 1.0e-5, 20)
                .map_err(|stalled| format!("{stalled:?}"))?;
            Ok(state)
        }
    }
}

fn swing<M: RingFormulation>(model: M, arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let mut system = RingSystem::new(model);
    system.tolerance = arguments.tolerance;
    let mut state = start(&mut system, arguments.shape)?;
    let energy = system.energy(state.view()).total();
    let mut integrator = Sdirk::new(&system, arguments.interval, 1.0e-2);
    integrator.newton_tolerance = arguments.newton;
    let mut spent = Duration::ZERO;
    let samples = (arguments.time / arguments.interval).ceil();
    let step = arguments.time / samples;
    let (mut crossings, mut drift, mut before) = (Vec::new(), 0.0_f64, ovality(&system, &state));
    for k in 0..samples as usize {
        let t = k as f64 * step;
        let clock = ProcessTime::now();
        advance(&mut integrator, &mut system, &mut state, [t, t + step])?;
        spent += clock.elapsed();
        let now = ovality(&system, &state);
        if k > 0 && before * now < 0.0 {
            crossings.push(t + step * before / (before - now));
        }
        before = now;
        drift = drift.max((system.energy(state.view()).total() / energy - 1.0).abs());
    }
    let (Some(first), Some(last)) = (crossings.first(), crossings.last()) else {
        return Err(STEADY.into());
    };
    if crossings.len() < 2 {
        return Err(STEADY.into());
    }
    println!(
        "elements {}, degrees of freedom {}",
        system.model.elements(),
        system.degrees_of_freedom()
    );
    println!(
        "frequency {:.4} Hz",
        0.5 * (crossings.len() - 1) as f64 / (last - first)
    );
    println!("energy drift {drift:.2e} of {energy:.6} J");
    println!("work {:?}", integrator.newton.counts);
    println!("CPU time {:.2} ms", 1e3 * spent.as_secs_f64());
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    let circle = Circle { radius: RADIUS };
    let elements = |usual: usize| arguments.elements.unwrap_or(usual);
    match arguments.model {
        Model::Ale => swing(
            AleRing::flexible(band(), circle, RingMesh::even(&[elements(40)], 3)),
            &arguments,
        ),
        Model::Rcm => swing(Rcm::new(band(), circle, elements(32), 5), &arguments),
        Model::Ancf => swing(Ancf::new(band(), circle, elements(40), 3), &arguments),
    }
}
