//! The variable table: one row a variable, with its name, value reference, unit, description and field. Limits come
//! from [`validation`](crate::variator::validation), start values from the defaults of the fields.
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
use super::types::{AXIAL, BELT_KIND, DRIVE, MODE, START_STATE, UNITS};
use crate::fmi::table::{Access, Causality, InitialDependencies, Kind, Range, Table};
use crate::variator::settings::{Axial, BeltKind, Drive, Mode, Readings};

use Causality::{Input, Local, Output, Parameter, Tunable};

/// Binds to a field of [`Settings`].
macro_rules! set {
    ($($field:ident).+) => {
        Access::Setting {
            get: |settings| settings.$($field).+,
            set: |settings, value| settings.$($field).+ = value,
        }
    };
}

/// Binds to an enumeration in [`Settings`]. Numbers are checked against the items before they get here.
macro_rules! choose {
    ($($field:ident).+, $($number:literal => $item:expr),+; $other:expr) => {
        Access::Setting {
            get: |settings| settings.$($field).+ as i32,
            set: |settings, number| settings.$($field).+ = match number { $($number => $item,)+ _ => $other },
        }
    };
}

/// Binds to a field of [`Outputs`](crate::variator::settings::Outputs).
macro_rules! read {
    ($($field:ident).+) => {
        Access::Reading(|readings| readings.outputs.$($field).+)
    };
}

