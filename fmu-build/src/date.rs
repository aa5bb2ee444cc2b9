//! The date of the packed files. It is that of the content, not of the build: two builds of one
//! commit give the same bytes.

use std::process::Command;
use std::time::{Duration, UNIX_EPOCH};

use anyhow::Context;

use crate::workspace::Workspace;

/// Date and time in UTC: that of the environment variable `SOURCE_DATE_EPOCH` (seconds since 1970)
/// or of the last commit; none outside a repository.
///
/// # Errors
/// The variable is set, but not to a number of seconds before the year 10000.
pub fn of_content(workspace: &Workspace) -> anyhow::Result<Option<String>> {
    if let Some(given) = std::env::var_os("SOURCE_DATE_EPOCH") {
        let seconds = given.to_string_lossy();
        return written(&seconds).map(Some);
    }
    let output = Command::new("git")
        .args(["log", "-1", "--format=%ct"])
        .current_dir(workspace.root())
        .output();
    match output {
        Ok(output) if output.status.success() => written(&String::from_utf8_lossy(&output.stdout)).map(Some),
        _ => Ok(None),
    }
}

/// Seconds since 1970 as a date.
fn written(seconds: &str) -> anyhow::Result<String> {
    /// The last second of the year 9999.
    const LAST: u64 = 253_402_300_799;
    let refused = || {
        format!(
            "SOURCE_DATE_EPOCH = {:?} is not a number of seconds from 0 to {LAST}",
            seconds.trim()
        )
    };
    let number = seconds.trim().parse::<u64>().ok().filter(|number| *number <= LAST);
    let time = UNIX_EPOCH + Duration::from_secs(number.with_context(refused)?);
    Ok(humantime::format_rfc3339_seconds(time).to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_are_a_date() {
        assert_eq!(written("0").unwrap(), "1970-01-01T00:00:00Z");
        assert_eq!(written("1764000000\n").unwrap(), "2025-11-24T16:00:00Z");
        for wrong in ["", "-1", "today", "253402300800"] {
            let said = written(wrong).unwrap_err().to_string();
            assert!(said.contains(&format!("{wrong:?}")), "{said}");
        }
    }
}
