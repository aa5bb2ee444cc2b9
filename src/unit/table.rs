//! The variable table: one row an output, with its name, value reference, unit, description and
//! field. Rows of parameters and inputs are in [`settings`](crate::variator::settings::parameters).
//!
//! Value references, never changed once given (1036 was belt.contactStrain; 1045, 1048 and 1075 are
//! those of the paper's rings):
//!
//! | references | variables |
//! |---|---|
//! | 1 to 99 | outputs and locals of the whole variator |
//! | 101 to 109, 201 to 209 | inputs of the primary, secondary pulley |
//! | 111 to 129, 211 to 229 | outputs of the primary, secondary pulley |
//! | 131 to 159, 231 to 259 | parameters of the primary, secondary pulley |
//! | 1001 to 1999 | parameters of the whole variator |
//! | 10001 + 100·j to 10072 + 100·j | field j of the profile along the belt |

use super::rings::{Rings, Settings};
use crate::fmi::si;
use crate::fmi::table::{Access, Array, Causality, InitialDependencies, Kind, Range, Table, Variable};
use crate::variator::settings::table::{PRIMARY, Row, SECONDARY, WHOLE, inputs, parameters};
use crate::variator::settings::{Outputs, PROFILE_POINTS, Readings, Setting, StartState};

use Causality::{Local, Output};

/// Outputs that do not depend on all settings at the start. The primary speed is given there, so a
/// load on that shaft closes no loop. With a speed set point for the secondary shaft alone it is
/// solved for, which these lists leave out: they are for shafts under torque.
const INITIAL_DEPENDENCIES: &[InitialDependencies] = &[
    (
        "primary.speed",
        &[
            "initial.ratio",
            "initial.primarySpeed",
            "initial.steady",
            "solver.mode",
            "primary.drive",
            "primary.speedSetpoint",
            "secondary.drive",
            "secondary.speedSetpoint",
        ],
    ),
    ("solver.steps", &[]),
    ("solver.jacobians", &[]),
    ("solver.residuals", &[]),
    ("solver.defect", &[]),
    ("solver.behind", &[]),
    ("solver.rollbacks", &[]),
    AT_REST[0],
    AT_REST[1],
    AT_REST[2],
    AT_REST[3],
    AT_REST[4],
];

/// Outputs that are zero at the start, where the sheaves are at rest.
pub const AT_REST: [InitialDependencies; 5] = [
    ("primary.sheaveVelocity", &[]),
    ("primary.cylinder.flow", &[]),
    ("secondary.sheaveVelocity", &[]),
    ("secondary.cylinder.flow", &[]),
    ("loss.seals", &[]),
];

pub(super) fn table<R: Rings>() -> Table<Settings<R>, Readings> {
    let mut variables = shared_variables(R::variables());
    let (arrays, elements): (Vec<_>, Vec<_>) = profiles().unzip();
    variables.extend(elements.into_iter().flatten());
    let mut table = Table::new(si::UNITS, R::ENUMERATIONS, variables);
    (table.arrays, table.retired, table.initial) = (arrays, R::RETIRED, INITIAL_DEPENDENCIES);
    table
}

/// Inputs, outputs, parameters, of which the unit's `own` are the first, and locals but for
/// profiles.
#[must_use]
pub fn shared_variables<R, Q: AsRef<Outputs>>(
    own: Vec<Variable<Settings<R>, Q>>,
) -> Vec<Variable<Settings<R>, Q>> {
    let before = inputs().map(Setting::variable).chain(outputs()).chain(own);
    let parameters = parameters().map(Setting::variable);
    before.chain(parameters).chain(locals()).collect()
}

/// The row of an output, by name, value reference, type, description and field of [`Outputs`]. `Q`
/// is the type of the readings in which it is.
macro_rules! read {
    ($name:literal, $reference:literal, $kind:ident $(($($of:tt)*))?, $text:literal, $($field:tt)+) => {{
        let access = Access::Reading(|readings: &Q| readings.as_ref().$($field)+);
        Row { name: $name, reference: $reference, causality: Output, text: $text, kind: kind!($kind $(($($of)*))?, access) }
    }};
}

