//! The variables: those of the detailed unit that maps have values for, and those with `map.`.

use std::sync::Arc;

use pushbelt::unit::{AT_REST, shared_variables};
use pushbelt::variator::settings::{Axial, Drive, Outputs};
use pushbelt_fmi::si;
use pushbelt_fmi::table::{Access, Causality, Kind, Range, Table, Variable};

use crate::tables::Tables;

/// Parameters and inputs of the detailed unit, and the tables from the resources; none in the
/// settings of the model description.
pub type Settings = pushbelt::unit::Settings<Option<Arc<Tables>>>;

/// Outputs and locals.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Readings {
    /// Those of the detailed unit.
    pub outputs: Outputs,
    /// Whether the state is beyond the tables.
    pub outside: bool,
    /// Thrust ratio that holds the present ratio under the present torque.
    pub holding_thrust_ratio: f64,
}

impl AsRef<Outputs> for Readings {
    fn as_ref(&self) -> &Outputs {
        &self.outputs
    }
}

/// Variables of the whole variator.
const WHOLE: &str = "thrustRatio belt.speed ratio.speed ratio.geometric slip efficiency efficiency.belt torqueUtilisation \
                     macroSlip pastPeak loss.total loss.shafts loss.seals stored.energy initial.ratio initial.primarySpeed \
                     initial.steady initial.equilibrium initial.strict friction.pulley inputs.ramp";

/// Variables that only a pulley of the detailed unit has.
const NOT_OF_PULLEY: &str =
    "position tilt idleArc sheaveMass sheaveDamping tiltStiffness tiltClearance tiltTime";

/// Description of a variable, where it differs from that of the detailed unit; `{}` is the pulley.
#[rustfmt::skip]
fn text(name: &str) -> Option<&'static str> {
    Some(match name {
        "radius" => "Running radius on the {} pulley: pitch radius of the arc",
        "cylinder.volume" => "Oil in the cylinder of the {} pulley beyond that at ratio 1. Its change over a step, divided by the step, is the mean flow",
        "cylinder.springStiffness" => "Stiffness of the spring of the {} sheaves: its force falls with the position",
        "cylinder.seal" => "Friction of the seals of the {} cylinder, against {}.sheaveVelocity",
        "efficiency" => "Driven / driving shaft power, including the drag of the shafts, 0 to 1; 0 without power flow",
        "torqueUtilisation" => "Belt torque on the primary pulley / (2 friction.pulley secondary.axialForce primary.radius / cos(geometry.wedgeAngle))",
        "macroSlip" => "True if the slip is beyond that at the capacity: the belt slips through",
        "pastPeak" => "True if the slip is beyond that at the capacity, the peak of traction: the same as macroSlip",
        "stored.energy" => "Kinetic energy of both shafts",
        "initial.ratio" => "Geometric ratio secondary radius / primary radius at the start; beyond an end stop the run starts at the stop",
        "initial.primarySpeed" => "Speed of the primary pulley at the start. A shaft with drive = Speed starts at its set point instead",
        "initial.steady" => "True: start with the slip of the steady state, unbalanced torque accelerating the inertias. False: start without slip",
        "initial.strict" => "True: the initialisation fails where the belt does not carry the torques. False: the run starts without slip, with a warning",
        "friction.pulley" => "Friction coefficient between element and sheave, which scales the torque at a slip; must be below tan(geometry.wedgeAngle)",
        _ => return None,
    })
}

/// The table of variables: rows of the detailed unit, with their names, references, units, ranges
/// and start values.
pub fn table() -> Table<Settings, Readings> {
    let has = |names: &str, name: &str| names.split(' ').any(|one| one == name);
    let of_maps = |mut variable: Variable<_, _>| {
        let (pulley, name, of_maps) = match variable.name.split_once('.') {
            Some((pulley @ ("primary" | "secondary"), name)) => (pulley, name, !has(NOT_OF_PULLEY, name)),
            _ => ("", &*variable.name, has(WHOLE, &variable.name)),
        };
        if let Some(text) = text(name) {
            variable.description = text.replace("{}", pulley);
        }
        of_maps.then_some(variable)
    };
    let mut variables: Vec<_> = shared_variables(Vec::new()).into_iter().filter_map(of_maps).collect();
    variables.push(Variable {
        name: "map.outside".to_owned(),
        reference: 90,
        description:
            "True if ratio, speed or force is beyond the tables, whose values at the border are used"
                .to_owned(),
        causality: Causality::Output,
        kind: Kind::Boolean {
            access: Access::Reading(|readings: &Readings| readings.outside),
        },
    });
    let text = "Thrust ratio that holds the present ratio under the present torque; thrustRatio is that of the clamping forces";
    let access = Access::Reading(|readings: &Readings| readings.holding_thrust_ratio);
    let holding = Variable::real(91, "map.holdingThrustRatio", text, Causality::Output, "1", access);
    variables.push(holding.with_range(Range::typical(1.0)));
    let mut table = Table::new(si::UNITS, &[Drive::TYPE, Axial::TYPE], variables);
    table.initial = &AT_REST;
    table
}
