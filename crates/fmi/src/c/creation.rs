//! Creation of an instance, for both versions.

use std::path::Path;

use super::dispatch;
use crate::log::{Category, Log, Sink, Status};
use crate::slave::{Master, Slave, Version};
use crate::start_values;
use crate::unit::Unit;

/// The arguments of an `instantiate` function that both versions have.
pub(crate) struct Arguments<'a> {
    /// Name of the function, for messages.
    pub function: &'static str,
    /// Name of the instance.
    pub name: Option<&'a str>,
    /// The standard's name for the token, and its value.
    pub token: (&'static str, Option<&'a str>),
    /// Token of this binary.
    pub expected: String,
    /// The folder of the resources, if it can be used; if not, why.
    pub resources: Result<Option<&'a Path>, String>,
    /// Whether debug logging is on.
    pub debug: bool,
}

/// An instance for these arguments; `None` after a message if there is none. `master` returns what the master handles, or why
/// there is no instance.
pub(crate) fn create<U: Unit>(
    arguments: Arguments<'_>,
    master: impl FnOnce() -> Result<Master, String>,
    sink: Option<Box<dyn Sink>>,
) -> Option<Slave<U>> {
    let report = |status, category, text: &str| {
        if let Some(sink) = &sink {
            sink.send(status, category, &format!("{}: {text}", arguments.function));
        }
    };
    let checked = check(&arguments).and_then(|()| master()).and_then(|master| {
        // Without start values in its resources an FMU works too: a location that can't be used is a warning, not an error.
        let folder = arguments.resources.as_ref().unwrap_or_else(|warning| {
            report(Status::Warning, Category::Warning, warning);
            &None
        });
        let start = folder.map_or(Ok(None), start_values::read::<U>)?;
        Ok((master, start.unwrap_or_default()))
    });
    let (master, start) = match checked {
        Ok(checked) => checked,
        Err(why) => {
            report(Status::Error, Category::Error, &why);
            return None;
        }
    };
    let log = match master.version {
        Version::Two => Log::new(sink, arguments.debug),
        Version::Three => Log::silent_without_debug(sink, arguments.debug),
    };
    if let Some(remark) = dispatch::remark() {
        log.send(Status::Ok, Category::Events, &remark);
    }
    Some(Slave::with(master, log, start))
}

fn check(arguments: &Arguments<'_>) -> Result<(), String> {
    if arguments.name.is_none_or(str::is_empty) {
        return Err("the instance name is missing".to_owned());
    }
    let (what, token) = arguments.token;
    let token = token.ok_or_else(|| format!("the {what} is missing"))?;
    let expected = &arguments.expected;
    if token == expected {
        return Ok(());
    }
    Err(format!(
        "the {what} {token} is not that of this binary, {expected}: the model description belongs to another binary"
    ))
}
