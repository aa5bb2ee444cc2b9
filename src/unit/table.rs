//! The variable table: one row an output, with its name, value reference, unit, description and field. Rows of parameters and inputs
//! are in [`settings`](crate::variator::settings::ParameterRows).
//!
//! Rows of a pulley are written once: its name replaces `{}`, and 100 or 200 is added to the reference.
//!
//! Value references, never changed once given (1036 was belt.contactStrain; 1045, 1048 and 1075 are those of the paper's rings):
//!
//! | references | variables |
//! |---|---|
//! | 1 to 99 | outputs and locals of the whole variator |
//! | 101 to 109, 201 to 209 | inputs of the primary, secondary pulley |
//! | 111 to 129, 211 to 229 | outputs of the primary, secondary pulley |
//! | 131 to 159, 231 to 259 | parameters of the primary, secondary pulley |
//! | 1001 to 1999 | parameters of the whole variator |
//! | 10001 + 100·j to 10072 + 100·j | field j of the profile along the belt |

use super::rings::Rings;
use super::rows::{PRIMARY, Rows, SECONDARY, WHOLE};
use super::settings::Settings;
use crate::fmi::si;
use crate::fmi::table::{Access, Causality, InitialDependencies, Kind, Range, Table};
use crate::variator::settings::{Outputs, Readings, StartState};

use Causality::{Local, Output};

/// Binds to a field of [`Outputs`].
macro_rules! read {
    ($($field:ident).+) => {
        Access::Reading(|readings| readings.as_ref().$($field).+)
    };
}

#[rustfmt::skip]
macro_rules! pulley_outputs {
    ($t:ident, $pulley:ident) => {
        $t.read("{}.speed", 11, (Output, "rad/s", Range::typical(200.0)), "Speed of the {} pulley", read!($pulley.speed));
        $t.read("{}.radius", 12, (Output, "m", Range::typical(0.06)), "Running radius on the {} pulley: pressure-weighted mean pitch radius of the arc", read!($pulley.radius));
        $t.read("{}.position", 13, (Output, "m", Range::typical(0.01)), "Displacement of the movable {} sheave, positive when it closes, 0 at ratio 1", read!($pulley.position));
        $t.read("{}.sheaveVelocity", 25, (Output, "m/s", Range::typical(0.01)), "Speed of the movable {} sheave, positive when it closes", read!($pulley.sheave_velocity));
        $t.read("{}.cylinder.flow", 24, (Output, "m3/s", Range::typical(1e-4)), "Flow into the cylinder of the {} pulley, {}.cylinder.area * {}.sheaveVelocity", read!($pulley.flow));
        $t.read("{}.clampingForceTotal", 23, (Output, "N", Range::typical(1e4)), "Force that closes the {} sheaves at the end of the last step: {}.clampingForce, pressure, spring, rotating oil and seals, or the reaction of a held sheave", read!($pulley.clamping_force_total));
        $t.read("{}.axialForce", 14, (Output, "N", Range::typical(1e4)), "Axial force of the belt on one {} sheave", read!($pulley.axial_force));
        $t.read("{}.shaftTorque", 15, (Output, "N.m", Range::typical(100.0)), "Torque of the belt on the {} pulley, without the drag of the shaft; negative when the shaft drives the belt", read!($pulley.shaft_torque));
        $t.read("{}.externalTorque", 16, (Output, "N.m", Range::typical(100.0)), "External torque on the {} shaft at the end of the last step: the input, or with {}.drive = Speed the torque that maintains the speed", read!($pulley.external_torque));
        $t.read("{}.power", 17, (Output, "W", Range::typical(1e4)), "Power from the {} shaft into the belt, -shaftTorque * speed, without the acceleration of {}.inertia and the drag of the shaft", read!($pulley.power));
        $t.read("spiral.{}", 18, (Output, "m", Range::from(0.0).of_size(1e-4)), "Spiral running: spread of the running radius within the {} arc", read!($pulley.spiral));
        $t.read("ring.stressAmplitude.{}", 21, (Output, "Pa", Range::from(0.0).of_size(1e8)), "Stress amplitude of the ring's cycle on the {} pulley, at the face with the largest stress over a revolution. Each revolution of the ring, belt length / ring.speed, has one cycle on each pulley, by rainflow counting", read!(ring_stress.amplitude.$pulley));
        $t.read("ring.stressMean.{}", 22, (Output, "Pa", Range::typical(1e8)), "Mean stress of the ring's cycle on the {} pulley, of which ring.stressAmplitude.{} is the amplitude", read!(ring_stress.mean.$pulley));
        $t.read("{}.tilt", 19, (Output, "rad", Range::from(0.0).of_size(1e-3)), "Tilt of one {} sheave under the belt forces, mean of both sheaves", read!($pulley.tilt));
        $t.read("{}.idleArc", 20, (Output, "rad", Range::from(0.0).of_size(1.0)), "Idle arc of the {} pulley: angle from the entry, in the direction of travel, to where the push force differs from that of the entering strand by a tenth of the difference between the strands; the whole wrap if that difference is below 20 N", read!($pulley.idle_arc));
    };
}

