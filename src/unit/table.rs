//! The variable table: one row a variable, with its name, value reference, unit, description and field. Limits come
//! from [`validation`](crate::variator::validation), start values from the defaults of the fields.
//!
//! Rows of a pulley are written once: `{}` stands for its name, and 100 or 200 is added to the reference.
//!
//! Value references, never changed once given (1036 was belt.contactStrain):
//!
//! | references | variables |
//! |---|---|
//! | 1 to 99 | outputs and locals of the whole variator |
//! | 101 to 109, 201 to 209 | inputs of the primary, secondary pulley |
//! | 111 to 129, 211 to 229 | outputs of the primary, secondary pulley |
//! | 131 to 159, 231 to 259 | parameters of the primary, secondary pulley |
//! | 1001 to 1999 | parameters of the whole variator |
//! | 10001 + 100·j to 10072 + 100·j | field j of the profile along the belt |

use super::settings::Settings;
use super::types::{AXIAL, DRIVE, ENUMERATIONS, MODE, RING_MODEL, START_STATE, UNITS};
use crate::fmi::table::{Access, Array, Causality, Enumeration, Kind, Range, Table, Variable};
use crate::variator::settings::{Axial, Drive, Mode, PROFILE_POINTS, Readings, RingModel, range_of};

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

/// The owner of the rows that follow: the name that stands for `{}`, and the number that is added to the references.
type Owner = (&'static str, u32);
const WHOLE: Owner = ("", 0);
const PRIMARY: Owner = ("primary", 100);
const SECONDARY: Owner = ("secondary", 200);

/// The rows of the table so far, and the owner of the next ones.
struct Rows {
    variables: Vec<Variable<Settings, Readings>>,
    arrays: Vec<Array>,
    owner: Owner,
}

impl Rows {
    fn of(&mut self, owner: Owner) {
        self.owner = owner;
    }

    fn range(&self, name: &str) -> Option<(f64, f64)> {
        range_of(&name.replace("{}", self.owner.0))
    }

    fn add(&mut self, name: &str, reference: u32, causality: Causality, text: &str, kind: Kind<Settings, Readings>) {
        let (owner, base) = self.owner;
        self.variables.push(Variable {
            name: name.replace("{}", owner),
            reference: base + reference,
            description: text.replace("{}", owner),
            causality,
            kind,
        });
    }

    /// A real parameter or input.
    fn set(
        &mut self,
        name: &str,
        reference: u32,
        causality: Causality,
        unit: &'static str,
        text: &str,
        access: Access<Settings, Readings, f64>,
    ) {
        let (min, max) = self.range(name).unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
        let range = Range {
            min: min.is_finite().then_some(min),
            max: max.is_finite().then_some(max),
            nominal: None,
        };
        let kind = Kind::Real {
            unit,
            display_unit: display_unit(name, unit),
            range,
            access,
        };
        self.add(name, reference, causality, text, kind);
    }

    /// A real output or local, with its limits and typical size.
    fn read(
        &mut self,
        name: &str,
        reference: u32,
        (causality, unit, range): (Causality, &'static str, Range),
        text: &str,
        access: Access<Settings, Readings, f64>,
    ) {
        let kind = Kind::Real {
            unit,
            display_unit: display_unit(name, unit),
            range,
            access,
        };
        self.add(name, reference, causality, text, kind);
    }

    fn count(&mut self, name: &str, reference: u32, text: &str, access: Access<Settings, Readings, i32>) {
        #[expect(
            clippy::cast_possible_truncation,
            reason = "the limits of integers are small whole numbers"
        )]
        let range = self.range(name).map(|(min, max)| (min as i32, max as i32));
        self.add(name, reference, Parameter, text, Kind::Integer { range, access });
    }

    /// An output that counts.
    fn work(&mut self, name: &str, reference: u32, text: &str, access: Access<Settings, Readings, i32>) {
        self.add(name, reference, Output, text, Kind::Integer { range: None, access });
    }

    fn switch(&mut self, name: &str, reference: u32, text: &str, access: Access<Settings, Readings, bool>) {
        self.add(name, reference, Parameter, text, Kind::Boolean { access });
    }

    fn choice(
        &mut self,
        name: &str,
        reference: u32,
        of: &'static Enumeration,
        text: &str,
        access: Access<Settings, Readings, i32>,
    ) {
        self.add(name, reference, Parameter, text, Kind::Enumeration { of, access });
    }

    fn profile(
        &mut self,
        name: &str,
        first: u32,
        unit: &'static str,
        nominal: f64,
        text: &str,
        get: fn(&Readings, usize) -> f64,
    ) {
        self.arrays.push(Array {
            name: format!("profile.{name}"),
            description: format!("{text} at xi = 0/{PROFILE_POINTS}, 1/{PROFILE_POINTS} and so on of the belt length"),
            first,
            size: u32::try_from(PROFILE_POINTS).unwrap_or(u32::MAX),
        });
        for (at, reference) in (0..PROFILE_POINTS).zip(first..) {
            let number = at + 1;
            self.read(
                &format!("profile.{name}[{number}]"),
                reference,
                (Local, unit, typical(nominal)),
                &format!("{text} at xi = {at}/{PROFILE_POINTS} of the belt length"),
                Access::Element(get, at),
            );
        }
    }
}

