//! What the variator costs, on one core: `cargo fmu bench`.
//!
//! Prints one table and writes `target/bench.json` and the pictures `target/bench.svg`. Times are
//! processor time of the thread, the least of several runs, so what else the machine does matters
//! least; the ratios come from the same run. Counts (steps, residuals, factorizations) don't depend
//! on the machine. Arguments after `--`:
//!
//! - `--quick` runs everything once,
//! - `--errors` adds the errors against finer meshes and tighter tolerances (some minutes), with
//!   `--loads` those under loads too,
//! - `--cycle` adds 1800 s of driving (half a minute),
//! - `--loads` adds loads that jump, ripple or are noisy, 20 s each or as long as `--seconds` says
//!   (an hour, or minutes),
//! - `--only fg` runs the loads of these letters alone,
//! - `--real-time` adds these loads in real time, beside accurate runs with a tolerance of 1e-6,
//! - `--proposals` adds what separate integration and a reduced overlay would take.
//!
//! `cargo bench --package pushbelt-paper` compares the ring models of the paper.

mod cycle;
mod errors;
mod loads;
mod picture;
mod proposals;
mod real_time;
mod tracked;

use std::hint::black_box;
use std::path::PathBuf;

use clap::Parser;
use cpu_time::ThreadTime;
use pushbelt::contact::full_slip_torque;
use pushbelt::scalar::LANES;
use pushbelt::solver::State;
use pushbelt::solver::newton::{Counts, Newton};

use pushbelt::variator::diagnostics::belt::BeltDiagnostics;
use pushbelt::variator::run::Variator;
use pushbelt::variator::settings::Inputs;
use pushbelt::variator::settings::{Parameters, RingModel};
use pushbelt::variator::steady::solve::{SteadySolver, SteadyTask};
use pushbelt::variator::steady::start::{Start, kinematic_state};
use pushbelt::variator::system::VariatorSystem;
use pushbelt_support::bench::{STEP, manoeuvre, manoeuvre_row, print_row, step_parts, step_parts_row, text};
use pushbelt_support::load_cases::{LoadCase, pair, transmitted};
use pushbelt_support::manoeuvre::Manoeuvre;
use pushbelt_support::variators::{SPEED, variator};
use serde_json::{Value, json};

/// Points of the steady map.
const MAP_RATIOS: usize = 21;
const MAP_TORQUES: usize = 11;
/// F_S there, N.
const MAP_FORCE: f64 = 10e3;

#[derive(Parser)]
struct Options {
    /// Everything once
    #[arg(long)]
    quick: bool,
    /// Errors against finer meshes and a tighter tolerance; with --loads those under loads, too
    #[arg(long)]
    errors: bool,
    /// 1800 s of driving
    #[arg(long)]
    cycle: bool,
    /// Loads that jump, ripple or are noisy
    #[arg(long)]
    loads: bool,
    /// Letters of the loads that are run
    #[arg(long, default_value = "abcdefghij")]
    only: String,
    /// These loads in real time, beside accurate runs
    #[arg(long)]
    real_time: bool,
    /// Values of solver.effort for it
    #[arg(long, value_delimiter = ',', default_value = "4,8,13,16")]
    effort: Vec<i32>,
    /// How long each of these loads is run, s
    #[arg(long, default_value_t = 20.0)]
    seconds: f64,
    /// What separate integration of reference and overlay, and an overlay of few modes, would take
    #[arg(long)]
    proposals: bool,
    /// What cargo passes to every benchmark
    #[arg(long, hide = true)]
    bench: bool,
}

/// Lines of the table as they come.
#[derive(Default)]
struct Table(Vec<Value>);

impl Table {
    fn row(&mut self, name: &str, figure: String, data: Value) {
        print_row(name, &figure);
        self.0.push(json!({"name": name, "figure": figure, "data": data}));
    }
}

const MODELS: [RingModel; 2] = [RingModel::Ale, RingModel::Ale0];

