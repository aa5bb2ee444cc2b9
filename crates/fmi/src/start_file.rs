//! Start values that come with a copy of the FMU: `start-values.txt` in its resources.
//!
//! Importers need not pass on the start values of the model description. So a copy with a user's
//! own values contains them for the library too: one `name = value` per line; truth values are
//! `true` and `false`, items of enumerations are numbers; `#` begins a comment. An unreadable file
//! is an error; a location that can't be searched is skipped. The library refuses to run a copy,
//! whose token has another end than the original's, without its file.

use std::path::PathBuf;

use super::resources::content;
use super::table::{Kind, Table, Value};
use super::unit::Unit;

/// Name of the file in the resources.
pub const FILE: &str = "start-values.txt";

/// Largest size of the file, bytes: a larger file is not a list of start values.
const LARGEST_FILE: u64 = 1 << 20;

/// Characters at the beginning of a token that a copy has from the original:
/// `{01234567-0123-0123-`.
const SHARED: usize = 20;

/// Whether a token is that of a copy with start values of a user; `None` if it is one of another
/// FMU than the original.
pub(crate) fn is_of_copy(token: &str, original: &str) -> Option<bool> {
    let belongs = token.len() == original.len() && original.get(..SHARED) == token.get(..SHARED);
    belongs.then_some(token != original)
}

/// The settings that an instance starts from: those of the file in the first folder that has one,
/// over `defaults`; `None` if there is no file.
///
/// # Errors
/// The file is unusable, or missing in a copy: a sentence with file, line, variable and value.
pub(crate) fn find<U: Unit>(
    folders: &[PathBuf],
    is_copy: bool,
    defaults: &U::Settings,
) -> Result<Option<U::Settings>, String> {
    for folder in folders {
        let path = folder.join(FILE);
        let unusable = |why: String| format!("the start values in {} can't be used: {why}", path.display());
        if let Some(bytes) = content(&path, LARGEST_FILE).map_err(unusable)? {
            let text = String::from_utf8(bytes).map_err(|_| "it is not text in UTF-8".to_owned());
            let settings = text.and_then(|text| parse(&text, &U::table(), defaults));
            return settings.map(Some).map_err(unusable);
        }
    }
    let searched: Vec<_> = folders.iter().map(|folder| folder.display().to_string()).collect();
    match (is_copy, searched.is_empty()) {
        (false, _) => Ok(None),
        (true, false) => Err(format!(
            "this copy of the FMU has start values of its own, but {FILE} is missing in {}",
            searched.join(" and in ")
        )),
        (true, true) => Err(format!(
            "this copy of the FMU has start values of its own in {FILE}, but the importer passed no resource \
             location, and the library is not in the folder into which the FMU was unpacked"
        )),
    }
}

fn parse<S: Clone, R>(text: &str, table: &Table<S, R>, defaults: &S) -> Result<S, String> {
    let mut settings = defaults.clone();
    let mut seen = Vec::new();
    for (line, number) in text.lines().zip(1..) {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let name = set(line, table, &mut settings).map_err(|why| format!("line {number}: {why}"))?;
        if seen.contains(&name) {
            return Err(format!("line {number}: {name} is set twice"));
        }
        seen.push(name);
    }
    Ok(settings)
}

/// Sets the variable of a line; its name.
fn set<'a, S, R>(line: &'a str, table: &Table<S, R>, settings: &mut S) -> Result<&'a str, String> {
    let (name, text) = line
        .split_once('=')
        .map(|(name, text)| (name.trim(), text.trim()))
        .ok_or_else(|| format!("{line:?} is not of the form name = value"))?;
    let variable = table.by_name(name).ok_or_else(|| {
        match table.retired.iter().find(|retired| retired.name == name) {
            Some(retired) => retired.to_string(),
            None => format!("there is no variable {name:?}"),
        }
    })?;
    let not_a = |what: &str| format!("{name} = {text:?} is not a {what}");
    let value = match &variable.kind {
        Kind::Real { .. } => Value::Real(text.parse().map_err(|_| not_a("number"))?),
        Kind::Integer { .. } | Kind::Enumeration { .. } => {
            Value::Integer(text.parse().map_err(|_| not_a("whole number"))?)
        }
        Kind::Boolean { .. } => Value::Boolean(text.parse().map_err(|_| not_a("truth value"))?),
    };
    variable.set(settings, value)?;
    Ok(name)
}