/// A type with its field. A real number has a unit, its limits where there are some, and a typical
/// size.
#[rustfmt::skip]
macro_rules! kind {
    (Real($unit:expr, $nominal:expr), $access:ident) => { kind!(Range($unit, Range::typical($nominal)), $access) };
    (Positive($unit:expr, $nominal:expr), $access:ident) => { kind!(Range($unit, Range::from(0.0).with_nominal($nominal)), $access) };
    (Between($unit:expr, $min:expr, $max:expr, $nominal:expr), $access:ident) => { kind!(Range($unit, Range::between($min, $max).with_nominal($nominal)), $access) };
    (Range($unit:expr, $range:expr), $access:ident) => { Kind::Real { unit: $unit, display_unit: None, range: $range, access: $access } };
    (Count, $access:ident) => { Kind::Integer { range: None, access: $access } };
    (Switch, $access:ident) => { Kind::Boolean { access: $access } };
    (Choice($of:ident), $access:ident) => { Kind::Enumeration { of: $of::TYPE, access: $access } };
}

#[rustfmt::skip]
macro_rules! pulley_outputs {
    ($pulley:ident) => {
        [
            read!("{}.speed", 11, Real("rad/s", 200.0), "Speed of the {} pulley", $pulley.speed),
            read!("{}.radius", 12, Real("m", 0.06), "Running radius on the {} pulley: pressure-weighted mean pitch radius of the arc", $pulley.radius),
            read!("{}.position", 13, Real("m", 0.01), "Displacement of the movable {} sheave, positive when it closes, 0 at ratio 1", $pulley.position),
            read!("{}.sheaveVelocity", 25, Real("m/s", 0.01), "Speed of the movable {} sheave, positive when it closes", $pulley.sheave_velocity),
            read!("{}.cylinder.flow", 24, Real("m3/s", 1e-4), "Flow into the cylinder of the {} pulley, {}.cylinder.area * {}.sheaveVelocity", $pulley.flow),
            read!("{}.cylinder.volume", 26, Real("m3", 1e-4), "Oil in the cylinder of the {} pulley beyond that at ratio 1, {}.cylinder.area * {}.position. Its change over a step, divided by the step, is the mean flow", $pulley.volume),
            read!("{}.clampingForceTotal", 23, Real("N", 1e4), "Force that closes the {} sheaves at the end of the last step: {}.clampingForce, pressure, spring, rotating oil and seals, or the reaction of a held sheave", $pulley.clamping_force_total),
            read!("{}.axialForce", 14, Real("N", 1e4), "Axial force of the belt on one {} sheave", $pulley.axial_force),
            read!("{}.shaftTorque", 15, Real("N.m", 100.0), "Torque of the belt on the {} pulley, without the drag of the shaft; negative when the shaft drives the belt", $pulley.shaft_torque),
            read!("{}.externalTorque", 16, Real("N.m", 100.0), "External torque on the {} shaft at the end of the last step: the input, or with {}.drive = Speed the torque that maintains the speed", $pulley.external_torque),
            read!("{}.power", 17, Real("W", 1e4), "Power from the {} shaft into the belt, -shaftTorque * speed, without the acceleration of {}.inertia and the drag of the shaft", $pulley.power),
            read!("spiral.{}", 18, Positive("m", 1e-4), "Spiral running: spread of the running radius within the {} arc", $pulley.spiral),
            read!("ring.stressAmplitude.{}", 21, Positive("Pa", 1e8), "Stress amplitude of the ring's cycle on the {} pulley, at the face with the largest stress over a revolution. Each revolution of the ring, belt length / ring.speed, has one cycle on each pulley, by rainflow counting", ring_stress.amplitude.$pulley),
            read!("ring.stressMean.{}", 22, Real("Pa", 1e8), "Mean stress of the ring's cycle on the {} pulley, of which ring.stressAmplitude.{} is the amplitude", ring_stress.mean.$pulley),
            read!("{}.tilt", 19, Positive("rad", 1e-3), "Tilt of one {} sheave under the belt forces, mean of both sheaves", $pulley.tilt),
            read!("{}.idleArc", 20, Positive("rad", 1.0), "Idle arc of the {} pulley: angle from the entry, in the direction of travel, to where the push force differs from that of the entering strand by a tenth of the difference between the strands; the whole wrap if that difference is below 20 N", $pulley.idle_arc),
        ]
    };
}