/// Shares of a whole, which are shown in per cent.
const SHARES: [&str; 4] = ["slip", "efficiency", "efficiency.belt", "friction.fall"];

fn display_unit(name: &str, unit: &str) -> Option<&'static str> {
    match unit {
        "rad" => Some("deg"),
        "rad/s" => Some("rpm"),
        "m" => Some("mm"),
        "N" => Some("kN"),
        "1" if SHARES.contains(&name) => Some("%"),
        _ => None,
    }
}

fn typical(nominal: f64) -> Range {
    Range {
        nominal: Some(nominal),
        ..Range::default()
    }
}

fn between(min: f64, max: f64, nominal: f64) -> Range {
    Range {
        min: Some(min),
        max: Some(max),
        nominal: Some(nominal),
    }
}

fn not_negative(nominal: f64) -> Range {
    Range {
        min: Some(0.0),
        max: None,
        nominal: Some(nominal),
    }
}

#[rustfmt::skip]
macro_rules! pulley_inputs {
    ($t:ident, $pulley:ident) => {
        $t.set("{}.torque", 1, Input, "N.m", "External torque on the {} shaft, positive in the direction of positive speed (a load is negative)", set!(inputs.$pulley.torque));
        $t.set("{}.clampingForce", 2, Input, "N", "Force that closes the {} sheaves", set!(inputs.$pulley.clamping_force));
        $t.set("{}.speedSetpoint", 3, Input, "rad/s", "Speed set point, used with {}.drive = Speed only", set!(inputs.$pulley.speed_setpoint));
    };
}

#[rustfmt::skip]
macro_rules! pulley_outputs {
    ($t:ident, $pulley:ident) => {
        $t.read("{}.speed", 11, (Output, "rad/s", typical(200.0)), "Speed of the {} pulley", read!($pulley.speed));
        $t.read("{}.radius", 12, (Output, "m", typical(0.06)), "Running radius on the {} pulley: pressure-weighted mean pitch radius of the arc", read!($pulley.radius));
        $t.read("{}.position", 13, (Output, "m", typical(0.01)), "Displacement of the movable {} sheave, closing positive, 0 at ratio 1", read!($pulley.position));
        $t.read("{}.axialForce", 14, (Output, "N", typical(1e4)), "Axial force of the belt on one {} sheave", read!($pulley.axial_force));
        $t.read("{}.shaftTorque", 15, (Output, "N.m", typical(100.0)), "Torque of the belt on the {} pulley, negative where power goes in; the drag of the shaft is not in it", read!($pulley.shaft_torque));
        $t.read("{}.externalTorque", 16, (Output, "N.m", typical(100.0)), "External torque on the {} shaft at the end of the last step: the input, or the reaction in speed drive", read!($pulley.external_torque));
        $t.read("{}.power", 17, (Output, "W", typical(1e4)), "Power from the {} shaft into the belt, -shaftTorque * speed; what accelerates {}.inertia is not in it, nor the drag of the shaft", read!($pulley.power));
        $t.read("spiral.{}", 18, (Output, "m", not_negative(1e-4)), "Spiral running: spread of the running radius within the {} arc", read!($pulley.spiral));
        $t.read("{}.tilt", 19, (Output, "rad", not_negative(1e-3)), "Tilt of one {} sheave under the belt, the mean of both sheaves", read!($pulley.tilt));
    };
}

