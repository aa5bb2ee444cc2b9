//! The ring tests of the paper's 5.3, for every ring model, as CSV files for `cargo fmu paper`.
//!
//! `cargo run --release --package pushbelt-paper --example paper_rings -- --output
//! target/paper/rings`
//!
//! The measurements are those of the tests of the ring (`pushbelt_paper_lab`). Each line of the
//! output is a finished job: its number, the number of jobs, and its name.

mod tables;

use clap::Parser;
use cpu_time::ProcessTime;
use nalgebra::SymmetricEigen;
use pushbelt::solver::State;
use pushbelt::solver::newton::Counts;
use pushbelt::variator::Variator;
use pushbelt::variator::ring_models::{self, BeltRing};
use pushbelt::variator::settings::RingModel;
use pushbelt_paper::belts::Rotated;
use pushbelt_paper::reference_curve::{ReferenceCurve, TwoPulley, Unaligned};
use pushbelt_paper::ring::ale_ring::AleRing;
use pushbelt_paper::ring::mesh::RingMesh;
use pushbelt_paper::ring::model::RingFormulation;
use pushbelt_paper_lab::*;
use pushbelt_support::bench::{STEP, manoeuvre};
use pushbelt_support::checks::orders;
use pushbelt_support::manoeuvre::Manoeuvre;
use pushbelt_support::variators::variator;
use std::f64::consts::TAU;
use std::fmt::Debug;
use std::fs;
use std::io;
use std::path::PathBuf;
use std::sync::Arc;
use tables::Table;

/// Elements of the paper's fig. 7.
const EIGHT: usize = 8;
/// Points of an outline.
const OUTLINE: usize = 96;
/// Name of the reference motion alone.
const ALE0: &str = "ALE0";
/// Name of the ring on a mesh that does not follow its arcs.
const EVEN: &str = "ALE, evenly spaced mesh";

/// Rings alone: the paper's tests, as CSV files.
#[derive(Debug, Parser)]
struct Arguments {
    /// Folder for the CSV files.
    #[arg(long)]
    output: PathBuf,
    /// Coarser ladders and wider tolerances.
    #[arg(long)]
    short: bool,
}

/// Extent of the computations.
#[derive(Clone, Copy)]
struct Plan {
    /// Tolerance of the energy runs of fig. 6 and 7.
    tolerance: f64,
    /// Steps per turn of a running ring on a travelling mesh.
    turn_steps: usize,
    /// Meshes of the frequency table.
    meshes: &'static [usize],
    /// Number of runs for computing times.
    repetitions: usize,
    /// Whether orders of convergence are computed.
    orders: bool,
}

const FULL: Plan = Plan {
    tolerance: 1.0e-7,
    turn_steps: 1600,
    meshes: &[10, 20, 40, 80, 160],
    repetitions: 5,
    orders: true,
};

const SHORT: Plan = Plan {
    tolerance: 1.0e-6,
    turn_steps: 400,
    meshes: &[20, 40],
    repetitions: 1,
    orders: false,
};

struct Tables {
    checks: Table,
    frequencies: Table,
    orders: Table,
    motions: Table,
    shapes: Table,
    work: Table,
}

impl Tables {
    fn new() -> Self {
        Self {
            checks: Table::new(
                "checks.csv",
                "check,statement,model,value [SI],reference [SI],low [SI],high [SI],passed",
            ),
            frequencies: Table::new(
                "frequencies.csv",
                "case,model,elements [1],frequency [Hz],reference [Hz]",
            ),
            orders: Table::new(
                "orders.csv",
                "model,quantity,expected [1],resolution [SI],error [SI],order [1]",
            ),
            motions: Table::new(
                "motions.csv",
                "figure,model,time [s],theta [1],drift [m],kinetic [J],membrane [J],bending [J],bulge [m],ovality [m2]",
            ),
            shapes: Table::new("shapes.csv", "figure,model,time [s],x [m],y [m]"),
            work: Table::new(
                "work.csv",
                "case,model,elements [1],run [1],cpu [s],steps [1],rejected [1],residuals [1],factorizations [1]",
            ),
        }
    }

