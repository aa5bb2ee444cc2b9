//! A toy unit: a tank that fills at a rate, level' = gain·inflow, with internal steps and an event.

use std::path::Path;

use Causality::{Input, Local, Output, Parameter, Tunable};
use pushbelt_fmi::prelude::*;
use pushbelt_fmi::table::{Array, Enumeration, Item, Kind, Retired};

pub type Importer = crate::importer::Importer<Tank>;

pub const START: u32 = 1;
pub const GAIN: u32 = 2;
pub const INFLOW: u32 = 3;
pub const BRIM: u32 = 4;
pub const LEVEL: u32 = 5;
pub const MARK: u32 = 6;
pub const FLOORS: u32 = 7;
pub const SHAPE: u32 = 8;
pub const LOCKED: u32 = 19;
pub const FULL: u32 = 20;
/// Value reference of the first of [`DEPTHS`] depths.
pub const DEPTH: u32 = 11;
pub const DEPTHS: usize = 3;
/// Of a variable that an earlier version had.
pub const OLD: u32 = 98;
/// No variable has it.
pub const NONE: u32 = 99;

/// Inflow that makes the tank panic.
pub const BURST: f64 = 666.0;
pub const LONGEST: f64 = 0.25;

#[derive(Clone)]
pub struct Valves {
    pub start: f64,
    pub gain: f64,
    pub inflow: f64,
    /// Level at which a step ends half way.
    pub brim: f64,
    /// Level at which an event happens.
    pub mark: f64,
    pub floors: i32,
    pub shape: i32,
    pub locked: bool,
}

impl Default for Valves {
    fn default() -> Self {
        Self {
            start: 1.0,
            gain: 1.0,
            inflow: 2.0,
            brim: 1e9,
            mark: 1e9,
            floors: 2,
            shape: 1,
            locked: false,
        }
    }
}

#[derive(Clone, Default)]
pub struct Gauges {
    level: f64,
    full: bool,
    depths: [f64; DEPTHS],
}

/// A communication step: the tank where it began, the growth of the inflow, and the mark.
pub struct Step {
    before: Tank,
    growth: f64,
    mark: f64,
}

#[derive(Clone)]
pub struct Tank {
    time: f64,
    level: f64,
    /// Flow into the tank, and how it changes.
    flow: [f64; 2],
    gauges: Gauges,
}

const UNITS: &[UnitDefinition] = &[UnitDefinition::new("1", &[]).shown_in(&[("%", 100.0)])];

static SHAPES: Enumeration = Enumeration {
    name: "Shape",
    description: "Shape of the tank",
    items: &[Item::new("Round", 1, "A cylinder"), Item::new("Square", 2, "A box")],
};

static RETIRED: [Retired; 1] = [Retired {
    name: "old",
    reference: OLD,
    instead: "use start",
}];

impl Unit for Tank {
    type Settings = Valves;
    type Readings = Gauges;
    type Step = Step;

    const INTERPOLATES_INPUTS: bool = true;
    const OUTPUT_DERIVATIVES: bool = true;
    const IDENTITY: Identity = Identity {
        longest_step: 100.0,
        ..Identity::new("Tank", "Fills")
    };

    fn table() -> Table<Valves, Gauges> {
        type Type = Kind<Valves, Gauges>;
        let real = |reference, name: &str, causality, access: Access<Valves, Gauges, f64>| {
            Variable::real(reference, name, "", causality, "1", access).with_range(Range::from(-1e3))
        };
        let other = |reference, name: &str, causality, kind: Type| Variable {
            reference,
            name: name.into(),
            description: String::new(),
            causality,
            kind,
        };
        let truth = |access| Type::Boolean { access };
        let floors = Type::Integer {
            range: Some((1, 9)),
            access: setting!(floors),
        };
        let shape = Type::Enumeration {
            of: &SHAPES,
            access: setting!(shape),
        };
        let mut variables = vec![
            real(START, "start", Parameter, setting!(start)),
            real(GAIN, "gain", Tunable, setting!(gain))
                .with_range(Range::between(-1e3, 10.0).with_nominal(2e6)),
            real(INFLOW, "inflow", Input, setting!(inflow)),
            real(BRIM, "brim", Input, setting!(brim)),
            real(LEVEL, "level", Output, Access::Reading(|gauges| gauges.level)),
            real(MARK, "mark", Input, setting!(mark)),
            other(FLOORS, "floors", Parameter, floors),
            other(SHAPE, "shape", Parameter, shape),
            other(LOCKED, "locked", Parameter, truth(setting!(locked))),
            other(FULL, "full", Output, truth(Access::Reading(|gauges| gauges.full))),
        ];
        variables.extend((0..DEPTHS).zip(DEPTH..).map(|(at, reference)| {
            let access = Access::Element(|gauges: &Gauges, at| gauges.depths[at], at);
            real(reference, &format!("depth[{}]", at + 1), Local, access)
        }));
        let depth = Array {
            name: "depth".into(),
            description: String::new(),
            first: DEPTH,
            size: DEPTHS as u32,
        };
        let mut table = Table::new(UNITS, const { &[&SHAPES] }, variables);
        (table.arrays, table.retired) = (vec![depth], &RETIRED);
        table.initial = &[("full", &["locked", "start"])];
        table
    }

