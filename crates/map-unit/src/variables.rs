//! The variable table. Names, value references, units, defaults and limits are those of the detailed unit; a test compares them with
//! its model description. `map.outside` is the only other variable.

use pushbelt_fmi::table::{Access, Causality, Enumeration, Item, Kind, Range, Table, UnitDefinition, Variable};
use pushbelt_fmi::{setting, si};

use crate::settings::{Axial, Drive, Readings, Settings};

use Causality::{Input, Local, Output, Parameter, Tunable};

type V = Variable<Settings, Readings>;

const UNITS: &[UnitDefinition] = &[
    si::ONE,
    si::RADIAN_PER_SECOND,
    si::SECOND,
    si::METRE,
    si::METRE_PER_SECOND,
    si::KILOGRAM_SQUARE_METRE,
    si::NEWTON,
    si::NEWTON_PER_METRE,
    si::PASCAL,
    si::SQUARE_METRE,
    si::CUBIC_METRE_PER_SECOND,
    si::NEWTON_SQUARE_SECOND_PER_SQUARE_RADIAN,
    si::NEWTON_METRE,
    si::NEWTON_METRE_SECOND_PER_RADIAN,
    si::JOULE,
    si::WATT,
];

static DRIVE: Enumeration = Enumeration {
    name: "Drive",
    description: "Boundary condition of the shaft of a pulley",
    items: &[
        Item::new("Torque", Drive::Torque as i32, "The shaft torque is the input"),
        Item::new(
            "Speed",
            Drive::Speed as i32,
            "The speed follows its set point with a lag of 1 ms; the required torque is an output",
        ),
    ],
};

static AXIAL: Enumeration = Enumeration {
    name: "Axial",
    description: "Boundary condition of the movable sheave of a pulley",
    items: &[
        Item::new(
            "Force",
            Axial::Force as i32,
            "Clamping force and pressure are the inputs",
        ),
        Item::new(
            "Held",
            Axial::Held as i32,
            "The sheave is held at the position where the geometric ratio is initial.ratio; clamping force and pressure are ignored",
        ),
    ],
};

static ENUMERATIONS: &[&Enumeration] = &[&DRIVE, &AXIAL];