    /// A value that must lie within `bound` of `reference`.
    fn check(&mut self, check: &str, statement: &str, model: &str, value: f64, reference: f64, bound: f64) {
        let judged = if (value - reference).abs() <= bound {
            "yes"
        } else {
            "no"
        };
        let limits = [Some(reference - bound), Some(reference + bound)];
        self.judge(check, statement, model, value, Some(reference), limits, judged);
    }

    /// A value that must be at least `low`.
    fn check_at_least(&mut self, check: &str, statement: &str, model: &str, value: f64, low: f64) {
        let judged = if value >= low { "yes" } else { "no" };
        self.judge(check, statement, model, value, None, [Some(low), None], judged);
    }

    /// A value that is reported without a check, with a reference if there is one.
    fn report(&mut self, check: &str, statement: &str, model: &str, value: f64, reference: Option<f64>) {
        self.judge(check, statement, model, value, reference, [None; 2], "reported");
    }

    #[expect(clippy::too_many_arguments, reason = "one a column")]
    fn judge(
        &mut self,
        check: &str,
        statement: &str,
        model: &str,
        value: f64,
        reference: Option<f64>,
        [low, high]: [Option<f64>; 2],
        judged: &str,
    ) {
        self.checks
            .add(row![check, statement, model, value, reference, low, high, judged]);
    }

    fn work(&mut self, case: &str, model: &str, elements: usize, run: usize, cpu: f64, counts: &Counts) {
        self.work.add(row![
            case,
            model,
            elements,
            run,
            cpu,
            counts.steps,
            counts.rejected,
            counts.residuals,
            counts.factorizations,
        ]);
    }

    /// Energies and coordinates at every sample, outlines at every second.
    fn record<M: RingFormulation>(
        &mut self,
        figure: &str,
        model: &str,
        curve: &TwoPulley,
        system: &RingSystem<M>,
        record: &Record,
    ) {
        for (k, sample) in record.samples.iter().enumerate() {
            let [upper, lower] = bulges(curve, system, &sample.state);
            self.motions.add(row![
                figure,
                model,
                sample.time,
                sample.theta,
                sample.drift,
                sample.energy.kinetic,
                sample.energy.membrane,
                sample.energy.bending,
                0.5 * (upper + lower),
                ovality(system, &sample.state),
            ]);
            if k % 2 == 0 {
                for point in outline(system, &sample.state) {
                    self.shapes.add(row![figure, model, sample.time, point[0], point[1]]);
                }
            }
        }
    }

    /// Errors at successively halved steps or elements.
    fn ladder(&mut self, model: &str, quantity: &str, expected: f64, resolution: [f64; 3], errors: [f64; 3]) {
        let observed = orders(&errors, 2.0);
        for k in 0..3_usize {
            let order = k.checked_sub(1).map(|k| observed[k]);
            self.orders
                .add(row![model, quantity, expected, resolution[k], errors[k], order]);
        }
        let worst = observed
            .into_iter()
            .max_by(|a, b| (a - expected).abs().total_cmp(&(b - expected).abs()))
            .expect("two orders");
        self.check("6", &format!("order of {quantity}"), model, worst, expected, 0.2);
    }

    fn write(&self, folder: &std::path::Path) -> io::Result<()> {
        fs::create_dir_all(folder)?;
        [
            &self.checks,
            &self.frequencies,
            &self.orders,
            &self.motions,
            &self.shapes,
            &self.work,
        ]
        .into_iter()
        .try_for_each(|table| table.write(folder))
    }
}

fn outline<M: RingFormulation>(system: &RingSystem<M>, state: &State) -> impl Iterator<Item = [f64; 2]> {
    let length = system.model.length();
    (0..=OUTLINE).map(move |k| {
        let xi = length * (k % OUTLINE) as f64 / OUTLINE as f64;
        system.particle_at(state.view(), xi).r.into()
    })
}