fn main() {
    let options = Options::parse();
    let mut table = Table::default();
    table.row(
        "cells that a register of the processor holds",
        LANES.to_string(),
        json!(LANES),
    );
    let trace = Manoeuvre::read().trace(STEP);
    let costs = manoeuvres(&mut table, &trace, &options);
    steady_states(&mut table, &options);
    let growth = pieces_and_memory(&mut table, &trace);
    if options.cycle {
        cycle::rides(&mut table);
    }
    if options.loads {
        loads::measure(&mut table, &options.only, options.seconds);
    }
    if options.loads && options.errors {
        tracked::measure(&mut table, &options.only, options.seconds);
    }
    if options.real_time {
        real_time::measure(&mut table, &options.only, &options.effort, options.seconds);
    }
    if options.proposals {
        proposals::measure(&mut table, &trace);
    }
    let file = target().join("bench.svg");
    match picture::draw(&file, &growth, &costs) {
        Ok(()) => println!("drawn in {}", file.display()),
        Err(error) => eprintln!("{}: {error}", file.display()),
    }
    let file = target().join("bench.json");
    let text = serde_json::to_string_pretty(&table.0).expect("plain numbers");
    match std::fs::write(&file, text) {
        Ok(()) => println!("written to {}", file.display()),
        Err(error) => eprintln!("{}: {error}", file.display()),
    }
}

fn target() -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| "target".into(), PathBuf::from)
}

/// Times of the communication steps, s, of both ring models.
fn manoeuvres(table: &mut Table, trace: &[Inputs], options: &Options) -> [Vec<f64>; 2] {
    let costs = MODELS.map(|model| {
        let runs = if options.quick { 1 } else { 5 };
        // A look at the clock takes 4 % of a step of ALE0.
        let run = best(runs, || {
            manoeuvre(|| manoeuvre_variator(variator(model)), trace, |advance| advance())
        });
        let (_, each) = best(runs, || {
            let mut each = Vec::with_capacity(trace.len());
            let (time, _) = manoeuvre(
                || manoeuvre_variator(variator(model)),
                trace,
                |advance| {
                    let start = ThreadTime::now();
                    advance();
                    each.push(start.elapsed().as_secs_f64());
                },
            );
            (time, each)
        });
        add_manoeuvre(table, &format!("{model:?}"), trace, run);
        let slowest = quantiles(&each, [0.5, 0.999, 1.0]);
        table.row(
            &format!("  its communication steps, {model:?}: median, 99.9 %, longest"),
            slowest.map(|t| format!("{:.2} ms", 1e3 * t)).join(", "),
            json!({"seconds": slowest}),
        );
        if options.errors {
            errors::of_manoeuvre(table, model, trace);
            let mut parameters = variator(model);
            parameters.friction.fall = 0.0;
            let run = manoeuvre(|| manoeuvre_variator(parameters), trace, |advance| advance());
            add_manoeuvre(table, &format!("{model:?}, friction.fall = 0"), trace, run);
        }
        each
    });
    let [ale, ale0] = [&costs[0], &costs[1]].map(|each| each.iter().sum::<f64>());
    table.row("  ALE / ALE0", format!("{:.1}", ale / ale0), json!(ale / ale0));
    costs
}

/// The values below which such shares of all lie.
fn quantiles<const N: usize>(values: &[f64], shares: [f64; N]) -> [f64; N] {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    shares.map(|share| sorted[(share * (sorted.len() - 1) as f64) as usize])
}

fn steady_states(table: &mut Table, options: &Options) {
    let quick = options.quick;
    for model in MODELS {
        let (time, (counts, ratios)) =
            best(if quick { 1 } else { 5 }, || nine_steady_states(variator(model), 1));
        let solved = ratios.iter().flatten().count();
        table.row(
            &format!("nine steady states, cold, {model:?}"),
            format!("{time:.2} s, {solved} solved, {}", text(&counts)),
            json!({"seconds": time, "solved": solved, "counts": numbers(&counts)}),
        );
        if options.errors {
            errors::of_steady_states(table, model, &ratios);
        }
        let (time, ()) = best(if quick { 1 } else { 10 }, || steady_start(model));
        table.row(
            &format!("from parameters to the first step, steady start, {model:?}"),
            format!("{:.0} ms", 1e3 * time),
            json!({"seconds": time}),
        );
    }
    for model in MODELS {
        let Map {
            time,
            warm_time,
            counts,
            solved,
            warm,
        } = steady_map(model);
        let points = MAP_RATIOS * MAP_TORQUES;
        table.row(
            &format!("steady map, {MAP_RATIOS} ratios x {MAP_TORQUES} torques, {model:?}"),
            format!(
                "{time:.2} s; {solved} of {points} solved, {warm} from their neighbour in {:.1} ms each, {}",
                1e3 * warm_time / warm as f64,
                text(&counts)
            ),
            json!({
                "seconds": time,
                "warm_seconds": warm_time,
                "solved": solved,
                "warm": warm,
                "points": points,
                "counts": numbers(&counts),
            }),
        );
    }
}