#[rustfmt::skip]
macro_rules! pulley_parameters {
    ($t:ident, $pulley:ident) => {
        $t.choice("{}.drive", 31, &DRIVE, "What drives the {} shaft", choose!(parameters.$pulley.drive, 2 => Drive::Speed; Drive::Torque));
        $t.choice("{}.axial", 32, &AXIAL, "What holds the movable {} sheave", choose!(parameters.$pulley.axial, 2 => Axial::Held; Axial::Force));
        $t.set("{}.inertia", 33, Parameter, "kg.m2", "Moment of inertia of the {} pulley and of what is rigidly connected to it", set!(parameters.$pulley.inertia));
        $t.set("{}.sheaveMass", 34, Parameter, "kg", "Mass of the movable {} sheave", set!(parameters.$pulley.sheave_mass));
        $t.set("{}.sheaveDamping", 35, Parameter, "N.s/m", "Viscous damping of the axial motion of the {} sheave", set!(parameters.$pulley.sheave_damping));
        $t.set("{}.tiltStiffness", 36, Parameter, "N.m/rad", "Tilt stiffness of one {} sheave beyond its clearance; rigid from 1e12 on. The tilt is the mean of both sheaves", set!(parameters.$pulley.tilt.stiffness));
        $t.set("{}.tiltClearance", 40, Parameter, "rad", "Clearance by which one {} sheave tilts as soon as it is loaded, the mean of both sheaves; 0: the tilt is linear", set!(parameters.$pulley.tilt.clearance));
        $t.set("{}.tiltTime", 37, Parameter, "s", "Relaxation time of the tilt of the {} sheaves", set!(parameters.$pulley.tilt.time));
        $t.set("{}.minRadius", 38, Parameter, "m", "Pitch radius at the opening stop of the {} sheaves", set!(parameters.$pulley.min_radius));
        $t.set("{}.maxRadius", 39, Parameter, "m", "Pitch radius at the closing stop of the {} sheaves", set!(parameters.$pulley.max_radius));
        $t.set("{}.drag.constant", 41, Parameter, "N.m", "Drag torque of the {} shaft that depends neither on speed nor on load: seals", set!(parameters.$pulley.drag.constant));
        $t.set("{}.drag.viscous", 42, Parameter, "N.m.s/rad", "Drag torque of the {} shaft per speed: oil", set!(parameters.$pulley.drag.viscous));
        $t.set("{}.bearing.friction", 43, Parameter, "1", "Friction coefficient of the bearings of the {} shaft, under the resultant of the belt's contact forces on the pulley; 0 where they are modelled outside", set!(parameters.$pulley.drag.bearing_friction));
        $t.set("{}.bearing.radius", 44, Parameter, "m", "Mean radius of the bearings of the {} shaft", set!(parameters.$pulley.drag.bearing_radius));
    };
}

/// The variable table of the variator.
#[rustfmt::skip]
pub(super) fn table() -> Table<Settings, Readings> {
    let mut rows = Rows {
        variables: Vec::new(),
        arrays: Vec::new(),
        owner: WHOLE,
    };
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
    Table::new(UNITS, ENUMERATIONS, rows.variables).with_arrays(rows.arrays)
}