/// A real variable. Angles, forces, lengths and speeds are shown in the units of workshops.
fn real(
    (reference, name, causality, unit, limits): (u32, &str, Causality, &'static str, Range),
    description: &str,
    access: Access<Settings, Readings, f64>,
) -> V {
    let display_unit = match unit {
        "rad/s" => Some("rpm"),
        "N" => Some("kN"),
        "Pa" => Some("bar"),
        "m" => Some("mm"),
        "1" if matches!(name, "slip" | "efficiency" | "efficiency.belt") => Some("%"),
        _ => None,
    };
    V {
        kind: Kind::Real {
            unit,
            display_unit,
            range: limits,
            access,
        },
        ..V::real(reference, name, description, causality, unit, Access::Reading(|_| 0.0))
    }
}

fn switch(
    reference: u32,
    name: &str,
    description: &str,
    causality: Causality,
    access: Access<Settings, Readings, bool>,
) -> V {
    V {
        name: name.to_owned(),
        reference,
        description: description.to_owned(),
        causality,
        kind: Kind::Boolean { access },
    }
}

fn choice(
    reference: u32,
    name: &str,
    description: &str,
    of: &'static Enumeration,
    access: Access<Settings, Readings, i32>,
) -> V {
    V {
        name: name.to_owned(),
        reference,
        description: description.to_owned(),
        causality: Parameter,
        kind: Kind::Enumeration { of, access },
    }
}

macro_rules! read {
    ($($field:ident).+) => {
        Access::Reading(|readings: &Readings| readings.$($field).+)
    };
}

macro_rules! choose {
    ($pulley:ident.$field:ident, $second:expr, $first:expr) => {
        Access::Setting {
            get: |settings| settings.$pulley.$field as i32,
            set: |settings, number| settings.$pulley.$field = if number == 2 { $second } else { $first },
        }
    };
}

/// Variables of a pulley, with 100 or 200 added to their references.
macro_rules! pulley {
    ($list:ident, $pulley:ident, $base:literal) => {
        let text = |text: &str| text.replace("{}", stringify!($pulley));
        let mut add = |reference: u32, name: &str, (causality, unit, limits): (Causality, &'static str, Range), what: &str, access| {
            let name = format!("{}.{name}", stringify!($pulley));
            $list.push(real(($base + reference, &name, causality, unit, limits), &text(what), access));
        };
        add(1, "torque", (Input, "N.m", Range::between(-1e4, 1e4)), "External torque on the {} shaft, positive in the direction of positive speed; a load is negative", setting!(inputs.$pulley.torque));
        add(2, "clampingForce", (Input, "N", Range::between(0.0, 5e5)), "Clamping force that closes the {} sheaves", setting!(inputs.$pulley.clamping_force));
        add(3, "speedSetpoint", (Input, "rad/s", Range::between(-1e4, 1e4)), "Speed set point of the {} shaft; used only with {}.drive = Speed", setting!(inputs.$pulley.speed_setpoint));
        add(4, "pressure", (Input, "Pa", Range::between(-1e5, 2e7)), "Pressure in the cylinder of the {} pulley above ambient, which acts on {}.cylinder.area in addition to {}.clampingForce", setting!(inputs.$pulley.pressure));
        add(25, "sheaveVelocity", (Output, "m/s", Range::typical(0.01)), "Speed of the movable {} sheave, positive when it closes", read!($pulley.sheave_velocity));
        add(24, "cylinder.flow", (Output, "m3/s", Range::typical(1e-4)), "Flow into the cylinder of the {} pulley, {}.cylinder.area * {}.sheaveVelocity", read!($pulley.flow));
        add(23, "clampingForceTotal", (Output, "N", Range::typical(1e4)), "Force that closes the {} sheaves at the end of the last step: {}.clampingForce, pressure, spring, rotating oil and seals, or the reaction of a held sheave", read!($pulley.axial_force));
        add(11, "speed", (Output, "rad/s", Range::typical(200.0)), "Speed of the {} pulley", read!($pulley.speed));
        add(12, "radius", (Output, "m", Range::typical(0.06)), "Running radius on the {} pulley: pitch radius of the arc", read!($pulley.radius));
        add(14, "axialForce", (Output, "N", Range::typical(1e4)), "Axial force of the belt on one {} sheave", read!($pulley.axial_force));
        add(15, "shaftTorque", (Output, "N.m", Range::typical(100.0)), "Torque of the belt on the {} pulley, without the drag of the shaft; negative when the shaft drives the belt", read!($pulley.shaft_torque));
        add(16, "externalTorque", (Output, "N.m", Range::typical(100.0)), "External torque on the {} shaft at the end of the last step: the input, or with {}.drive = Speed the torque that maintains the speed", read!($pulley.external_torque));
        add(17, "power", (Output, "W", Range::typical(1e4)), "Power from the {} shaft into the belt, -shaftTorque * speed, without the acceleration of {}.inertia and the drag of the shaft", read!($pulley.power));
        add(33, "inertia", (Parameter, "kg.m2", Range::between(1e-6, 1e6)), "Moment of inertia of the {} pulley and everything rigidly connected to it", setting!($pulley.inertia));
        add(38, "minRadius", (Parameter, "m", Range::between(1e-3, 10.0)), "Pitch radius at the opening stop of the {} sheaves", setting!($pulley.min_radius));
        add(39, "maxRadius", (Parameter, "m", Range::between(1e-3, 10.0)), "Pitch radius at the closing stop of the {} sheaves", setting!($pulley.max_radius));
        add(41, "drag.constant", (Parameter, "N.m", Range::between(0.0, 1e3)), "Drag torque of the {} shaft that does not depend on speed or load, as of seals", setting!($pulley.drag_constant));
        add(42, "drag.viscous", (Parameter, "N.m.s/rad", Range::between(0.0, 10.0)), "Drag torque of the {} shaft per speed, as of oil", setting!($pulley.drag_viscous));
        add(43, "bearing.friction", (Parameter, "1", Range::between(0.0, 1.0)), "Friction coefficient of the bearings of the {} shaft under the resultant of the belt's contact forces on the pulley; set 0 if another model includes the bearings", setting!($pulley.bearing_friction));
        add(44, "bearing.radius", (Parameter, "m", Range::between(0.0, 1.0)), "Mean radius of the bearings of the {} shaft", setting!($pulley.bearing_radius));
        add(45, "cylinder.area", (Parameter, "m2", Range::between(0.0, 1.0)), "Area of the {} piston, on which {}.pressure acts; 0: no cylinder", setting!($pulley.cylinder.area));
        add(46, "cylinder.springForce", (Parameter, "N", Range::between(-1e5, 1e5)), "Force at ratio 1 of the spring that closes the {} sheaves", setting!($pulley.cylinder.spring_force));
        add(47, "cylinder.springStiffness", (Parameter, "N/m", Range::between(0.0, 1e7)), "Stiffness of the spring of the {} sheaves: its force falls with the position", setting!($pulley.cylinder.spring_stiffness));
        add(48, "cylinder.centrifugal", (Parameter, "N.s2/rad2", Range::between(-10.0, 10.0)), "Closing force of the oil that rotates with the {} pulley per square of the speed; negative with an overcompensated cylinder", setting!($pulley.cylinder.centrifugal));
        add(49, "cylinder.seal", (Parameter, "N", Range::between(0.0, 1e4)), "Friction of the seals of the {} cylinder, against {}.sheaveVelocity", setting!($pulley.cylinder.seal));
        $list.push(choice($base + 31, &format!("{}.drive", stringify!($pulley)), &text("Boundary condition of the {} shaft: torque or speed"), &DRIVE, choose!($pulley.drive, Drive::Speed, Drive::Torque)));
        $list.push(choice($base + 32, &format!("{}.axial", stringify!($pulley)), &text("Boundary condition of the movable {} sheave: force or held"), &AXIAL, choose!($pulley.axial, Axial::Held, Axial::Force)));
    };
}

/// All variables.
#[rustfmt::skip]
pub(crate) fn table() -> Table<Settings, Readings> {
    let mut list = Vec::new();
    pulley!(list, primary, 100);
    pulley!(list, secondary, 200);
    let mut add = |reference: u32, name: &str, head: (Causality, &'static str, Range), what: &str, access| {
        let (causality, unit, limits) = head;
        list.push(real((reference, name, causality, unit, limits), what, access));
    };
    add(1, "thrustRatio", (Output, "1", Range::between(-100.0, 100.0).of_size(1.0)), "Thrust ratio: axial force on the primary sheave / on the secondary sheave; 0 if the latter is below 1 N", read!(thrust_ratio));
    add(2, "belt.speed", (Output, "m/s", Range::typical(10.0)), "Mean pitch-line speed of the elements: the mean of both pulleys", read!(belt_speed));
    add(4, "ratio.speed", (Output, "1", Range::typical(1.0)), "Primary speed / secondary speed; 0 at standstill", read!(ratio_speed));
    add(5, "ratio.geometric", (Output, "1", Range::typical(1.0)), "secondary.radius / primary.radius", read!(ratio_geometric));
    add(7, "slip", (Output, "1", Range::between(-2.0, 2.0).of_size(0.01)), "1 - (secondary speed / primary speed) * ratio.geometric; 0 near standstill of the primary pulley, even if the belt slips through (see macroSlip)", read!(slip));
    add(8, "efficiency", (Output, "1", Range::typical(1.0)), "Driven / driving shaft power, including the drag of the shafts, 0 to 1; 0 without power flow", read!(efficiency));
    add(24, "efficiency.belt", (Output, "1", Range::typical(1.0)), "Driven / driving power at the belt, without the drag of the shafts, 0 to 1; 0 without power flow", read!(belt_efficiency));
    add(9, "torqueUtilisation", (Output, "1", Range::between(0.0, 10.0).of_size(1.0)), "Belt torque on the primary pulley / (2 friction.pulley secondary.axialForce primary.radius / cos(geometry.wedgeAngle))", read!(utilisation));
    add(11, "loss.total", (Output, "W", Range::typical(100.0)), "Sum of all losses", read!(loss));
    add(26, "loss.shafts", (Output, "W", Range::typical(100.0)), "Drag loss of both shafts in seals, oil and bearings", read!(shaft_loss));
    add(36, "loss.seals", (Output, "W", Range::typical(1.0)), "Friction loss of the seals of both cylinders", read!(seal_loss));
    add(18, "stored.energy", (Local, "J", Range::typical(1000.0)), "Kinetic energy of both shafts", read!(stored_energy));
    add(1011, "initial.ratio", (Parameter, "1", Range::between(0.01, 100.0)), "Geometric ratio secondary radius / primary radius at the start; beyond an end stop the run starts at the stop", setting!(ratio));
    add(1012, "initial.primarySpeed", (Parameter, "rad/s", Range::between(-1e4, 1e4)), "Speed of the primary pulley at the start. A shaft with drive = Speed starts at its set point instead", setting!(primary_speed));
    add(1051, "friction.pulley", (Tunable, "1", Range::between(0.0, 1.0)), "Friction coefficient between element and sheave, which scales the torque at a slip; must be below tan(geometry.wedgeAngle)", setting!(friction));
    add(1083, "inputs.ramp", (Parameter, "s", Range::between(-1.0, 10.0)), "Time over which an input that is set before a step ramps to its new value, at most that step; 0: it jumps, -1: the whole step. Inputs with a derivative follow the derivative instead", setting!(ramp));
    list.push(switch(10, "macroSlip", "True if the slip is beyond that at the capacity: the belt slips through", Output, read!(macro_slip)));
    list.push(switch(90, "map.outside", "True if ratio, speed or force is beyond the tables, whose values at the border are used", Output, read!(outside)));
    list.push(switch(1013, "initial.steady", "True: start with the slip of the steady state, unbalanced torque accelerating the inertias. False: start without slip", Parameter, setting!(steady)));
    list.push(switch(1014, "initial.equilibrium", "With initial.steady: also solve for the ratio at which the two clamping forces are in equilibrium", Parameter, setting!(equilibrium)));
    Table::new(UNITS, ENUMERATIONS, list)
}
