//! Calls on a variator by the names of its variables.

use pushbelt::fmi::Unit;
use pushbelt::fmi::Version::{self, Three, Two};
use pushbelt::fmi::log::Status::{self, Ok};
use pushbelt::fmi::table::Kind;
use pushbelt::unit::VariatorUnit;
pub use pushbelt_support::shared_library::real_outputs;

use crate::importer::{Handles, TIME};

pub type Importer = crate::importer::Importer<VariatorUnit>;

/// Value reference of a variable, of an array or of the time.
pub fn reference(name: &str) -> u32 {
    let table = VariatorUnit::table();
    match table.arrays.iter().find(|array| array.name == name) {
        Some(array) => array.first,
        None if name == "time" => TIME,
        None => pushbelt_support::shared_library::reference(name),
    }
}

impl Importer {
    /// A coarse reference ring that starts unloaded.
    pub fn coarse(version: Version, handles: Handles<'_>) -> Self {
        let importer = Self::handling(version, handles);
        importer.make_coarse();
        importer
    }

    /// The same in step mode.
    pub fn running(version: Version) -> Self {
        let importer = Self::coarse(version, Handles::default());
        importer.start();
        importer
    }

    pub fn make_coarse(&self) {
        self.choose("ring.model", 1);
        for name in ["mesh.primaryArc", "mesh.secondaryArc", "mesh.strand"] {
            self.choose(name, 4);
        }
        self.flag("initial.steady", false);
    }

    pub fn put(&self, name: &str, value: f64) {
        assert_eq!(self.set(reference(name), value), Ok, "{name}: {}", self.last());
    }

    pub fn choose(&self, name: &str, value: i32) {
        assert_eq!(self.set_number(reference(name), value), Ok, "{name}: {}", self.last());
    }

    pub fn flag(&self, name: &str, value: bool) {
        assert_eq!(self.set_number(reference(name), value.into()), Ok, "{name}");
    }

    pub fn get(&self, name: &str) -> f64 {
        self.real(reference(name))
    }

    pub fn count(&self, name: &str) -> i64 {
        self.number(reference(name)).expect("a number")
    }

    pub fn is(&self, name: &str) -> bool {
        self.count(name) == 1
    }

    pub fn advance(&self, from: f64, size: f64) {
        assert_eq!(self.step(from, size).status, Ok, "{}", self.last());
    }

    /// The bits of all real outputs and locals, fields along the belt included; the same in both
    /// versions.
    pub fn readings(&self) -> Vec<u64> {
        let table = VariatorUnit::table();
        let calculated = table.variables().iter().filter(|v| !v.causality.is_setting());
        let mut references: Vec<u32> = calculated
            .filter(|v| matches!(v.kind, Kind::Real { .. }))
            .map(|v| v.reference)
            .collect();
        let count = references.len();
        if self.version == Three {
            references.retain(|r| table.array_of(*r).is_none_or(|array| array.first == *r));
        }
        bits(self.reals(&references, count), self)
    }

    /// The bits of the time derivatives of all real outputs.
    pub fn slopes(&self) -> Vec<u64> {
        bits(self.derivatives(&real_outputs(), 1), self)
    }

    /// Ten steps of 1 ms from a millisecond on with a load that grows; readings and derivatives
    /// after each.
    pub fn run(&self, from: u32) -> Vec<Vec<u64>> {
        let step = |k: u32| {
            self.put("secondary.torque", -f64::from(k));
            self.advance(f64::from(k) * 1e-3, 1e-3);
            [self.readings(), self.slopes()].concat()
        };
        (from..from + 10).map(step).collect()
    }
}

fn bits(values: Result<Vec<f64>, Status>, importer: &Importer) -> Vec<u64> {
    let values = values.unwrap_or_else(|status| panic!("{status:?}: {}", importer.last()));
    values.into_iter().map(f64::to_bits).collect()
}

/// Sets the derivative of an input in the next step, in FMI 2.0.
pub fn ramp(importer: &Importer, name: &str, rate: f64) {
    assert_eq!(importer.version, Two);
    let status = importer.set_derivative(reference(name), 1, rate);
    assert_eq!(status, Ok, "{}", importer.last());
}