#[rustfmt::skip]
pub(super) fn outputs<S, Q: AsRef<Outputs>>() -> impl Iterator<Item = Variable<S, Q>> {
    let whole = [
        read!("thrustRatio", 1, Between("1", -100.0, 100.0, 1.0), "Thrust ratio: axial force of the belt on the primary sheave / on the secondary sheave; 0 if the latter is below 1 N", thrust_ratio),
        read!("belt.speed", 2, Real("m/s", 10.0), "Mean pitch-line speed of the elements", belt_speed),
        read!("ring.speed", 3, Real("m/s", 10.0), "Speed of the ring: rate of its drift through the mesh", ring_speed),
        read!("ratio.speed", 4, Real("1", 1.0), "Primary speed / secondary speed; 0 at standstill", ratio_speed),
        read!("ratio.geometric", 5, Real("1", 1.0), "secondary.radius / primary.radius", ratio_geometric),
        read!("reference.theta", 6, Between("1", -1.0, 1.0, 0.3), "Ratio coordinate Theta of the reference curve: (1 - i)/(1 + i), i the ratio of its radii secondary/primary; positive in overdrive", reference_theta),
        read!("slip", 7, Between("1", -2.0, 2.0, 0.01), "1 - (secondary speed / primary speed) * ratio.geometric; 0 near standstill of the primary pulley, even if the belt slips through (see macroSlip)", slip),
        read!("efficiency", 8, Real("1", 1.0), "Driven / driving shaft power, including the drag of the shafts, 0 to 1; 0 without power flow. Meaningful at constant speeds only, because the power includes changes of the belt's kinetic energy", efficiency),
        read!("torqueUtilisation", 9, Between("1", 0.0, 10.0, 1.0), "Belt torque on the primary pulley / (2 friction.pulley secondary.axialForce primary.radius / cos(geometry.wedgeAngle)). In underdrive the primary pulley slips first, from about 0.8 when driving and 0.6 in overrun", torque_utilisation),
        read!("macroSlip", 10, Switch, "True if all loaded elements of a pulley slide tangentially in the same direction: the belt slips through", macro_slip),
        read!("pastPeak", 38, Switch, "True past the peak of traction: a pulley would transmit less torque if its elements slid faster, with the present normal forces. A belt near its capacity in underdrive can have macroSlip before", past_peak),
        read!("loss.total", 11, Real("W", 100.0), "Sum of all losses", losses.total()),
        read!("loss.sheaves", 12, Real("W", 100.0), "Friction loss between elements and sheaves", losses.sheaves),
        read!("loss.ring", 13, Real("W", 100.0), "Friction loss between ring and elements", losses.ring),
        read!("loss.other", 14, Real("W", 10.0), "Loss in sheave dampers, tilt relaxation, end stops, and damping of chain, ring and contacts", losses.other),
        read!("efficiency.belt", 24, Real("1", 1.0), "Driven / driving power at the belt, without the drag of the shafts, 0 to 1; 0 without power flow", belt_efficiency),
        read!("loss.layers", 25, Real("W", 10.0), "Friction loss between the layers of the ring sets", losses.layers),
        read!("loss.shafts", 26, Real("W", 100.0), "Drag loss of both shafts in seals, oil and bearings", losses.shafts),
        read!("loss.seals", 36, Real("W", 1.0), "Friction loss of the seals of both cylinders", losses.seals),
        read!("loss.spin", 33, Real("W", 10.0), "Loss by elements that start and stop turning where they enter and leave an arc: an upper bound, since both are taken as plastic", losses.element_rotation),
        read!("loss.joints", 35, Real("W", 10.0), "Friction loss in the joints of a pull chain", losses.joints),
        read!("pushForce.max", 15, Real("N", 1000.0), "Largest push force between elements", push_force_max),
        read!("ring.tensionMax", 16, Real("N", 1000.0), "Largest ring tension", ring_tension_max),
        read!("ring.tensionMin", 17, Real("N", 1000.0), "Smallest ring tension", ring_tension_min),
        read!("ring.stressMax", 34, Real("Pa", 1e8), "Largest stress in the layers of the ring sets over a revolution, at any face of any layer: tension and bending", ring_stress.max),
        read!("solver.steps", 27, Count, "Steps of the integrator since the start, including rejected ones", work.steps),
        read!("solver.jacobians", 28, Count, "Jacobians formed and factored since the start", work.jacobians),
        read!("solver.residuals", 29, Count, "Residuals evaluated since the start", work.residuals),
        read!("solver.defect", 30, Positive("1", 1.0), "Largest remaining Newton correction of the steps of the last communication step, relative to the tolerance of Newton's method: below 1", work.defect),
        read!("solver.behind", 31, Positive("s", 1e-3), "Delay of the outputs with solver.mode = RealTime, while a step for which the work did not last continues, at most 0.02 s; 0 with solver.mode = Accurate", work.behind),
        read!("solver.rollbacks", 32, Count, "Steps without a solution with solver.mode = RealTime since the start: each was begun again with half the length", work.rollbacks),
        read!("belt.misalignment", 20, Real("m", 1e-3), "Axial offset of the primary belt plane from the secondary's; it changes with the ratio, because the movable sheaves are on opposite sides", misalignment),
        read!("belt.lateralMax", 21, Positive("m", 1e-3), "Largest axial deflection of the ring from the middle between the two belt planes; 0 without ring.spatial", lateral_max),
        read!("belt.skew", 22, Real("rad", 1e-2), "Mean inclination of the strands to the plane of the drive, from secondary to primary; 0 without ring.spatial", skew),
    ];
    let variable = |owner| move |row: Row<'_, S, Q>| row.variable(owner);
    let [primary, secondary] = [pulley_outputs!(primary), pulley_outputs!(secondary)];
    let pulleys = primary.into_iter().map(variable(PRIMARY)).chain(secondary.into_iter().map(variable(SECONDARY)));
    whole.into_iter().map(variable(WHOLE)).chain(pulleys)
}