/// Cost of what a step is made of, on three meshes, of both ring models.
fn pieces_and_memory(table: &mut Table, trace: &[Inputs]) -> [[Pieces; 3]; 2] {
    MODELS.map(|model| {
        let pieces = [1, 2, 4].map(|factor| pieces(variator(model), factor));
        for p in &pieces {
            add_pieces(table, &format!("{model:?}"), p);
        }
        let growth = pieces[2].whole() / pieces[0].whole();
        table.row(
            "  four times the elements / once",
            format!("{growth:.2}"),
            json!(growth),
        );
        let (allocations, bytes) = memory(model, trace);
        table.row(
            &format!("allocations in 100 steps; memory of an instance, {model:?}"),
            format!("{allocations}; {:.2} MB", bytes as f64 / 1e6),
            json!({"allocations": allocations, "bytes": bytes}),
        );
        pieces
    })
}

/// Least time of several runs, with what its run returned.
fn best<A>(runs: usize, mut run: impl FnMut() -> (f64, A)) -> (f64, A) {
    let first = run();
    (1..runs)
        .map(|_| run())
        .fold(first, |a, b| if b.0 < a.0 { b } else { a })
}

fn numbers(counts: &Counts) -> Value {
    json!({
        "steps": counts.steps,
        "rejected": counts.rejected,
        "failed": counts.failed,
        "residuals": counts.residuals,
        "factorizations": counts.factorizations,
    })
}

fn add_manoeuvre(table: &mut Table, name: &str, trace: &[Inputs], (time, counts): (f64, Counts)) {
    let (name, figure) = manoeuvre_row(name, trace, time, &counts);
    let factor = trace.len() as f64 * STEP / time;
    table.row(
        &name,
        figure,
        json!({"seconds": time, "real_time_factor": factor, "counts": numbers(&counts)}),
    );
}

fn add_pieces(table: &mut Table, name: &str, pieces: &Pieces) {
    let Pieces { elements, seconds } = *pieces;
    let (name, figure) = step_parts_row(&format!("{name}, {elements} elements"), seconds);
    table.row(&name, figure, json!({"elements": elements, "seconds": seconds}));
}

/// The variator of the manoeuvre with these parameters.
fn manoeuvre_variator(parameters: Parameters) -> Variator {
    Variator::new(Manoeuvre::variator(parameters)).expect("valid parameters")
}

/// Steady states of the nine load cases on a mesh with so many times the elements: ratio held on P,
/// primary speed given, belt torque 30, 50, 100 N·m. Time, work, and the thrust ratios that were
/// found.
fn nine_steady_states(mut parameters: Parameters, refinement: i32) -> (f64, (Counts, Vec<Option<f64>>)) {
    parameters.mesh = parameters.mesh.refined(refinement);
    let start = ThreadTime::now();
    let mut total = Counts::default();
    let mut ratios = Vec::new();
    for case in [30.0, 50.0, 100.0]
        .map(|torque| LoadCase::three(&parameters, torque))
        .concat()
    {
        let mut system = VariatorSystem::new(&parameters);
        let task = case.task();
        let start = Start {
            ratio: task.ratio,
            primary_speed: SPEED,
            clamping: task.clamping,
        };
        let mut state = kinematic_state(&system.belt, &start).expect("a start");
        let mut newton = Newton::new(&system);
        let mut solver = SteadySolver {
            system: &mut system,
            newton: &mut newton,
        };
        let found = solver.solve(&mut state, &task);
        ratios.push(found.ok().map(|_| {
            let axial = BeltDiagnostics::new(&system, state.view()).sums.axial;
            axial.primary / axial.secondary
        }));
        total += newton.counts;
    }
    (start.elapsed().as_secs_f64(), (total, ratios))
}