#[rustfmt::skip]
fn outputs(t: &mut Rows) {
    t.read("thrustRatio", 1, (Output, "1", between(-100.0, 100.0, 1.0)), "Axial belt force on the primary sheave / on the secondary sheave; 0 where the latter is below 1 N", read!(thrust_ratio));
    t.read("belt.speed", 2, (Output, "m/s", typical(10.0)), "Mean pitch-line speed of the elements", read!(belt_speed));
    t.read("ring.speed", 3, (Output, "m/s", typical(10.0)), "Drift rate of the ring", read!(ring_speed));
    t.read("ratio.speed", 4, (Output, "1", typical(1.0)), "Primary speed / secondary speed; 0 at standstill", read!(ratio_speed));
    t.read("ratio.geometric", 5, (Output, "1", typical(1.0)), "secondary.radius / primary.radius", read!(ratio_geometric));
    t.read("reference.theta", 6, (Output, "1", between(-1.0, 1.0, 0.3)), "Ratio coordinate Theta of the reference curve: (1 - i)/(1 + i) of its radii, positive in overdrive", read!(reference_theta));
    t.read("slip", 7, (Output, "1", between(-2.0, 2.0, 0.01)), "1 - (secondary speed / primary speed) * ratio.geometric; 0 where the primary pulley hardly turns, even if the belt slips through (see macroSlip)", read!(slip));
    t.read("efficiency", 8, (Output, "1", typical(1.0)), "Driven / driving shaft power, 0 to 1; 0 where no power flows. The drag of the shafts is in it. Means little while speeds change: the belt's kinetic energy is in it", read!(efficiency));
    t.read("torqueUtilisation", 9, (Output, "1", between(0.0, 10.0, 1.0)), "Belt torque on the primary pulley / (2 friction.pulley secondary.axialForce primary.radius / cos(geometry.wedgeAngle)). The belt slips through below 1 where the primary pulley slips first: in underdrive from about 0.8 driving and 0.6 in overrun", read!(torque_utilisation));
    t.add("macroSlip", 10, Output, "Whether all loaded elements of a pulley slide tangentially one way", Kind::Boolean { access: read!(macro_slip) });
    t.read("loss.total", 11, (Output, "W", typical(100.0)), "All losses", Access::Reading(|readings| readings.outputs.losses.total()));
    t.read("loss.sheaves", 12, (Output, "W", typical(100.0)), "Loss by friction between elements and sheaves", read!(losses.sheaves));
    t.read("loss.ring", 13, (Output, "W", typical(100.0)), "Loss by friction between ring and elements", read!(losses.ring));
    t.read("loss.other", 14, (Output, "W", typical(10.0)), "Loss in sheave dampers, tilt relaxation, chain, structural and contact damping and end stops", read!(losses.other));
    t.read("efficiency.belt", 24, (Output, "1", typical(1.0)), "Driven / driving power at the belt, 0 to 1; 0 where no power flows. The drag of the shafts is not in it", read!(belt_efficiency));
    t.read("loss.layers", 25, (Output, "W", typical(10.0)), "Loss by friction between the layers of the ring", read!(losses.layers));
    t.read("loss.shafts", 26, (Output, "W", typical(100.0)), "Loss by the drag of both shafts in seals, oil and bearings", read!(losses.shafts));
    t.read("pushForce.max", 15, (Output, "N", typical(1000.0)), "Largest push force between elements", read!(push_force_max));
    t.read("ring.tensionMax", 16, (Output, "N", typical(1000.0)), "Largest ring tension", read!(ring_tension_max));
    t.read("ring.tensionMin", 17, (Output, "N", typical(1000.0)), "Smallest ring tension", read!(ring_tension_min));
    t.work("solver.steps", 27, "Steps of the integrator since the start, those included that were refused", Access::Reading(|readings| readings.outputs.work.steps));
    t.work("solver.jacobians", 28, "Jacobians formed and factored since the start", Access::Reading(|readings| readings.outputs.work.jacobians));
    t.work("solver.residuals", 29, "Residuals evaluated since the start", Access::Reading(|readings| readings.outputs.work.residuals));
    t.read("solver.defect", 30, (Output, "1", not_negative(1.0)), "What the solutions of the last communication step were left to change by another correction, as a share of what accurate steps tolerate at the default tolerance: below 1 in accurate steps, above 1 in ticks of real time that were not solved", read!(work.defect));
    t.read("solver.behind", 31, (Output, "s", not_negative(1e-3)), "How far outputs are behind the clock in real time, while a tick that isn't solved yet goes on; 0 in accurate steps", read!(work.behind));
    t.work("solver.rollbacks", 32, "Rollbacks of real time since the start: a tick ended too far from its solution, and the run went back to the last state that was solved", Access::Reading(|readings| readings.outputs.work.rollbacks));
    t.read("belt.misalignment", 20, (Output, "m", typical(1e-3)), "Axial offset of the primary belt plane from the secondary's; it changes with the ratio, because the movable sheaves stand on opposite sides", read!(misalignment));
    t.read("belt.lateralMax", 21, (Output, "m", not_negative(1e-3)), "Largest deflection of the ring from the middle between the two belt planes; 0 without ring.spatial", read!(lateral_max));
    t.read("belt.skew", 22, (Output, "rad", typical(1e-2)), "Mean inclination of the strands against the plane of the drive, from secondary to primary; 0 without ring.spatial", read!(skew));
}

