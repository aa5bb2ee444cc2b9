//! Every parameter and input once: name, value reference, type with start value and range, field,
//! description. The interface, the defaults and the checks of ranges follow.
//!
//! Rows of a pulley are written once: its name replaces `{}`, and 100 or 200 is added to the
//! reference. The ranges exclude only values that can't be intended.

use super::ParameterError;
use super::choices::{Axial, BeltKind, Drive, Mode};
use super::parameters::Parameters;
use super::signals::Inputs;
use crate::fmi::table::{Access, Causality, Kind, Range, Value, Variable};
use std::ops::RangeInclusive;

/// The pulley of a row, or the whole variator: the name that replaces `{}`, and the number that is
/// added to the reference.
type Owner = (&'static str, u32);

pub(crate) const WHOLE: Owner = ("", 0);
pub(crate) const PRIMARY: Owner = ("primary", 100);
pub(crate) const SECONDARY: Owner = ("secondary", 200);

pub(crate) struct Row<'a, S, Q> {
    pub name: &'a str,
    pub reference: u32,
    pub causality: Causality,
    pub text: &'a str,
    /// Type with field.
    pub kind: Kind<S, Q>,
}

impl<S, Q> Row<'_, S, Q> {
    /// The variable of a pulley or of the whole variator.
    pub fn variable(self, (owner, base): Owner) -> Variable<S, Q> {
        let Self { name, mut kind, .. } = self;
        if let Kind::Real {
            unit, display_unit, ..
        } = &mut kind
        {
            *display_unit = shown_in(name, unit);
        }
        Variable {
            name: name.replace("{}", owner),
            reference: base + self.reference,
            description: self.text.replace("{}", owner),
            causality: self.causality,
            kind,
        }
    }
}

/// Shares of a whole, which are shown in per cent.
const SHARES: [&str; 4] = ["slip", "efficiency", "efficiency.belt", "friction.fall"];

fn shown_in(name: &str, unit: &str) -> Option<&'static str> {
    match unit {
        "rad" => Some("deg"),
        "rad/s" => Some("rpm"),
        "m" => Some("mm"),
        "N" => Some("kN"),
        "Pa" if name.ends_with("pressure") => Some("bar"),
        "Pa" => Some("MPa"),
        "1" if SHARES.contains(&name) => Some("%"),
        _ => None,
    }
}

/// A parameter or input, whose value is in `S`.
pub struct Setting<S, Q = ()> {
    row: Row<'static, S, Q>,
    owner: Owner,
    start: Value,
}

impl<S, Q> Setting<S, Q> {
    /// The variable.
    #[must_use]
    pub fn variable(self) -> Variable<S, Q> {
        self.row.variable(self.owner)
    }

    /// Name in the interface.
    #[must_use]
    pub fn name(&self) -> String {
        self.row.name.replace("{}", self.owner.0)
    }

    pub(crate) fn is_tunable(&self) -> bool {
        self.row.causality == Causality::Tunable
    }

    /// Range of a number, to infinity where there is no limit.
    #[must_use]
    pub fn range(&self) -> Option<RangeInclusive<f64>> {
        match self.row.kind {
            Kind::Real { range, .. } => Some(range.min?..=range.max.unwrap_or(f64::INFINITY)),
            Kind::Integer { range, .. } => range.map(|(min, max)| min.into()..=max.into()),
            Kind::Boolean { .. } | Kind::Enumeration { .. } => None,
        }
    }

    /// Checks the value against its range, without an allocation.
    pub(crate) fn check(&self, of: &S) -> Result<(), ParameterError> {
        let value = match &self.row.kind {
            Kind::Real {
                access: Access::Setting { get, .. },
                ..
            } => get(of),
            Kind::Integer {
                access: Access::Setting { get, .. },
                ..
            } => get(of).into(),
            _ => return Ok(()),
        };
        let Some(range) = self.range() else {
            return Ok(());
        };
        if value.is_finite() && range.contains(&value) {
            return Ok(());
        }
        let (min, max) = range.into_inner();
        let range = if max == f64::INFINITY {
            format!("a finite number, at least {min}")
        } else {
            format!("{min} to {max}")
        };
        Err(ParameterError::new(self.name(), value, range))
    }
}