#[rustfmt::skip]
macro_rules! pulley_inputs {
    ($t:ident, $pulley:ident) => {
        $t.set("{}.torque", 1, Input, "N.m", "External torque on the {} shaft, positive in the direction of positive speed; a load is negative", set!(inputs.$pulley.torque));
        $t.set("{}.clampingForce", 2, Input, "N", "Clamping force that closes the {} sheaves", set!(inputs.$pulley.clamping_force));
        $t.set("{}.speedSetpoint", 3, Input, "rad/s", "Speed set point of the {} shaft; used only with {}.drive = Speed", set!(inputs.$pulley.speed_setpoint));
        $t.set("{}.pressure", 4, Input, "Pa", "Pressure in the cylinder of the {} pulley above ambient, which acts on {}.cylinder.area in addition to {}.clampingForce", set!(inputs.$pulley.pressure));
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

#[rustfmt::skip]
macro_rules! pulley_parameters {
    ($t:ident, $pulley:ident) => {
        $t.choice("{}.drive", 31, &DRIVE, "Boundary condition of the {} shaft: torque or speed", choose!(parameters.$pulley.drive, 2 => Drive::Speed; Drive::Torque));
        $t.choice("{}.axial", 32, &AXIAL, "Boundary condition of the movable {} sheave: force or held", choose!(parameters.$pulley.axial, 2 => Axial::Held; Axial::Force));
        $t.set("{}.inertia", 33, Parameter, "kg.m2", "Moment of inertia of the {} pulley and everything rigidly connected to it", set!(parameters.$pulley.inertia));
        $t.set("{}.sheaveMass", 34, Parameter, "kg", "Mass of the movable {} sheave", set!(parameters.$pulley.sheave_mass));
        $t.set("{}.sheaveDamping", 35, Parameter, "N.s/m", "Viscous damping of the axial motion of the {} sheave", set!(parameters.$pulley.sheave_damping));
        $t.set("{}.tiltStiffness", 36, Parameter, "N.m/rad", "Tilt stiffness of one {} sheave beyond its clearance, mean of both sheaves; rigid from 1e12 on", set!(parameters.$pulley.tilt.stiffness));
        $t.set("{}.tiltClearance", 40, Parameter, "rad", "Angle by which one {} sheave tilts as soon as it is loaded, mean of both sheaves; 0: the tilt is linear in the moment", set!(parameters.$pulley.tilt.clearance));
        $t.set("{}.tiltTime", 37, Parameter, "s", "Relaxation time of the tilt of the {} sheaves", set!(parameters.$pulley.tilt.time));
        $t.set("{}.minRadius", 38, Parameter, "m", "Pitch radius at the opening stop of the {} sheaves", set!(parameters.$pulley.min_radius));
        $t.set("{}.maxRadius", 39, Parameter, "m", "Pitch radius at the closing stop of the {} sheaves", set!(parameters.$pulley.max_radius));
        $t.set("{}.drag.constant", 41, Parameter, "N.m", "Drag torque of the {} shaft that does not depend on speed or load, as of seals", set!(parameters.$pulley.drag.constant));
        $t.set("{}.drag.viscous", 42, Parameter, "N.m.s/rad", "Drag torque of the {} shaft per speed, as of oil", set!(parameters.$pulley.drag.viscous));
        $t.set("{}.bearing.friction", 43, Parameter, "1", "Friction coefficient of the bearings of the {} shaft under the resultant of the belt's contact forces on the pulley; set 0 if another model includes the bearings", set!(parameters.$pulley.drag.bearing_friction));
        $t.set("{}.bearing.radius", 44, Parameter, "m", "Mean radius of the bearings of the {} shaft", set!(parameters.$pulley.drag.bearing_radius));
        $t.set("{}.cylinder.area", 45, Parameter, "m2", "Area of the {} piston, on which {}.pressure acts; 0: no cylinder", set!(parameters.$pulley.cylinder.area));
        $t.set("{}.cylinder.springForce", 46, Parameter, "N", "Force at ratio 1 of the spring that closes the {} sheaves", set!(parameters.$pulley.cylinder.spring_force));
        $t.set("{}.cylinder.springStiffness", 47, Parameter, "N/m", "Stiffness of the spring of the {} sheaves: its force falls with {}.position", set!(parameters.$pulley.cylinder.spring_stiffness));
        $t.set("{}.cylinder.centrifugal", 48, Parameter, "N.s2/rad2", "Closing force of the oil that rotates with the {} pulley per square of the speed; negative with an overcompensated cylinder", set!(parameters.$pulley.cylinder.centrifugal));
        $t.set("{}.cylinder.seal", 49, Parameter, "N", "Friction of the seals of the {} cylinder, against {}.sheaveVelocity, regularised by friction.velocity", set!(parameters.$pulley.cylinder.seal));
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
#[rustfmt::skip]
pub(super) fn table<R: Rings>() -> Table<Settings<R>, Readings> {
    let mut rows = Rows::new();
    let t = &mut rows;
    t.of(PRIMARY);
    pulley_inputs!(t, primary);
    t.of(SECONDARY);
    pulley_inputs!(t, secondary);
    t.of(WHOLE);
    outputs(t);
    t.of(PRIMARY);
    pulley_outputs!(t, primary);
    t.of(SECONDARY);
    pulley_outputs!(t, secondary);
    t.of(WHOLE);
    parameters(t);
    t.of(PRIMARY);
    pulley_parameters!(t, primary);
    t.of(SECONDARY);
    pulley_parameters!(t, secondary);
    t.of(WHOLE);
    locals(t);
    let table = Table::new(UNITS, R::ENUMERATIONS, rows.variables).with_arrays(rows.arrays);
    table.with_retired(R::RETIRED).with_initial_dependencies(INITIAL_DEPENDENCIES)
}

#[rustfmt::skip]
fn outputs<R: Rings>(t: &mut Rows<R>) {
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
    t.read("loss.total", 11, (Output, "W", Range::typical(100.0)), "Sum of all losses", Access::Reading(|readings| readings.outputs.losses.total()));
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
    t.work("solver.steps", 27, "Steps of the integrator since the start, including rejected ones", Access::Reading(|readings| readings.outputs.work.steps));
    t.work("solver.jacobians", 28, "Jacobians formed and factored since the start", Access::Reading(|readings| readings.outputs.work.jacobians));
    t.work("solver.residuals", 29, "Residuals evaluated since the start", Access::Reading(|readings| readings.outputs.work.residuals));
    t.read("solver.defect", 30, (Output, "1", Range::from(0.0).of_size(1.0)), "Largest remaining Newton correction of the steps of the last communication step, relative to the tolerance of Newton's method: below 1", read!(work.defect));
    t.read("solver.behind", 31, (Output, "s", Range::from(0.0).of_size(1e-3)), "Delay of the outputs with solver.mode = RealTime, while a step for which the work did not last continues, at most 0.02 s; 0 with solver.mode = Accurate", read!(work.behind));
    t.work("solver.rollbacks", 32, "Steps without a solution with solver.mode = RealTime since the start: each was begun again with half the length", Access::Reading(|readings| readings.outputs.work.rollbacks));
    t.read("belt.misalignment", 20, (Output, "m", Range::typical(1e-3)), "Axial offset of the primary belt plane from the secondary's; it changes with the ratio, because the movable sheaves are on opposite sides", read!(misalignment));
    t.read("belt.lateralMax", 21, (Output, "m", Range::from(0.0).of_size(1e-3)), "Largest axial deflection of the ring from the middle between the two belt planes; 0 without ring.spatial", read!(lateral_max));
    t.read("belt.skew", 22, (Output, "rad", Range::typical(1e-2)), "Mean inclination of the strands to the plane of the drive, from secondary to primary; 0 without ring.spatial", read!(skew));
}

#[rustfmt::skip]
fn parameters<R: Rings>(t: &mut Rows<R>) {
    R::add_variables(t);
    t.set("initial.ratio", 1011, Parameter, "1", "Geometric ratio secondary radius / primary radius at the start, between the end stops. A loaded belt rests up to some 5 % beyond them; a value up to 6 % beyond starts at the stop", set!(parameters.initial.ratio));
    t.set("initial.primarySpeed", 1012, Parameter, "rad/s", "Speed of the primary pulley at the start; 0: standstill, the belt starts clamped. A shaft with drive = Speed starts at its set point instead", set!(parameters.initial.primary_speed));
    t.switch("initial.steady", 1013, "True: start from the steady state at this ratio and speed, solved with the primary sheave held and unbalanced torque accelerating the inertias. False: start from the unloaded kinematic state", set!(parameters.initial.steady));
    t.switch("initial.equilibrium", 1014, "With initial.steady: also solve for the ratio at which the two clamping forces are in equilibrium", set!(parameters.initial.equilibrium));
    t.set("geometry.centerDistance", 1021, Parameter, "m", "Distance of the pulley axes", set!(parameters.geometry.center_distance));
    t.set("geometry.beltLength", 1022, Parameter, "m", "Length of the unstretched ring centre line", set!(parameters.geometry.belt_length));
    t.set("geometry.wedgeAngle", 1023, Parameter, "rad", "Half wedge angle of the sheaves", set!(parameters.geometry.wedge_angle));
    t.set("geometry.pulleyOffset", 1024, Parameter, "m", "Axial offset at ratio 1 of the primary belt plane from the secondary's, towards the movable primary sheave; used only with ring.spatial", set!(parameters.geometry.pulley_offset));
    t.choice("belt.kind", 1065, &BELT_KIND, "Kind of the belt. A pull chain ignores the parameters of stack and ring friction, and its outputs of them are 0", choose!(parameters.kind, 2 => BeltKind::PullChain; BeltKind::PushBelt));
    t.set("belt.jointRadius", 1066, Parameter, "m", "Pull chain: radius at which the tension causes friction in a joint, which determines loss.joints", set!(parameters.joints.radius));
    t.set("belt.pitchOffset", 1031, Parameter, "m", "Distance by which the pitch line (rocking edge) lies inside the ring centre line", set!(parameters.belt.pitch_offset));
    t.set("belt.play", 1032, Parameter, "m", "End play: pitch-line length less the stacked thickness of all elements", set!(parameters.belt.play));
    t.set("belt.massPerLength", 1033, Parameter, "kg/m", "Mass of the elements, without the ring, per pitch-line length", set!(parameters.belt.mass_per_length));
    t.set("belt.pushStiffness", 1034, Parameter, "N", "Push force per strain of the element stack", set!(parameters.belt.push_stiffness));
    t.set("belt.damping", 1035, Parameter, "s", "Damping time of the element stack, in contact only", set!(parameters.belt.damping));
    t.set("belt.roughness", 1037, Parameter, "m", "Roughness of the elements' faces: distance over which the contact force between neighbouring elements rises", set!(parameters.belt.roughness));
    t.set("belt.elementThickness", 1038, Parameter, "m", "Thickness of an element", set!(parameters.belt.element_thickness));
    t.set("belt.elementInertia", 1058, Parameter, "kg.m2", "Moment of inertia of an element about its rocking edge, which determines loss.spin; 0: no such loss", set!(parameters.belt.element_inertia));
    t.set("belt.filmThickness", 1040, Parameter, "m", "Gap between elements over which the forces of the oil decrease", set!(parameters.belt.film_thickness));
    t.set("belt.filmDamping", 1057, Parameter, "N.s", "Viscosity of the oily stack: force per rate of strain, twice as large where elements approach at any gap; where they separate divided by (1 + gap/belt.filmThickness)^2", set!(parameters.belt.film_damping));
    t.set("belt.squeezeDamping", 1085, Parameter, "N.s", "Squeeze damping: force between elements per rate of strain by oil squeezed out of a closing gap, at a gap of zero; divided by (1 + gap/belt.filmThickness)^3", set!(parameters.belt.squeeze_damping));
    t.set("belt.suction", 1087, Parameter, "N", "Largest suction between two elements, at which the oil cavitates: area of their faces times the pressure of the atmosphere", set!(parameters.belt.suction));
    t.set("ring.massPerLength", 1041, Parameter, "kg/m", "Mass of the ring sets per length", set!(parameters.ring.mass_per_length));
    t.set("ring.axialStiffness", 1042, Parameter, "N", "Axial stiffness EA of the ring sets", set!(parameters.ring.axial_stiffness));
    t.set("ring.bendingStiffness", 1043, Parameter, "N.m2", "Bending stiffness EI of the ring sets in the plane of the drive", set!(parameters.ring.bending_stiffness));
    t.set("ring.lateralBendingStiffness", 1046, Parameter, "N.m2", "Bending stiffness EI of the ring sets out of the plane of the drive, with ring.spatial", set!(parameters.ring.lateral_bending_stiffness));
    t.switch("ring.spatial", 1047, "True: the ring also deflects out of the plane of the drive, as between misaligned pulleys. Requires ring.model = ALE", set!(parameters.spatial));
    t.set("ring.damping", 1044, Parameter, "s", "Kelvin-Voigt damping time of the axial strain", set!(parameters.ring.damping));
    t.count("ring.layers", 1049, "Layers of each ring set, which slip on each other at ratios other than 1", set!(parameters.layers.count));
    t.set("ring.layerThickness", 1050, Parameter, "m", "Thickness of a layer of the ring sets", set!(parameters.layers.thickness));
    t.set("ring.layerWidth", 1060, Parameter, "m", "Width of a layer of the ring sets, for its stress only", set!(parameters.layers.width));
    t.set("ring.residualCurvature", 1064, Parameter, "1/m", "Curvature of a layer that is free of stress: it shifts the mean stress of bending, and nothing else", set!(parameters.layers.residual_curvature));
    t.set("friction.pulley", 1051, Tunable, "1", "Friction coefficient between element and sheave; must be below tan(geometry.wedgeAngle)", set!(parameters.friction.pulley));
    t.set("friction.ring", 1052, Tunable, "1", "Friction coefficient between ring and element", set!(parameters.friction.ring));
    t.set("friction.fall", 1054, Parameter, "1", "Relative decrease of friction.pulley in fast sliding: mu(v) = friction.pulley (1 - fall v^2/(v^2 + fallSpeed^2)); 0: Coulomb's law", set!(parameters.friction.fall));
    t.set("friction.fallSpeed", 1055, Parameter, "m/s", "Sliding speed at which half of friction.fall is reached", set!(parameters.friction.fall_speed));
    t.set("friction.velocity", 1053, Parameter, "m/s", "Regularisation velocity of the friction between element and sheave; at most 1e-3 for accurate micro-slip", set!(parameters.friction.velocity));
    t.set("friction.ringVelocity", 1059, Parameter, "m/s", "Regularisation velocity of the friction between ring and element", set!(parameters.friction.ring_velocity));
    t.set("friction.layers", 1056, Parameter, "1", "Friction coefficient between the layers of the ring sets", set!(parameters.layers.friction));
    t.set("contact.stiffness", 1061, Parameter, "N/m2", "Contact stiffness per flank and pitch-line length", set!(parameters.contact.stiffness));
    t.set("contact.roughness", 1063, Parameter, "m", "Roughness of flank and sheave: distance over which the contact force rises", set!(parameters.contact.roughness));
    t.set("contact.damping", 1062, Parameter, "s", "Damping time of the contact between flank and sheave", set!(parameters.contact.damping));
    t.count("mesh.primaryArc", 1071, "Ring elements on the primary arc", set!(parameters.mesh.primary_arc));
    t.count("mesh.secondaryArc", 1072, "Ring elements on the secondary arc, an even number", set!(parameters.mesh.secondary_arc));
    t.count("mesh.strand", 1073, "Ring elements on each strand", set!(parameters.mesh.strand));
    t.count("mesh.cellsPerElement", 1074, "Cells of the element chain in each ring element; with ring.model = ALE0 always one", set!(parameters.mesh.cells_per_element));
    t.choice("solver.mode", 1084, &MODE, "Accurate steps with error control, or bounded work in each millisecond for real time", choose!(parameters.solver.mode, 2 => Mode::RealTime; Mode::Accurate));
    t.count("solver.effort", 1086, "With solver.mode = RealTime: bound of the work of each millisecond, 15.5 times as much as a residual with its correction takes. Less takes less time; more is accurate under loads that jump", set!(parameters.solver.effort));
    t.set("solver.tolerance", 1081, Parameter, "1", "Relative tolerance of the error control. At its default the tolerance of the experiment is used instead, if there is one. A coarser tolerance is faster under loads that jump, not under smooth loads, where steps are as long as the communication steps. Output derivatives of forces and losses need 1e-6", set!(parameters.solver.tolerance));
    t.set("solver.maxStep", 1082, Parameter, "s", "Longest internal step; with solver.mode = RealTime steps are 0.2 ms or shorter", set!(parameters.solver.max_step));
    t.set("inputs.ramp", 1083, Parameter, "s", "Time over which an input that is set before a step ramps to its new value, at most that step; 0: it jumps, -1: the whole step. Inputs with a derivative follow the derivative instead", set!(parameters.solver.input_ramp));
}

#[rustfmt::skip]
fn locals<R: Rings>(t: &mut Rows<R>) {
    t.read("stored.energy", 18, (Local, "J", Range::typical(1000.0)), "Kinetic and elastic energy stored in the variator", read!(stored_energy));
    t.read("energy.residual", 19, (Local, "J", Range::typical(1.0)), "Energy residual since the start: supplied - lost - stored", read!(energy_residual));
    t.add("initial.found", 23, Local, "State from which the run started: the requested one, or the reason for another one", Kind::Enumeration { of: &START_STATE, access: Access::Reading(|readings| readings.outputs.start_state as i32) });
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