type Job = (String, Box<dyn FnOnce(&mut Tables)>);

/// Adds a job.
fn job(jobs: &mut Vec<Job>, name: impl Into<String>, work: impl FnOnce(&mut Tables) + 'static) {
    jobs.push((name.into(), Box::new(work)));
}

/// The reference motion alone (paper fig. 6).
fn reference_motion(jobs: &mut Vec<Job>, plan: Plan) {
    job(jobs, "ALE0: reference numbers", |tables| {
        for expected in REFERENCE_NUMBERS {
            let found = reference_numbers(expected.theta);
            let at = format!("at Θ = {}", expected.theta);
            tables.check(
                "2",
                &format!("bending energy {at}, J"),
                ALE0,
                found.energy,
                expected.energy,
                0.06,
            );
            tables.check(
                "2",
                &format!("M_ΘΘ {at}, kg·m²"),
                ALE0,
                found.mass,
                expected.mass,
                6.0e-6,
            );
            tables.check(
                "2",
                &format!("M_sΘ {at}, kg·m"),
                ALE0,
                found.coupling,
                expected.coupling,
                1.0e-12,
            );
        }
        let omega = reference_frequency();
        tables.check(
            "2",
            "small oscillation, rad/s",
            ALE0,
            omega,
            REFERENCE_FREQUENCY,
            5.0e-3,
        );
    });
    job(jobs, "ALE0: reference oscillation", move |tables| {
        let mesh = RingMesh::even(&[2, 2, 4, 2, 2], 5);
        let Oscillation { system, record, swing } =
            reference_oscillation(solid_curve(), mesh, 0.1 * plan.tolerance);
        let (low, high) = record.ratios();
        let drift = record.energy_drift() / swing;
        tables.check("2", "energy drift, of the swing's energy", ALE0, drift, 0.0, 1.0e-3);
        tables.check("2", "largest |s|, m", ALE0, record.largest_drift(), 0.0, 1.0e-9);
        tables.check("2", "smallest Θ of the swing", ALE0, low, -0.4, 0.01);
        tables.check("2", "largest Θ of the swing", ALE0, high, 0.4, 0.01);
        tables.record("6", ALE0, &solid_curve(), &system, &record);
    });
    for even in [false, true] {
        let name = if even {
            "ALE0, evenly spaced mesh"
        } else {
            "ALE0, 24 elements"
        };
        job(jobs, format!("{name}: reference oscillation"), move |tables| {
            if even {
                let curve = Unaligned { curve: solid_curve() };
                swing(tables, name, curve, RingMesh::even(&[24], 3));
            } else {
                swing(tables, name, solid_curve(), RingMesh::even(&[3, 6, 6, 6, 3], 3));
            }
        });
    }
    if plan.orders {
        job(jobs, "ALE0: order in time", |tables| {
            let steps = [1.0e-4, 5.0e-5, 2.5e-5];
            let errors = reference_time_errors(steps);
            tables.ladder(ALE0, "Θ in time (resolution: step, s)", 2.0, steps, errors);
        });
    }
}

/// The reference oscillation on a mesh that follows the arcs or does not.
fn swing<C: ReferenceCurve + Debug>(tables: &mut Tables, name: &str, curve: C, mesh: RingMesh) {
    let Oscillation { system, record, swing } = reference_oscillation(curve, mesh, 1.0e-7);
    let drift = record.energy_drift() / swing;
    tables.report("2", "energy drift, of the swing's energy", name, drift, None);
    tables.record("6", name, &solid_curve(), &system, &record);
}