/// Outputs that do not depend on all settings at the start. The primary speed is given there, so a load on that shaft closes no loop. With
/// a speed set point for the secondary shaft alone it is solved for, which these lists leave out: they are for shafts under torque.
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
];

/// The variable table of the variator.
pub(super) fn table<R: Rings>() -> Table<Settings<R>, Readings> {
    let mut rows = Rows::new();
    rows.inputs();
    outputs(&mut rows);
    R::add_variables(&mut rows);
    rows.parameters();
    locals(&mut rows);
    profiles(&mut rows);
    let mut table = Table::new(si::UNITS, R::ENUMERATIONS, rows.variables);
    (table.arrays, table.retired, table.initial) = (rows.arrays, R::RETIRED, INITIAL_DEPENDENCIES);
    table
}

impl<R: 'static, Q: AsRef<Outputs>> Rows<R, Q> {
    /// Inputs, outputs, parameters and locals but for profiles and `ring.model`.
    #[must_use]
    pub fn shared() -> Self {
        let mut rows = Self::new();
        rows.inputs();
        outputs(&mut rows);
        rows.parameters();
        locals(&mut rows);
        rows
    }
}

/// Outputs.
#[rustfmt::skip]
fn outputs<R, Q: AsRef<Outputs>>(t: &mut Rows<R, Q>) {
    t.read("thrustRatio", 1, (Output, "1", Range::between(-100.0, 100.0).of_size(1.0)), "Thrust ratio: axial force of the belt on the primary sheave / on the secondary sheave; 0 if the latter is below 1 N", read!(thrust_ratio));
    t.read("belt.speed", 2, (Output, "m/s", Range::typical(10.0)), "Mean pitch-line speed of the elements", read!(belt_speed));
    t.read("ring.speed", 3, (Output, "m/s", Range::typical(10.0)), "Speed of the ring: rate of its drift through the mesh", read!(ring_speed));
    t.read("ratio.speed", 4, (Output, "1", Range::typical(1.0)), "Primary speed / secondary speed; 0 at standstill", read!(ratio_speed));
    t.read("ratio.geometric", 5, (Output, "1", Range::typical(1.0)), "secondary.radius / primary.radius", read!(ratio_geometric));
    t.read("reference.theta", 6, (Output, "1", Range::between(-1.0, 1.0).of_size(0.3)), "Ratio coordinate Theta of the reference curve: (1 - i)/(1 + i), i the ratio of its radii secondary/primary; positive in overdrive", read!(reference_theta));
    t.read("slip", 7, (Output, "1", Range::between(-2.0, 2.0).of_size(0.01)), "1 - (secondary speed / primary speed) * ratio.geometric; 0 near standstill of the primary pulley, even if the belt slips through (see macroSlip)", read!(slip));
    t.read("efficiency", 8, (Output, "1", Range::typical(1.0)), "Driven / driving shaft power, including the drag of the shafts, 0 to 1; 0 without power flow. Meaningful at constant speeds only, because the power includes changes of the belt's kinetic energy", read!(efficiency));
    t.read("torqueUtilisation", 9, (Output, "1", Range::between(0.0, 10.0).of_size(1.0)), "Belt torque on the primary pulley / (2 friction.pulley secondary.axialForce primary.radius / cos(geometry.wedgeAngle)). In underdrive the primary pulley slips first, from about 0.8 when driving and 0.6 in overrun", read!(torque_utilisation));
    t.add("macroSlip", 10, Output, "True if all loaded elements of a pulley slide tangentially in the same direction: the belt slips through", Kind::Boolean { access: read!(macro_slip) });
    t.read("loss.total", 11, (Output, "W", Range::typical(100.0)), "Sum of all losses", Access::Reading(|readings| readings.as_ref().losses.total()));
    t.read("loss.sheaves", 12, (Output, "W", Range::typical(100.0)), "Friction loss between elements and sheaves", read!(losses.sheaves));
    t.read("loss.ring", 13, (Output, "W", Range::typical(100.0)), "Friction loss between ring and elements", read!(losses.ring));
    t.read("loss.other", 14, (Output, "W", Range::typical(10.0)), "Loss in sheave dampers, tilt relaxation, end stops, and damping of chain, ring and contacts", read!(losses.other));
    t.read("efficiency.belt", 24, (Output, "1", Range::typical(1.0)), "Driven / driving power at the belt, without the drag of the shafts, 0 to 1; 0 without power flow", read!(belt_efficiency));
    t.read("loss.layers", 25, (Output, "W", Range::typical(10.0)), "Friction loss between the layers of the ring sets", read!(losses.layers));
    t.read("loss.shafts", 26, (Output, "W", Range::typical(100.0)), "Drag loss of both shafts in seals, oil and bearings", read!(losses.shafts));
    t.read("loss.seals", 36, (Output, "W", Range::typical(1.0)), "Friction loss of the seals of both cylinders", read!(losses.seals));
    t.read("loss.spin", 33, (Output, "W", Range::typical(10.0)), "Loss by elements that start and stop turning where they enter and leave an arc: an upper bound, since both are taken as plastic", read!(losses.spin));
    t.read("loss.joints", 35, (Output, "W", Range::typical(10.0)), "Friction loss in the joints of a pull chain", read!(losses.joints));
    t.read("pushForce.max", 15, (Output, "N", Range::typical(1000.0)), "Largest push force between elements", read!(push_force_max));
    t.read("ring.tensionMax", 16, (Output, "N", Range::typical(1000.0)), "Largest ring tension", read!(ring_tension_max));
    t.read("ring.tensionMin", 17, (Output, "N", Range::typical(1000.0)), "Smallest ring tension", read!(ring_tension_min));
    t.read("ring.stressMax", 34, (Output, "Pa", Range::typical(1e8)), "Largest stress in the layers of the ring sets over a revolution, at any face of any layer: tension and bending", read!(ring_stress.max));
    t.work("solver.steps", 27, "Steps of the integrator since the start, including rejected ones", read!(work.steps));
    t.work("solver.jacobians", 28, "Jacobians formed and factored since the start", read!(work.jacobians));
    t.work("solver.residuals", 29, "Residuals evaluated since the start", read!(work.residuals));
    t.read("solver.defect", 30, (Output, "1", Range::from(0.0).of_size(1.0)), "Largest remaining Newton correction of the steps of the last communication step, relative to the tolerance of Newton's method: below 1", read!(work.defect));
    t.read("solver.behind", 31, (Output, "s", Range::from(0.0).of_size(1e-3)), "Delay of the outputs with solver.mode = RealTime, while a step for which the work did not last continues, at most 0.02 s; 0 with solver.mode = Accurate", read!(work.behind));
    t.work("solver.rollbacks", 32, "Steps without a solution with solver.mode = RealTime since the start: each was begun again with half the length", read!(work.rollbacks));
    t.read("belt.misalignment", 20, (Output, "m", Range::typical(1e-3)), "Axial offset of the primary belt plane from the secondary's; it changes with the ratio, because the movable sheaves are on opposite sides", read!(misalignment));
    t.read("belt.lateralMax", 21, (Output, "m", Range::from(0.0).of_size(1e-3)), "Largest axial deflection of the ring from the middle between the two belt planes; 0 without ring.spatial", read!(lateral_max));
    t.read("belt.skew", 22, (Output, "rad", Range::typical(1e-2)), "Mean inclination of the strands to the plane of the drive, from secondary to primary; 0 without ring.spatial", read!(skew));
    t.of(PRIMARY);
    pulley_outputs!(t, primary);
    t.of(SECONDARY);
    pulley_outputs!(t, secondary);
    t.of(WHOLE);
}