#[rustfmt::skip]
fn parameters(t: &mut Rows) {
    t.choice("ring.model", 1001, &RING_MODEL, "Level of detail of the ring", choose!(parameters.ring_model, 1 => RingModel::Ale0, 3 => RingModel::Rcm, 4 => RingModel::Ancf; RingModel::Ale));
    t.set("initial.ratio", 1011, Parameter, "1", "Geometric ratio secondary radius / primary radius at the start, between the end stops. A loaded belt rests up to some 5 % beyond them; up to 6 % beyond is taken for the stop", set!(parameters.initial.ratio));
    t.set("initial.primarySpeed", 1012, Parameter, "rad/s", "Speed of the primary pulley at the start; 0 is a standstill, where the belt starts clamped. A shaft with drive = Speed starts at its set point instead", set!(parameters.initial.primary_speed));
    t.switch("initial.steady", 1013, "Start from the steady state at this ratio and speed (RCM, ANCF: laid on that of ALE), with the primary sheave held there and unbalanced torque taken up by the inertias; if false, from the unloaded kinematic state", set!(parameters.initial.steady));
    t.switch("initial.equilibrium", 1014, "With initial.steady: the ratio too is solved for, from the two clamping forces", set!(parameters.initial.equilibrium));
    t.set("geometry.centerDistance", 1021, Parameter, "m", "Distance of the pulley axes", set!(parameters.geometry.center_distance));
    t.set("geometry.beltLength", 1022, Parameter, "m", "Length of the unstretched ring centre line", set!(parameters.geometry.belt_length));
    t.set("geometry.wedgeAngle", 1023, Parameter, "rad", "Half wedge angle of the sheaves", set!(parameters.geometry.wedge_angle));
    t.set("geometry.pulleyOffset", 1024, Parameter, "m", "Axial offset at ratio 1 of the primary belt plane from the secondary's, towards the movable primary sheave; felt with ring.spatial", set!(parameters.geometry.pulley_offset));
    t.set("belt.pitchOffset", 1031, Parameter, "m", "Distance of the pitch line (rocking edge) inside the ring centre line", set!(parameters.belt.pitch_offset));
    t.set("belt.play", 1032, Parameter, "m", "End play: pitch-line length less the stacked thickness of all elements", set!(parameters.belt.play));
    t.set("belt.massPerLength", 1033, Parameter, "kg/m", "Mass of the elements alone per pitch-line length", set!(parameters.belt.mass_per_length));
    t.set("belt.pushStiffness", 1034, Parameter, "N", "Push force per strain of the element stack", set!(parameters.belt.push_stiffness));
    t.set("belt.damping", 1035, Parameter, "s", "Damping time of the element stack, in contact only", set!(parameters.belt.damping));
    t.set("belt.roughness", 1037, Parameter, "m", "Roughness of the elements' faces: the distance over which neighbouring elements come into contact", set!(parameters.belt.roughness));
    t.set("belt.elementThickness", 1038, Parameter, "m", "Thickness of an element", set!(parameters.belt.element_thickness));
    t.set("belt.filmForce", 1039, Parameter, "N", "Force between elements at their first touch by what reaches further than the roughness: oil, waviness and rocking of the faces", set!(parameters.belt.film_force));
    t.set("belt.filmThickness", 1040, Parameter, "m", "Distance over which belt.filmForce and belt.squeezeDamping fall off", set!(parameters.belt.film_thickness));
    t.set("belt.filmDamping", 1057, Parameter, "N.s", "Force between elements per rate of strain by the oil that is squeezed between them, across gaps too", set!(parameters.belt.film_damping));
    t.set("belt.squeezeDamping", 1085, Parameter, "N.s", "Force between elements per rate of strain by the oil that is squeezed out of a gap as it closes, where the gap is zero; it falls with the cube of the gap, over belt.filmThickness", set!(parameters.belt.squeeze_damping));
    t.set("ring.massPerLength", 1041, Parameter, "kg/m", "Mass of the ring sets per length", set!(parameters.ring.mass_per_length));
    t.set("ring.axialStiffness", 1042, Parameter, "N", "Axial stiffness EA of the ring sets", set!(parameters.ring.axial_stiffness));
    t.set("ring.bendingStiffness", 1043, Parameter, "N.m2", "Bending stiffness EI of the ring sets in the plane of the drive", set!(parameters.ring.bending_stiffness));
    t.set("ring.lateralBendingStiffness", 1046, Parameter, "N.m2", "Bending stiffness EI of the ring sets out of the plane of the drive, with ring.spatial", set!(parameters.ring.lateral_bending_stiffness));
    t.switch("ring.spatial", 1047, "Whether the ring deflects out of the plane of the drive too, as misaligned pulleys make it do; ring.model ALE only", set!(parameters.spatial));
    t.switch("ring.referenceDirections", 1048, "Whether the deflection is counted along tangent, normal and binormal of the reference curve instead of along x, y, z; ring.model ALE with mesh.aligned only", set!(parameters.reference_directions));
    t.count("ring.elements", 1045, "Elements of a ring that travels with its mesh (RCM, ANCF), at least 16; 0: 32 for RCM, 40 for ANCF. More of them need a finer mesh of the cells, which carry the ring in between", set!(parameters.ring_elements));
    t.set("ring.damping", 1044, Parameter, "s", "Kelvin-Voigt damping time of the axial strain", set!(parameters.ring.damping));
    t.count("ring.layers", 1049, "Layers of each ring set, which slip on each other at other ratios than 1", set!(parameters.layers.count));
    t.set("ring.layerThickness", 1050, Parameter, "m", "Thickness of a layer of the ring sets", set!(parameters.layers.thickness));
    t.set("friction.pulley", 1051, Tunable, "1", "Friction coefficient between element and sheave, below tan(geometry.wedgeAngle)", set!(parameters.friction.pulley));
    t.set("friction.ring", 1052, Tunable, "1", "Friction coefficient between ring and element", set!(parameters.friction.ring));
    t.set("friction.fall", 1054, Parameter, "1", "Share of friction.pulley that is lost in fast sliding: mu(v) = friction.pulley (1 - fall v2/(v2 + fallSpeed2)); 0 is Coulomb's law", set!(parameters.friction.fall));
    t.set("friction.fallSpeed", 1055, Parameter, "m/s", "Sliding speed at which half of friction.fall is lost", set!(parameters.friction.fall_speed));
    t.set("friction.velocity", 1053, Parameter, "m/s", "Regularisation speed of the friction between element and sheave, at most 1e-3 for accurate micro-slip", set!(parameters.friction.velocity));
    t.set("friction.ringVelocity", 1059, Parameter, "m/s", "Regularisation speed of the friction between ring and element", set!(parameters.friction.ring_velocity));
    t.set("friction.layers", 1056, Parameter, "1", "Friction coefficient between the layers of the ring sets", set!(parameters.layers.friction));
    t.set("contact.stiffness", 1061, Parameter, "N/m2", "Contact stiffness per flank and pitch-line length", set!(parameters.contact.stiffness));
    t.set("contact.roughness", 1063, Parameter, "m", "Roughness of flank and sheave: the distance over which they come into contact", set!(parameters.contact.roughness));
    t.set("contact.damping", 1062, Parameter, "s", "Damping time of the contact", set!(parameters.contact.damping));
    t.count("mesh.primaryArc", 1071, "Ring elements on the primary arc", set!(parameters.mesh.primary_arc));
    t.count("mesh.secondaryArc", 1072, "Ring elements on the secondary arc, an even number", set!(parameters.mesh.secondary_arc));
    t.count("mesh.strand", 1073, "Ring elements on each strand", set!(parameters.mesh.strand));
    t.count("mesh.cellsPerElement", 1074, "Cells of the element chain in each ring element (ALE; in ALE0 it is one)", set!(parameters.mesh.cells_per_element));
    t.switch("mesh.aligned", 1075, "Whether element borders follow the arc borders; if not, as many elements stand evenly spaced along the belt and arc borders move through them. ring.model ALE0 and ALE", set!(parameters.mesh.aligned));
    t.choice("solver.mode", 1084, &MODE, "Accurate, or the same bounded work in each millisecond, for real time", choose!(parameters.solver.mode, 2 => Mode::RealTime; Mode::Accurate));
    t.count("solver.effort", 1086, "RealTime: Jacobians in a millisecond, with eight residuals each. Fewer take less time; more follow loads that jump more closely", set!(parameters.solver.effort));
    t.set("solver.tolerance", 1081, Parameter, "1", "Relative tolerance of the error control; left at its default, a tolerance of the experiment takes its place. Under smooth loads a coarser one is no faster, for steps are as long as the communication steps; under loads that jump it is. Output derivatives of forces and losses want 1e-6", set!(parameters.solver.tolerance));
    t.set("solver.maxStep", 1082, Parameter, "s", "Longest internal step; ticks of real time are 1 ms or shorter", set!(parameters.solver.max_step));
    t.set("inputs.ramp", 1083, Parameter, "s", "Time over which an input that is set before a step reaches its new value, no longer than that step; 0: it jumps, -1: the whole step. Inputs whose derivative is set follow that", set!(parameters.solver.input_ramp));
}