/// Range of a real or integer parameter or input, by its name in the interface; to infinity where
/// there is no limit.
#[must_use]
pub fn range_of(name: &str) -> Option<RangeInclusive<f64>> {
    match parameters::<Parameters, ()>().find(|one| one.name() == name) {
        Some(parameter) => parameter.range(),
        None => inputs::<Inputs, ()>().find(|one| one.name() == name)?.range(),
    }
}

fn started<S>(mut of: S, settings: impl Iterator<Item = Setting<S>>) -> S {
    for Setting { row, owner, start } in settings {
        let set = row.variable(owner).set(&mut of, start);
        debug_assert_eq!(set, Ok(()));
    }
    of
}

/// The laboratory variator `bench168`.
impl Default for Parameters {
    fn default() -> Self {
        started(Self::blank(), parameters())
    }
}

impl Default for Inputs {
    fn default() -> Self {
        started(Self::ZERO, inputs())
    }
}

/// A row with its start value, by name, value reference, causality unless it is a parameter,
/// type(start value, ..), field and description, of settings `S`.
macro_rules! row {
    ($name:literal, $reference:literal, $kind:ident $value:tt, $($rest:tt)*) => {
        row!($name, $reference, Parameter $kind $value, $($rest)*)
    };
    ($name:literal, $reference:literal, $causality:ident $kind:ident($($value:tt)*), $($field:ident).+, $text:literal) => {{
        let (start, kind) = value!($kind($($value)*), $($field).+);
        (Row { name: $name, reference: $reference, causality: Causality::$causality, text: $text, kind }, start)
    }};
}

macro_rules! value {
    (Real($unit:literal, $start:expr, [$min:expr, $max:expr]), $($field:ident).+) => {{
        let max: f64 = $max;
        let range = Range { min: Some($min), max: if max.is_finite() { Some(max) } else { None }, nominal: None };
        (Value::Real($start), Kind::Real { unit: $unit, display_unit: None, range, access: field!($($field).+) })
    }};
    (Count($start:literal, [$min:literal, $max:literal]), $($field:ident).+) => {
        (Value::Integer($start), Kind::Integer { range: Some(($min, $max)), access: field!($($field).+) })
    };
    (Switch($start:literal), $($field:ident).+) => {
        (Value::Boolean($start), Kind::Boolean { access: field!($($field).+) })
    };
    (Choice($of:ident::$start:ident), $($field:ident).+) => {{
        let access = Access::Setting {
            get: |of: &S| of.as_ref().$($field).+ as i32,
            set: |of: &mut S, number| of.as_mut().$($field).+ = $of::from_number(number).unwrap_or_default(),
        };
        (Value::Integer($of::$start as i64), Kind::Enumeration { of: $of::TYPE, access })
    }};
}

macro_rules! field {
    ($($field:ident).+) => {
        Access::Setting { get: |of: &S| of.as_ref().$($field).+, set: |of: &mut S, value| of.as_mut().$($field).+ = value }
    };
}