/// The paper's fig. 6 and 7 on the ring of a belt: all its layers, and one of them. Both last as
/// many bending times as the figures of the thick ring.
fn belt_rings(jobs: &mut Vec<Job>, plan: Plan) {
    job(jobs, "ring of bench168: reference oscillation", move |tables| {
        let specimen = Specimen::bench168();
        let scale = specimen.bending_time() / Specimen::thick().bending_time();
        let mesh = RingMesh::even(&[2, 2, 4, 2, 2], 5);
        let system = RingSystem::new(AleRing::rigid(specimen.ring.clone(), specimen.curve.clone(), mesh));
        let Oscillation { system, record, swing } = oscillation(system, 0.1 * plan.tolerance, 2.0e-4 * scale);
        let name = specimen.name;
        let drift = record.energy_drift() / swing;
        let (low, high) = record.ratios();
        tables.check("2", "energy drift, of the swing's energy", name, drift, 0.0, 1.0e-3);
        tables.check("2", "largest |s|, m", name, record.largest_drift(), 0.0, 1.0e-9);
        tables.check("2", "smallest Θ of the swing", name, low, -0.4, 0.01);
        tables.check("2", "largest Θ of the swing", name, high, 0.4, 0.01);
        tables.record("6 belt", name, &specimen.curve, &system, &record);
    });
    released::<Ale>(jobs, plan, Specimen::bench168(), EIGHT);
    released::<Ale>(jobs, plan, Specimen::bench168(), 40);
    released::<Ale>(jobs, plan, Specimen::layer(), EIGHT);
    released::<CoRotational>(jobs, plan, Specimen::bench168(), 32);
}

/// The paper's fig. 7 with the ring of a belt.
fn released<S: Case + 'static>(jobs: &mut Vec<Job>, plan: Plan, specimen: Specimen, elements: usize) {
    let name = format!("{}, {}, {elements} elements", S::NAME, specimen.name);
    job(jobs, format!("{name}: deformable ring"), move |tables| {
        let step = 5.0e-5 * specimen.bending_time() / Specimen::thick().bending_time();
        let (system, record) = released_ring::<S>(&specimen, elements, plan.tolerance, step, 80);
        let drift = record.energy_drift() / record.samples[0].energy.total();
        tables.report("3", "energy drift, relative", &name, drift, None);
        tables.report("3", "largest Θ", &name, record.ratios().1, None);
        tables.record("7 belt", &name, &specimen.curve, &system, &record);
    });
}

/// Ratio of smallest to largest eigenvalue of the mass matrix, without held unknowns and with those
/// of the model, in units in which every overlay has the mass of a node.
fn mass_condition<C: ReferenceCurve + Debug>(system: &RingSystem<AleRing<C>>) -> [f64; 2] {
    let mass = system.mass_matrix(&system.rest(0.4).q);
    let scaled = |free: &[usize]| {
        let part = mass.select_rows(free).select_columns(free);
        let size = part.diagonal().map(f64::sqrt);
        let unit = part.component_div(&(&size * size.transpose()));
        let values = SymmetricEigen::new(unit).eigenvalues;
        values.min() / values.max()
    };
    let all: Vec<usize> = (0..=system.theta()).collect();
    let free: Vec<usize> = all.iter().copied().filter(|i| !system.held.contains(i)).collect();
    [scaled(&all), scaled(&free)]
}

/// The paper's fig. 7 for Eulerian rings that deflect.
fn eulerian_rings(jobs: &mut Vec<Job>, plan: Plan) {
    job(jobs, "ALE: what locking a node is for", |tables| {
        let curve = solid_curve();
        let ring = |mesh: RingMesh| RingSystem::new(AleRing::flexible(solid(), curve.clone(), mesh));
        let [all, free] = mass_condition(&ring(RingMesh::even(&[1, 2, 2, 2, 1], 3)));
        let name = "ALE, 8 elements";
        tables.report("3", "smallest/largest eigenvalue of M, nothing locked", name, all, None);
        tables.report("3", "smallest/largest eigenvalue of M, node 0 locked", name, free, None);
    });
    job(jobs, format!("{EVEN}: deformable ring"), move |tables| {
        let curve = Unaligned { curve: solid_curve() };
        let mut system = RingSystem::new(AleRing::flexible(solid(), curve, RingMesh::even(&[EIGHT], 3)));
        system.tolerance = plan.tolerance;
        let start = system.rest(0.4);
        let record = record(&mut system, start, 1.0e-6, 5.0e-5, 80, 0.95);
        let drift = record.energy_drift() / record.samples[0].energy.total();
        tables.report("3", "energy drift over 4 ms, relative", EVEN, drift, None);
        tables.record("7", EVEN, &solid_curve(), &system, &record);
    });
}