#[rustfmt::skip]
fn locals(t: &mut Rows) {
    t.read("stored.energy", 18, (Local, "J", typical(1000.0)), "Stored energy", read!(stored_energy));
    t.read("energy.residual", 19, (Local, "J", typical(1.0)), "Energy balance since the start: supplied - lost - stored", read!(energy_residual));
    t.add("initial.found", 23, Local, "What the run started from: the steady state that was asked for, or why another one", Kind::Enumeration { of: &START_STATE, access: Access::Reading(|readings| readings.outputs.start_state as i32) });
    t.profile("position", 10_001, "m", 1.0, "Place xi along the belt", |readings, at| readings.profile.position[at]);
    t.profile("pushForce", 10_101, "N", 1000.0, "Push force", |readings, at| readings.profile.push_force[at]);
    t.profile("ringTension", 10_201, "N", 1000.0, "Ring tension", |readings, at| readings.profile.ring_tension[at]);
    t.profile("normalForce", 10_301, "N/m", 1e5, "Normal force per flank and length", |readings, at| readings.profile.normal_force[at]);
    t.profile("radialDeviation", 10_401, "m", 1e-4, "Radius less the mean radius of the arc (on strands: outward distance from the tangent line of the reference curve)", |readings, at| readings.profile.radial_deviation[at]);
    t.profile("slidingSpeed", 10_501, "m/s", 0.01, "Tangential sliding speed of the flanks", |readings, at| readings.profile.sliding_speed[at]);
    t.profile("lateralDeflection", 10_601, "m", 1e-3, "Deflection of the ring from the middle between the two belt planes, along the pulley axes", |readings, at| readings.profile.lateral_deflection[at]);
}