/// What is read for checks.
#[rustfmt::skip]
fn locals<R, Q: AsRef<Outputs>>(t: &mut Rows<R, Q>) {
    t.read("stored.energy", 18, (Local, "J", Range::typical(1000.0)), "Kinetic and elastic energy stored in the variator", read!(stored_energy));
    t.read("energy.residual", 19, (Local, "J", Range::typical(1.0)), "Energy residual since the start: supplied - lost - stored", read!(energy_residual));
    t.add("initial.found", 23, Local, "State from which the run started: the requested one, or the reason for another one", Kind::Enumeration { of: StartState::TYPE, access: Access::Reading(|readings| readings.as_ref().start_state as i32) });
}

#[rustfmt::skip]
fn profiles<R>(t: &mut Rows<R>) {
    t.profile("position", 10_001, "m", 1.0, "Position xi along the belt", |readings, at| readings.profile.position[at]);
    t.profile("pushForce", 10_101, "N", 1000.0, "Push force", |readings, at| readings.profile.push_force[at]);
    t.profile("ringTension", 10_201, "N", 1000.0, "Ring tension", |readings, at| readings.profile.ring_tension[at]);
    t.profile("normalForce", 10_301, "N/m", 1e5, "Normal force per flank and length", |readings, at| readings.profile.normal_force[at]);
    t.profile("radialDeviation", 10_401, "m", 1e-4, "Radius less the mean radius of the arc; on strands the outward distance from the tangent line of the reference curve", |readings, at| readings.profile.radial_deviation[at]);
    t.profile("slidingSpeed", 10_501, "m/s", 0.01, "Tangential sliding speed of the flanks", |readings, at| readings.profile.sliding_speed[at]);
    t.profile("ringStress", 10_801, "Pa", 1e8, "Stress at the face of the ring's layers with the largest stress over a revolution,", |readings, at| readings.profile.ring_stress[at]);
    t.profile("lateralDeflection", 10_601, "m", 1e-3, "Deflection of the ring from the middle between the two belt planes, along the pulley axes", |readings, at| readings.profile.lateral_deflection[at]);
    t.profile("gap", 10_701, "m", 1e-6, "Gap between neighbouring elements, 0 in contact,", |readings, at| readings.profile.gap[at]);
}