/// What is read for checks.
#[rustfmt::skip]
fn locals<S, Q: AsRef<Outputs>>() -> impl Iterator<Item = Variable<S, Q>> {
    let rows = [
        read!("stored.energy", 18, Real("J", 1000.0), "Kinetic and elastic energy stored in the variator", stored_energy),
        read!("energy.residual", 19, Real("J", 1.0), "Energy residual since the start: supplied - lost - stored", energy_residual),
        read!("solver.skipped", 37, Positive("s", 1e-3), "Time that was left out since the start with solver.mode = RealTime: what a run would be behind beyond 0.02 s", work.skipped),
        read!("initial.found", 23, Choice(StartState), "State from which the run started: the requested one, or the reason for another one", start_state as i32),
    ];
    rows.into_iter().map(|row| Row { causality: Local, ..row }.variable(WHOLE))
}

#[rustfmt::skip]
fn profiles<S>() -> impl Iterator<Item = (Array, Vec<Variable<S, Readings>>)> {
    // Name, value reference of the first element, unit, typical size, description, value at a point.
    type Profile = (&'static str, u32, &'static str, f64, &'static str, fn(&Readings, usize) -> f64);
    let rows: [Profile; 9] = [
        ("position", 10_001, "m", 1.0, "Position xi along the belt", |of, at| of.profile.position[at]),
        ("pushForce", 10_101, "N", 1000.0, "Push force", |of, at| of.profile.push_force[at]),
        ("ringTension", 10_201, "N", 1000.0, "Ring tension", |of, at| of.profile.ring_tension[at]),
        ("normalForce", 10_301, "N/m", 1e5, "Normal force per flank and length", |of, at| of.profile.normal_force[at]),
        ("radialDeviation", 10_401, "m", 1e-4, "Radius less the mean radius of the arc; on strands the outward distance from the tangent line of the reference curve", |of, at| of.profile.radial_deviation[at]),
        ("slidingSpeed", 10_501, "m/s", 0.01, "Tangential sliding speed of the flanks", |of, at| of.profile.sliding_speed[at]),
        ("ringStress", 10_801, "Pa", 1e8, "Stress at the face of the ring's layers with the largest stress over a revolution,", |of, at| of.profile.ring_stress[at]),
        ("lateralDeflection", 10_601, "m", 1e-3, "Deflection of the ring from the middle between the two belt planes, along the pulley axes", |of, at| of.profile.lateral_deflection[at]),
        ("gap", 10_701, "m", 1e-6, "Gap between neighbouring elements, 0 in contact,", |of, at| of.profile.gap[at]),
    ];
    rows.into_iter().map(|(name, first, unit, nominal, text, get)| {
        let array = Array {
            name: format!("profile.{name}"),
            description: format!("{text} at xi = 0/{PROFILE_POINTS}, 1/{PROFILE_POINTS} and so on of the belt length"),
            first,
            size: PROFILE_POINTS as u32,
        };
        let element = |(point, reference)| {
            let (name, text) = (format!("{}[{}]", array.name, point + 1), format!("{text} at xi = {point}/{PROFILE_POINTS} of the belt length"));
            let access = Access::Element(get, point);
            let kind = kind!(Real(unit, nominal), access);
            Row { name: &name, reference, causality: Local, text: &text, kind }.variable(WHOLE)
        };
        let elements = (0..PROFILE_POINTS).zip(first..).map(element).collect();
        (array, elements)
    })
}
