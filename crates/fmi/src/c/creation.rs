//! Creation of an instance, for both versions.

use std::path::PathBuf;

use super::{dispatch, library};
use crate::log::{Category, Log, Sink, Status};
use crate::resources;
use crate::slave::{Master, Slave, Version};
use crate::start_values::{self, Token};
use crate::unit::Unit;

/// The arguments of an `instantiate` function that both versions have.
pub(crate) struct Arguments<'a> {
    /// Name of the function, for messages.
    pub function: &'static str,
    /// Name of the instance.
    pub name: Option<&'a str>,
    /// The standard's name for the token, and its value.
    pub token: (&'static str, Option<&'a str>),
    /// Token of this binary with data of a hash.
    pub expected: fn(Option<u128>) -> String,
    /// The resource location, a URI or a path.
    pub resources: Option<&'a str>,
    /// Whether debug logging is on.
    pub debug: bool,
}

/// An instance for these arguments; `None` after a message if there is none. `master` returns what the master handles, with
/// warnings, or why there is no instance.
pub(crate) fn create<U: Unit>(
    arguments: Arguments<'_>,
    master: impl FnOnce(&mut Vec<String>) -> Result<Master, String>,
    sink: Option<Box<dyn Sink>>,
) -> Option<Slave<U>> {
    let report = |status, category, text: &str| {
        if let Some(sink) = &sink {
            sink.send(status, category, &format!("{}: {text}", arguments.function));
        }
    };
    let checked = named(&arguments).and_then(|given| {
        let mut warnings = Vec::new();
        let master = master(&mut warnings)?;
        // A location that means no place is a warning: without start values in its resources an FMU works too.
        let mut places = resources::places(arguments.resources.unwrap_or_default()).unwrap_or_else(|warning| {
            warnings.push(warning);
            Vec::new()
        });
        if master.version == Version::Two || arguments.debug {
            for warning in &warnings {
                report(Status::Warning, Category::Warning, warning);
            }
        }
        places.extend(library::own_folder().ok().and_then(|folder| resources::beside(&folder)));
        let defaults = load::<U>(&places)?;
        let token = check(&arguments, given, &(arguments.expected)(U::data(&defaults)))?;
        let start = start_values::find::<U>(&places, token, &defaults)?;
        Ok((master, start.unwrap_or(defaults)))
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
        Version::Three => Log::errors_without_debug(sink, arguments.debug),
    };
    if let Some((status, category, text)) = dispatch::remark() {
        log.send(status, category, &text);
    }
    Some(Slave::with(master, log, start))
}

fn named<'a>(arguments: &Arguments<'a>) -> Result<&'a str, String> {
    if arguments.name.is_none_or(str::is_empty) {
        return Err("the instance name is missing".to_owned());
    }
    let (what, token) = arguments.token;
    token.ok_or_else(|| format!("the {what} is missing"))
}

/// The settings of a new instance with the data of the first folder that has them.
fn load<U: Unit>(folders: &[PathBuf]) -> Result<U::Settings, String> {
    let mut refused = None;
    for folder in folders {
        match U::load(Some(folder)) {
            Ok(found) => return Ok(found),
            Err(why) => refused = refused.or(Some(why)),
        }
    }
    refused.map_or_else(|| U::load(None), Err)
}

/// Compares the token with that of this binary.
fn check(arguments: &Arguments<'_>, token: &str, expected: &str) -> Result<Token, String> {
    let (what, _) = arguments.token;
    Token::of(token, expected).ok_or_else(|| {
        format!(
            "the {what} {token} is not that of this binary, {expected}: the model description belongs to another binary"
        )
    })
}