/// Computing effort of the manoeuvre of the FMU with A_i = identity and [t, n].
fn manoeuvres(jobs: &mut Vec<Job>) {
    let rings: [(&str, Arc<dyn BeltRing>); 2] = [
        (Ale::NAME, Arc::new(ring_models::Ale::<2>)),
        (AleTurning::NAME, Arc::new(Rotated::<2>)),
    ];
    for (name, ring) in rings {
        job(jobs, format!("{name}: manoeuvre"), move |tables| {
            let parameters = Manoeuvre::variator(variator(RingModel::Ale));
            let mesh = &parameters.mesh;
            let elements = (mesh.primary_arc + mesh.secondary_arc + 2 * mesh.strand) as usize;
            let build = || Variator::with_ring(parameters, ring).expect("valid parameters");
            let (cpu, counts) = manoeuvre(build, &Manoeuvre::read().trace(STEP), |advance| advance());
            tables.work("manoeuvre, 10 s", name, elements, 0, cpu, &counts);
        });
    }
}

/// Checks of every model.
fn model<S: Case + 'static>(jobs: &mut Vec<Job>, plan: Plan) {
    job(jobs, format!("{}: derivatives", S::NAME), |tables| {
        let check = |tables: &mut Tables, what: &str, off: f64, bound: f64| {
            tables.check("1", what, S::NAME, off, 0.0, bound);
        };
        check(tables, "P against differences, m", velocity_error::<S, _, _>(), 1.0e-8);
        check(
            tables,
            "−∂V/∂q against differences, relative",
            elastic_force_error::<S, _, _>(),
            1.0e-7,
        );
        check(
            tables,
            "inertia against differences of M, relative",
            inertia_error::<S, _, _>(),
            1.0e-8,
        );
    });
    job(jobs, format!("{}: deformable ring", S::NAME), move |tables| {
        let (system, record) = deformable_ring::<S>(FEW, 1.0e-7, 4);
        let drift = record.energy_drift() / record.samples[0].energy.total();
        tables.check("3", "energy drift over 0.2 ms, relative", S::NAME, drift, 0.0, 1.0e-4);
        let [upper, lower] = bulges(&solid_curve(), &system, &record.samples[4].state);
        let what = "bulge of the strands at 0.2 ms, m (outwards)";
        tables.check_at_least("3", what, S::NAME, 0.5 * (upper + lower), 2.0e-3);
        let (system, record) = deformable_ring::<S>(EIGHT, plan.tolerance, 80);
        let drift = record.energy_drift() / record.samples[0].energy.total();
        tables.report("3", "energy drift over 4 ms, relative", S::NAME, drift, None);
        tables.record("7", S::NAME, &solid_curve(), &system, &record);
    });
    job(jobs, format!("{}: running ring", S::NAME), move |tables| {
        let travels = S::Model::<TwoPulley>::LAGRANGIAN;
        let found = running_ring::<S>(40, if travels { plan.turn_steps } else { 0 });
        // The error of a travelling ring is that of the integrator over a turn.
        let (bound, strain_bound) = match (travels, plan.orders) {
            (false, _) => (1.0e-9, 1.0e-2),
            (true, true) => (2.0e-6, 1.0e-2),
            // The short form has steps four times as long.
            (true, false) => (1.0e-4, 5.0e-2),
        };
        let check = |tables: &mut Tables, what: &str, off: f64, bound: f64| {
            tables.check("4", what, S::NAME, off, 0.0, bound);
        };
        check(
            tables,
            "strain against m ṡ²/(EA − m ṡ²), relative",
            found.strain,
            strain_bound,
        );
        check(tables, "shape after one turn, of the radius", found.shape, bound);
        tables.work("running ring, one turn", S::NAME, 40, 0, f64::NAN, &found.counts);
    });
    job(jobs, format!("{}: free ring", S::NAME), move |tables| {
        let exact = thin_ring_frequency(&band(0.185e-3), BAND_LENGTH / TAU);
        for &elements in plan.meshes {
            let error = thin_band_error::<S>(elements);
            tables
                .frequencies
                .add(row!["circle, small", S::NAME, elements, exact * (1.0 + error), exact]);
            if elements == 40 {
                let what = "f₂ of the free ring at 40 elements, Hz";
                tables.check("5", what, S::NAME, exact * (1.0 + error), exact, 5.0e-3 * exact);
            }
        }
    });
    job(jobs, format!("{}: large oscillation", S::NAME), move |tables| {
        let case = "two arcs, large";
        for run in 0..plan.repetitions {
            let clock = ProcessTime::now();
            let found = two_arc_swing::<S>(1.0e-4);
            tables.work(
                case,
                S::NAME,
                S::ELEMENTS,
                run,
                clock.elapsed().as_secs_f64(),
                &found.counts,
            );
            if run > 0 {
                continue;
            }
            tables
                .frequencies
                .add(row![case, S::NAME, S::ELEMENTS, found.frequency, 9.23]);
            let what = "large oscillation from two arcs, Hz";
            if S::Model::<TwoPulley>::LAGRANGIAN {
                tables.check("5", what, S::NAME, found.frequency, 9.23, 0.05);
            } else {
                tables.report("5", what, S::NAME, found.frequency, Some(9.23));
            }
        }
    });
    job(jobs, format!("{}: computing time", S::NAME), move |tables| {
        for run in 0..plan.repetitions {
            let clock = ProcessTime::now();
            let (system, record) = deformable_ring::<S>(S::ELEMENTS, 1.0e-5, 6);
            let cpu = clock.elapsed().as_secs_f64();
            let elements = system.model.elements();
            tables.work("deformable ring, 0.3 ms", S::NAME, elements, run, cpu, &record.counts);
        }
    });
    if plan.orders {
        job(jobs, format!("{}: order in space", S::NAME), |tables| {
            let (ring, near) = soft_membrane();
            let ladder = space_ladder::<S>();
            let errors = frequency_errors::<S>(&ring, near, ladder);
            let quantity = "the frequency in space (resolution: elements)";
            tables.ladder(S::NAME, quantity, S::ORDER, ladder.map(|n| n as f64), errors);
        });
        job(jobs, format!("{}: order in time", S::NAME), |tables| {
            let steps = [50.0, 100.0, 200.0];
            let errors = time_errors::<S>(5.0e-3, steps);
            let quantity = "the shape in time (resolution: steps a period)";
            tables.ladder(S::NAME, quantity, 2.0, steps, errors);
        });
    }
}

fn main() -> io::Result<()> {
    let arguments = Arguments::parse();
    let plan = if arguments.short { SHORT } else { FULL };
    let mut jobs = Vec::new();
    reference_motion(&mut jobs, plan);
    eulerian_rings(&mut jobs, plan);
    belt_rings(&mut jobs, plan);
    manoeuvres(&mut jobs);
    model::<Ale>(&mut jobs, plan);
    model::<AleTurning>(&mut jobs, plan);
    model::<AbsoluteNodal>(&mut jobs, plan);
    model::<CoRotational>(&mut jobs, plan);
    let mut tables = Tables::new();
    let total = jobs.len();
    for (k, (name, work)) in jobs.into_iter().enumerate() {
        work(&mut tables);
        println!("{}/{total} {name}", k + 1);
    }
    tables.write(&arguments.output)
}