/// What a steady map took.
struct Map {
    /// Processor time, s.
    time: f64,
    /// That of the points found from their neighbour, s.
    warm_time: f64,
    counts: Counts,
    solved: usize,
    /// How many from their neighbour.
    warm: usize,
}

/// Thrust-ratio map at 2000 rpm and F_S = 10 kN: i from 2.2 to 0.45, 5 to 65 % of the primary
/// pulley's capacity. The first torque of a ratio starts from the kinematic state, each other one
/// from its neighbour's state, or where that leads nowhere from the kinematic one.
fn steady_map(model: RingModel) -> Map {
    let parameters = variator(model);
    let (mut solved, mut warm, mut warm_time) = (0, 0, 0.0);
    let start = ThreadTime::now();
    let mut system = VariatorSystem::new(&parameters);
    let mut newton = Newton::new(&system);
    for i in 0..MAP_RATIOS {
        let ratio = 2.2 * (0.45_f64 / 2.2).powf(i as f64 / (MAP_RATIOS - 1) as f64);
        let radius = system.belt.curve.radii(ratio).expect("the belt closes").primary;
        let capacity = full_slip_torque(
            &parameters.friction,
            parameters.geometry.wedge_angle.cos(),
            MAP_FORCE,
            radius - parameters.belt.pitch_offset,
        );
        let mut neighbour: Option<State> = None;
        for k in 0..MAP_TORQUES {
            let share = 0.05 + 0.6 * k as f64 / (MAP_TORQUES - 1) as f64;
            let task = transmitted(ratio, MAP_FORCE, share * capacity);
            let cold = Start {
                ratio,
                primary_speed: SPEED,
                clamping: pair(MAP_FORCE, MAP_FORCE),
            };
            let kinematic = kinematic_state(&system.belt, &cold).expect("a start");
            let mut find = |mut state: State, warm: bool| {
                let task = SteadyTask { warm, ..task };
                let mut solver = SteadySolver {
                    system: &mut system,
                    newton: &mut newton,
                };
                let found = solver.solve(&mut state, &task);
                found.ok().map(|_| state)
            };
            let clock = ThreadTime::now();
            let from_neighbour = neighbour.take().and_then(|state| find(state, true));
            if from_neighbour.is_some() {
                warm += 1;
                warm_time += clock.elapsed().as_secs_f64();
            }
            neighbour = from_neighbour.or_else(|| find(kinematic, false));
            solved += usize::from(neighbour.is_some());
        }
    }
    Map {
        time: start.elapsed().as_secs_f64(),
        warm_time,
        counts: newton.counts,
        solved,
        warm,
    }
}

fn steady_start(model: RingModel) -> (f64, ()) {
    let start = ThreadTime::now();
    let mut variator = Variator::new(variator(model)).expect("valid parameters");
    variator.initialise(0.0, &Inputs::default()).expect("a start");
    variator.advance(STEP, &Inputs::default()).expect("a step");
    black_box(variator.outputs());
    (start.elapsed().as_secs_f64(), ())
}

struct Pieces {
    elements: usize,
    /// Residual, Jacobian, factors, solve, s.
    seconds: [f64; 4],
}

impl Pieces {
    fn whole(&self) -> f64 {
        self.seconds.iter().sum()
    }
}

/// Cost of what a step is made of, with `factor` times the default elements.
fn pieces(mut parameters: Parameters, factor: i32) -> Pieces {
    parameters.mesh = parameters.mesh.refined(factor);
    let mut system = VariatorSystem::new(&parameters);
    Pieces {
        elements: system.belt.mesh.elements.len(),
        seconds: step_parts(&mut system),
    }
}

/// Allocations in 100 communication steps of the launch, and the bytes that an instance holds.
fn memory(model: RingModel, trace: &[Inputs]) -> (u64, u64) {
    let mut instance = None;
    let held = allocation_counter::measure(|| {
        let mut variator = manoeuvre_variator(variator(model));
        variator.initialise(0.0, &trace[0]).expect("a start");
        instance = Some(variator);
    });
    let mut variator = instance.expect("just built");
    let _ = variator.take_messages();
    let steps = allocation_counter::measure(|| {
        for (k, inputs) in trace[..100].iter().enumerate() {
            variator.advance((k + 1) as f64 * STEP, inputs).expect("a step");
        }
    });
    (steps.count_total, held.bytes_current.max(0) as u64)
}