fn settings_of<S, Q, const N: usize>(
    owner: Owner,
    rows: [(Row<'static, S, Q>, Value); N],
) -> impl Iterator<Item = Setting<S, Q>> {
    rows.into_iter().map(move |(row, start)| Setting { row, owner, start })
}

#[rustfmt::skip]
macro_rules! inputs {
    ($pulley:ident, $torque:literal, $force:literal) => {
        const { [
            row!("{}.torque", 1, Input Real("N.m", $torque, [-1e4, 1e4]), $pulley.torque, "External torque on the {} shaft, positive in the direction of positive speed; a load is negative"),
            row!("{}.clampingForce", 2, Input Real("N", $force, [0.0, 5e5]), $pulley.clamping_force, "Clamping force that closes the {} sheaves"),
            row!("{}.speedSetpoint", 3, Input Real("rad/s", 209.44, [-1e4, 1e4]), $pulley.speed_setpoint, "Speed set point of the {} shaft; used only with {}.drive = Speed"),
            row!("{}.pressure", 4, Input Real("Pa", 0.0, [-1e5, 2e7]), $pulley.pressure, "Pressure in the cylinder of the {} pulley above ambient, which acts on {}.cylinder.area in addition to {}.clampingForce"),
        ] }
    };
}

#[rustfmt::skip]
macro_rules! pulley_parameters {
    ($pulley:ident) => {
        const { [
            row!("{}.drive", 31, Choice(Drive::Torque), $pulley.drive, "Boundary condition of the {} shaft: torque or speed"),
            row!("{}.axial", 32, Choice(Axial::Force), $pulley.axial, "Boundary condition of the movable {} sheave: force or held"),
            row!("{}.inertia", 33, Real("kg.m2", 0.03, [1e-6, 1e6]), $pulley.inertia, "Moment of inertia of the {} pulley and everything rigidly connected to it"),
            row!("{}.sheaveMass", 34, Real("kg", 2.0, [1e-3, 1e6]), $pulley.sheave_mass, "Mass of the movable {} sheave"),
            row!("{}.sheaveDamping", 35, Real("N.s/m", 1.2e4, [0.0, 1e9]), $pulley.sheave_damping, "Viscous damping of the axial motion of the {} sheave"),
            row!("{}.tiltStiffness", 36, Real("N.m/rad", 1.79e6, [1e3, f64::INFINITY]), $pulley.tilt.stiffness, "Tilt stiffness of one {} sheave beyond its clearance, mean of both sheaves; rigid from 1e12 on"),
            row!("{}.tiltClearance", 40, Real("rad", 0.624e-3, [0.0, 0.1]), $pulley.tilt.clearance, "Angle by which one {} sheave tilts as soon as it is loaded, mean of both sheaves; 0: the tilt is linear in the moment"),
            row!("{}.tiltTime", 37, Real("s", 2.0e-3, [1e-6, 10.0]), $pulley.tilt.time, "Relaxation time of the tilt of the {} sheaves"),
            row!("{}.minRadius", 38, Real("m", 0.030, [1e-3, 10.0]), $pulley.min_radius, "Pitch radius at the opening stop of the {} sheaves"),
            row!("{}.maxRadius", 39, Real("m", 0.082, [1e-3, 10.0]), $pulley.max_radius, "Pitch radius at the closing stop of the {} sheaves"),
            // Engineering values of a shaft of some 40 mm: T₀ of two lip seals or sealing rings, b
            // of the oil that pulley and bearings splash, μ_b between the catalogue values of ball
            // bearings, 0.0015, and roller bearings, 0.002, at half the bore.
            row!("{}.drag.constant", 41, Real("N.m", 0.15, [0.0, 1e3]), $pulley.drag.constant, "Drag torque of the {} shaft that does not depend on speed or load, as of seals"),
            row!("{}.drag.viscous", 42, Real("N.m.s/rad", 4.0e-4, [0.0, 10.0]), $pulley.drag.viscous, "Drag torque of the {} shaft per speed, as of oil"),
            row!("{}.bearing.friction", 43, Real("1", 1.8e-3, [0.0, 1.0]), $pulley.drag.bearing_friction, "Friction coefficient of the bearings of the {} shaft under the resultant of the belt's contact forces on the pulley; set 0 if another model includes the bearings"),
            row!("{}.bearing.radius", 44, Real("m", 0.02, [0.0, 1.0]), $pulley.drag.bearing_radius, "Mean radius of the bearings of the {} shaft"),
            row!("{}.cylinder.area", 45, Real("m2", 0.0, [0.0, 1.0]), $pulley.cylinder.area, "Area of the {} piston, on which {}.pressure acts; 0: no cylinder"),
            row!("{}.cylinder.springForce", 46, Real("N", 0.0, [-1e5, 1e5]), $pulley.cylinder.spring_force, "Force at ratio 1 of the spring that closes the {} sheaves"),
            row!("{}.cylinder.springStiffness", 47, Real("N/m", 0.0, [0.0, 1e7]), $pulley.cylinder.spring_stiffness, "Stiffness of the spring of the {} sheaves: its force falls with {}.position"),
            row!("{}.cylinder.centrifugal", 48, Real("N.s2/rad2", 0.0, [-10.0, 10.0]), $pulley.cylinder.centrifugal, "Closing force of the oil that rotates with the {} pulley per square of the speed; negative with an overcompensated cylinder"),
            row!("{}.cylinder.seal", 49, Real("N", 0.0, [0.0, 1e4]), $pulley.cylinder.seal, "Friction of the seals of the {} cylinder, against {}.sheaveVelocity, regularised by friction.velocity"),
        ] }
    };
}

/// The inputs in settings `S`. The ranges are more than ten times those of belts for cars.
pub fn inputs<S: AsRef<Inputs> + AsMut<Inputs>, Q>() -> impl Iterator<Item = Setting<S, Q>> {
    settings_of(PRIMARY, inputs!(primary, 50.0, 13e3))
        .chain(settings_of(SECONDARY, inputs!(secondary, -49.0, 10e3)))
}

/// The parameters in settings `S`, but for `ring.model`.
#[rustfmt::skip]
pub fn parameters<S: AsRef<Parameters> + AsMut<Parameters>, Q>() -> impl Iterator<Item = Setting<S, Q>> {
    let whole = const { [
        row!("initial.ratio", 1011, Real("1", 1.0, [1e-2, 100.0]), initial.ratio, "Geometric ratio secondary radius / primary radius at the start, between the end stops. A loaded belt rests up to some 5 % beyond them; a value up to 6 % beyond starts at the stop"),
        row!("initial.primarySpeed", 1012, Real("rad/s", 209.44, [-1e4, 1e4]), initial.primary_speed, "Speed of the primary pulley at the start; 0: standstill, the belt starts clamped. A shaft with drive = Speed starts at its set point instead"),
        row!("initial.steady", 1013, Switch(true), initial.steady, "True: start from the steady state at this ratio and speed, solved with the primary sheave held and unbalanced torque accelerating the inertias. False: start from the unloaded kinematic state"),
        row!("initial.equilibrium", 1014, Switch(false), initial.equilibrium, "With initial.steady: also solve for the ratio at which the two clamping forces are in equilibrium"),
        row!("initial.strict", 1015, Switch(false), initial.strict, "True: the initialisation fails where initial.found would be ReducedTorque, NoEquilibrium or NotFound. False: the run starts from that state, with a warning"),
        row!("geometry.centerDistance", 1021, Real("m", 0.168, [1e-2, 10.0]), geometry.center_distance, "Distance of the pulley axes"),
        row!("geometry.beltLength", 1022, Real("m", 0.703, [2e-2, 100.0]), geometry.belt_length, "Length of the unstretched ring centre line"),
        row!("geometry.wedgeAngle", 1023, Real("rad", 11.0_f64.to_radians(), [1e-2, 0.785]), geometry.wedge_angle, "Half wedge angle of the sheaves"),
        row!("geometry.pulleyOffset", 1024, Real("m", 0.0, [-0.1, 0.1]), geometry.pulley_offset, "Axial offset at ratio 1 of the primary belt plane from the secondary's, towards the movable primary sheave; used only with ring.spatial"),
        row!("belt.kind", 1065, Choice(BeltKind::PushBelt), kind, "Kind of the belt. A pull chain ignores the parameters of stack and ring friction, and its outputs of them are 0"),
        // An engineering value for rocker pins, which roll on each other.
        row!("belt.jointRadius", 1066, Real("m", 2.0e-5, [0.0, 1e-2]), joints.radius, "Pull chain: radius at which the tension causes friction in a joint, which determines loss.joints"),
        row!("belt.pitchOffset", 1031, Real("m", 1.0e-3, [0.0, 0.1]), belt.pitch_offset, "Distance by which the pitch line (rocking edge) lies inside the ring centre line"),
        row!("belt.play", 1032, Real("m", 2.0e-4, [0.0, 10.0]), belt.play, "End play: pitch-line length less the stacked thickness of all elements"),
        row!("belt.massPerLength", 1033, Real("kg/m", 1.33, [1e-3, 1e3]), belt.mass_per_length, "Mass of the elements, without the ring, per pitch-line length"),
        row!("belt.pushStiffness", 1034, Real("N", 1.0e7, [1e3, 1e13]), belt.push_stiffness, "Push force per strain of the element stack"),
        row!("belt.damping", 1035, Real("s", 5.0e-6, [0.0, 1e-2]), belt.damping, "Damping time of the element stack, in contact only"),
        row!("belt.roughness", 1037, Real("m", 1.0e-7, [1e-10, 1e-5]), belt.roughness, "Roughness of the elements' faces: distance over which the contact force between neighbouring elements rises"),
        row!("belt.elementThickness", 1038, Real("m", 1.5e-3, [1e-4, 0.1]), belt.element_thickness, "Thickness of an element"),
        // An element of 2 g and 12 mm: I = m h²/12 = 2.4e-8 as a bar, and m d² = 0.2e-8 with its
        // centre of mass 1 mm below the rocking edge. All energy of turning lost is an upper bound;
        // half of it is the estimate.
        row!("belt.elementInertia", 1058, Real("kg.m2", 1.3e-8, [0.0, 1e-4]), belt.element_inertia, "Moment of inertia of an element about its rocking edge, which determines loss.spin; 0: no such loss"),
        row!("belt.filmThickness", 1040, Real("m", 6.0e-6, [1e-8, 1e-4]), belt.film_thickness, "Gap between elements over which the forces of the oil decrease"),
        row!("belt.filmDamping", 1057, Real("N.s", 2.7, [0.0, 1e3]), belt.film_damping, "Viscosity of the oily stack: force per rate of strain, twice as large where elements approach at any gap; where they separate divided by (1 + gap/belt.filmThickness)^2"),
        row!("belt.squeezeDamping", 1085, Real("N.s", 75.0, [0.0, 1e5]), belt.squeeze_damping, "Squeeze damping: force between elements per rate of strain by oil squeezed out of a closing gap, at a gap of zero; divided by (1 + gap/belt.filmThickness)^3"),
        row!("belt.suction", 1087, Real("N", 19.0, [1e-3, 1e3]), belt.suction, "Largest suction between two elements, at which the oil cavitates: area of their faces times the pressure of the atmosphere"),
        row!("ring.massPerLength", 1041, Real("kg/m", 0.24, [1e-3, 1e3]), ring.mass_per_length, "Mass of the ring sets per length"),
        row!("ring.axialStiffness", 1042, Real("N", 5.57e6, [1e3, 1e13]), ring.axial_stiffness, "Axial stiffness EA of the ring sets"),
        row!("ring.bendingStiffness", 1043, Real("N.m2", 0.0159, [1e-6, 10.0]), ring.bending_stiffness, "Bending stiffness EI of the ring sets in the plane of the drive. A stiffer beam would lift from the pulleys"),
        row!("ring.lateralBendingStiffness", 1046, Real("N.m2", 37.6, [1e-6, 1e9]), ring.lateral_bending_stiffness, "Bending stiffness EI of the ring sets out of the plane of the drive, with ring.spatial"),
        row!("ring.spatial", 1047, Switch(false), spatial, "True: the ring also deflects out of the plane of the drive, as between misaligned pulleys. Requires ring.model = ALE"),
        row!("ring.damping", 1044, Real("s", 2.0e-5, [0.0, 1e-2]), ring.damping, "Kelvin-Voigt damping time of axial strain and bending; bending where it changes at a place, so not in steady running"),
        // Two sets of nine layers carry half the tension each, which is equivalent to one set that
        // carries all.
        row!("ring.layers", 1049, Count(9, [1, 100]), layers.count, "Layers of each ring set, which slip on each other at ratios other than 1"),
        row!("ring.layerThickness", 1050, Real("m", 1.85e-4, [0.0, 0.01]), layers.thickness, "Thickness of a layer of the ring sets"),
        row!("ring.layerWidth", 1060, Real("m", 9.0e-3, [1e-4, 1.0]), layers.width, "Width of a layer of the ring sets, for its stress only"),
        // 2π/L: layers that were aged and nitrided as circles. An engineering value: rolling may
        // leave another one.
        row!("ring.residualCurvature", 1064, Real("1/m", 8.94, [-1e3, 1e3]), layers.residual_curvature, "Curvature of a layer that is free of stress: it shifts the mean stress of bending, and nothing else"),
        row!("friction.pulley", 1051, Tunable Real("1", 0.09, [0.0, 1.0]), friction.pulley, "Friction coefficient between element and sheave; must be below tan(geometry.wedgeAngle)"),
        row!("friction.ring", 1052, Tunable Real("1", 0.05, [0.0, 1.0]), friction.ring, "Friction coefficient between ring and element, where the innermost layer slides: belt.pitchOffset - (ring.layers - 1)/2 * ring.layerThickness, at least 0, outside the pitch line"),
        row!("friction.fall", 1054, Real("1", 0.06, [0.0, 0.9]), friction.fall, "Relative decrease of friction.pulley in fast sliding: mu(v) = friction.pulley (1 - fall v^2/(v^2 + fallSpeed^2)); 0: Coulomb's law"),
        row!("friction.fallSpeed", 1055, Real("m/s", 0.5, [1e-3, 1e3]), friction.fall_speed, "Sliding speed at which half of friction.fall is reached"),
        row!("friction.velocity", 1053, Real("m/s", 5.0e-4, [1e-6, 0.1]), friction.velocity, "Regularisation velocity of the friction between element and sheave; at most 1e-3 for accurate micro-slip"),
        row!("friction.ringVelocity", 1059, Real("m/s", 2.0e-3, [1e-6, 0.1]), friction.ring_velocity, "Regularisation velocity of the friction between ring and element"),
        // An engineering value, oiled steel on steel, as between ring and elements.
        row!("friction.layers", 1056, Real("1", 0.05, [0.0, 1.0]), layers.friction, "Friction coefficient between the layers of the ring sets"),
        row!("contact.stiffness", 1061, Real("N/m2", 1.2e11, [1e6, 1e15]), contact.stiffness, "Contact stiffness per flank and pitch-line length"),
        row!("contact.roughness", 1063, Real("m", 1.0e-7, [1e-10, 1e-5]), contact.roughness, "Roughness of flank and sheave: distance over which the contact force rises"),
        row!("contact.damping", 1062, Real("s", 3.0e-6, [0.0, 1e-2]), contact.damping, "Damping time of the contact between flank and sheave"),
        row!("mesh.primaryArc", 1071, Count(16, [2, 200]), mesh.primary_arc, "Ring elements on the primary arc"),
        row!("mesh.secondaryArc", 1072, Count(16, [2, 200]), mesh.secondary_arc, "Ring elements on the secondary arc, an even number"),
        row!("mesh.strand", 1073, Count(10, [1, 200]), mesh.strand, "Ring elements on each strand"),
        row!("mesh.cellsPerElement", 1074, Count(2, [1, 16]), mesh.cells_per_element, "Cells of the element chain in each ring element; with ring.model = ALE0 always one"),
        row!("solver.mode", 1084, Choice(Mode::Accurate), solver.mode, "Accurate steps with error control, or bounded work in each millisecond for real time"),
        row!("solver.effort", 1086, Count(4, [1, 16]), solver.effort, "With solver.mode = RealTime: bound of the work of each millisecond, in the mean 15.5 times as much as a residual with its correction takes, and 28 of these more at most. Less takes less time; more is accurate under loads that jump"),
        row!("solver.tolerance", 1081, Real("1", 1.0e-4, [1e-10, 1e-1]), solver.tolerance, "Relative tolerance of the error control. At its default the tolerance of the experiment is used instead, if there is one. A coarser tolerance is faster under loads that jump, not under smooth loads, where steps are as long as the communication steps. Output derivatives of forces and losses need 1e-6"),
        row!("solver.maxStep", 1082, Real("s", 1.0e-2, [1e-6, 10.0]), solver.max_step, "Longest internal step; with solver.mode = RealTime steps are 0.2 ms or shorter"),
        row!("inputs.ramp", 1083, Real("s", 1.0e-3, [-1.0, 10.0]), solver.input_ramp, "Time over which an input that is set before a step ramps to its new value, at most that step; 0: it jumps, -1: the whole step. Inputs with a derivative follow the derivative instead"),
    ] };
    let pulleys = settings_of(PRIMARY, pulley_parameters!(primary)).chain(settings_of(SECONDARY, pulley_parameters!(secondary)));
    settings_of(WHOLE, whole).chain(pulleys)
}

/// References to a part of settings, in which rows find their fields.
macro_rules! part {
    ([$($generic:ident)?] $whole:ty => $part:ty: |$settings:ident| $place:expr) => {
        impl$(<$generic>)? AsRef<$part> for $whole {
            fn as_ref(&$settings) -> &$part {
                &$place
            }
        }

        impl$(<$generic>)? AsMut<$part> for $whole {
            fn as_mut(&mut $settings) -> &mut $part {
                &mut $place
            }
        }
    };
}
pub(crate) use part;

part!([] Parameters => Parameters: |self| *self);
part!([] Inputs => Inputs: |self| *self);