    /// A folder of this name has no data.
    fn load(resources: Option<&Path>) -> Result<Valves, String> {
        match resources.is_some_and(|folder| folder.ends_with("none")) {
            true => Err("there are no data".into()),
            false => Ok(Valves::default()),
        }
    }

    fn check(valves: &Valves) -> Result<(), String> {
        match valves.gain {
            0.5 => Err("gain = 0.5 does not fit".into()),
            _ => Ok(()),
        }
    }

    fn start(valves: &Valves, experiment: &Experiment, messages: &mut Vec<Message>) -> Result<Self, String> {
        Self::check(valves)?;
        messages.push(Message {
            warning: valves.start > 5.0,
            text: match experiment.tolerance {
                Some(tolerance) => format!("filled within {tolerance}"),
                None => format!("filled to 100%s {}", valves.start),
            },
        });
        Ok(Self {
            time: 0.0,
            level: valves.start,
            flow: [0.0; 2],
            gauges: Gauges::default(),
        })
    }

    fn time(&self) -> f64 {
        self.time
    }

    fn readings(&mut self, elements: bool) -> &Gauges {
        self.gauges.level = self.level;
        self.gauges.full = self.level >= 10.0;
        if elements {
            self.gauges.depths = [0.0, 0.5, 1.0].map(|share| share * self.level);
        }
        &self.gauges
    }

    fn begin(&mut self, _: f64, valves: &Valves, rates: Option<&Valves>) -> Result<Step, String> {
        #[cfg(target_arch = "x86_64")]
        crate::environment::assert_default();
        if valves.mark < 0.0 {
            return Err("mark is below 0".into());
        }
        Ok(Step {
            before: self.clone(),
            growth: rates.map_or(0.0, |rates| rates.inflow),
            mark: valves.mark,
        })
    }

    fn advance(
        &mut self,
        to: f64,
        step: &mut Step,
        valves: &Valves,
        _: &mut Vec<Message>,
    ) -> Result<(), String> {
        assert!(valves.inflow != BURST, "the tank burst");
        let to = to.min(self.time + LONGEST);
        let [before, after] =
            [self.time, to].map(|time| valves.inflow + step.growth * (time - step.before.time));
        self.flow = [valves.gain * after, valves.gain * step.growth];
        let rate = valves.gain * 0.5 * (before + after);
        if self.level + rate * (to - self.time) > valves.brim {
            self.clone_from(&step.before);
            return Err("full".into());
        }
        self.level += rate * (to - self.time);
        self.time = to;
        Ok(())
    }

    fn event(&self, step: &Step) -> Option<String> {
        let mark = step.mark;
        (step.before.level < mark && self.level >= mark).then(|| format!("the level reaches {mark}"))
    }

    fn moment(&mut self) -> Option<([Gauges; 2], f64)> {
        let [flow, growth] = self.flow;
        let around = [-0.25, 0.25].map(|after| Gauges {
            level: self.level + after * (flow + 0.5 * after * growth),
            ..Gauges::default()
        });
        Some((around, 0.5))
    }

    fn serialize(&mut self, archive: &mut Archive<'_>) {
        archive.real(&mut self.time);
        archive.real(&mut self.level);
        archive.reals(&mut self.flow);
    }
}
