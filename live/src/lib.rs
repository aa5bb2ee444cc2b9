//! The unit of the FMU for a page in a browser. The page calls functions over numbers, and reads
//! values and texts in the memory of this module. There is one thread and one variator.
//!
//! Variables are named by their index in the model description of FMI 2.0. A call that can fail
//! returns 1, or 0 with the reason as the text. After a start or a step the text has the messages
//! of the model, one in a line. A panic ends the module; its message is the text.
#![allow(unsafe_code, reason = "the page calls the functions by their names")]

use std::cell::RefCell;

use pushbelt::fmi::table::{Kind, Table, Value};
use pushbelt::fmi::unit::{Experiment, Message};
use pushbelt::fmi::{Unit, Version};
use pushbelt::unit::{VariatorUnit, model_description};

type Settings = <VariatorUnit as Unit>::Settings;

/// A variator with its settings, and what the page reads of it.
struct Live {
    table: Table<Settings, <VariatorUnit as Unit>::Readings>,
    settings: Settings,
    unit: Option<VariatorUnit>,
    /// Values of the variables: truth values are 0 or 1, unknown ones NaN.
    values: Vec<f64>,
    /// Number of variables before the elements of arrays, which are the last.
    scalars: usize,
}

impl Live {
    fn new() -> Self {
        let table = VariatorUnit::table();
        let elements: u32 = table.arrays.iter().map(|array| array.size).sum();
        let count = table.variables().len();
        Self {
            scalars: count - elements as usize,
            values: vec![f64::NAN; count],
            settings: Settings::default(),
            unit: None,
            table,
        }
    }

    fn set(&mut self, index: usize, value: f64) -> Result<(), String> {
        let variable = self.table.variables().get(index).ok_or("there is no such variable")?;
        let value = match variable.kind {
            Kind::Real { .. } => Value::Real(value),
            Kind::Boolean { .. } => Value::Boolean(value != 0.0),
            Kind::Integer { .. } | Kind::Enumeration { .. } => Value::Integer(value as i64),
        };
        variable.set(&mut self.settings, value)
    }

    fn start(&mut self, messages: &mut Vec<Message>) -> Result<(), String> {
        self.unit = None;
        let unit = VariatorUnit::start(&self.settings, &Experiment::default(), messages)?;
        self.unit = Some(unit);
        Ok(())
    }

    /// A communication step to a time, s.
    fn advance(&mut self, to: f64, messages: &mut Vec<Message>) -> Result<(), String> {
        let unit = self.unit.as_mut().ok_or("the variator has not started")?;
        let mut step = unit.begin(to, &self.settings, None)?;
        while !unit.is_over(to, &step) {
            unit.advance(to, &mut step, &self.settings, messages)?;
        }
        unit.finish(&step, messages);
        Ok(())
    }

    /// The values of now; those of elements of arrays only if `elements` is true.
    fn read(&mut self, elements: bool) -> *const f64 {
        let readings = self.unit.as_mut().map(|unit| unit.readings(elements));
        let count = if elements { self.values.len() } else { self.scalars };
        for (variable, value) in self.table.variables()[..count].iter().zip(&mut self.values) {
            *value = match variable.value(&self.settings, readings) {
                Some(Value::Real(value)) => value,
                Some(Value::Integer(value)) => value as f64,
                Some(Value::Boolean(value)) => f64::from(u8::from(value)),
                None => f64::NAN,
            };
        }
        self.values.as_ptr()
    }
}

thread_local! {
    static LIVE: RefCell<Live> = RefCell::new(Live::new());
    static TEXT: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Makes a call; its messages, or the reason why it failed, become the text.
fn call(action: impl FnOnce(&mut Live, &mut Vec<Message>) -> Result<(), String>) -> u32 {
    let mut messages = Vec::new();
    let failure = LIVE.with_borrow_mut(|live| action(live, &mut messages)).err();
    let is_done = failure.is_none();
    let texts = messages.into_iter().map(|message| message.text).chain(failure);
    TEXT.set(texts.collect::<Vec<_>>().join("\n"));
    u32::from(is_done)
}

/// Makes the model description the text. The first call.
#[unsafe(no_mangle)]
extern "C" fn describe() {
    std::panic::set_hook(Box::new(|panic| TEXT.set(panic.to_string())));
    TEXT.set(model_description(Version::Two));
}

/// Sets a setting.
#[unsafe(no_mangle)]
extern "C" fn set(index: usize, value: f64) -> u32 {
    call(|live, _| live.set(index, value))
}

/// Starts at time 0 with the settings.
#[unsafe(no_mangle)]
extern "C" fn start() -> u32 {
    call(|live, messages| live.start(messages))
}

/// Advances to a time, s.
#[unsafe(no_mangle)]
extern "C" fn advance(to: f64) -> u32 {
    call(|live, messages| live.advance(to, messages))
}

/// The values of now; those of elements of arrays only if `elements` is not 0.
#[unsafe(no_mangle)]
extern "C" fn values(elements: u32) -> *const f64 {
    LIVE.with_borrow_mut(|live| live.read(elements != 0))
}

#[unsafe(no_mangle)]
extern "C" fn text() -> *const u8 {
    TEXT.with_borrow(|text| text.as_ptr())
}

#[unsafe(no_mangle)]
extern "C" fn text_length() -> usize {
    TEXT.with_borrow(|text| text.len())
}
