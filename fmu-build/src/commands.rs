//! The commands: a file for each, and one for those that start a Python program.

use std::thread;

use anyhow::anyhow;

pub mod build;
pub mod describe;
pub mod docs;
pub mod elements;
pub mod live_page;
pub mod program;
pub mod test;
pub mod wheel;

/// Runs both at once and returns what both return.
///
/// # Errors
/// One of them fails. The error of the first is returned if both do.
pub fn side_by_side<A, B: Send>(
    first: impl FnOnce() -> anyhow::Result<A>,
    second: impl FnOnce() -> anyhow::Result<B> + Send,
) -> anyhow::Result<(A, B)> {
    thread::scope(|scope| {
        let second = scope.spawn(second);
        let first = first();
        let second = second.join().map_err(|_| anyhow!("a thread panicked"))?;
        Ok((first?, second?))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_results_or_the_first_error_come_back() {
        assert_eq!(side_by_side(|| Ok(1), || Ok("two")).unwrap(), (1, "two"));
        let fails = |what: &'static str| move || anyhow::Result::<()>::Err(anyhow!(what));
        assert_eq!(side_by_side(fails("a"), fails("b")).unwrap_err().to_string(), "a");
        assert_eq!(side_by_side(|| Ok(()), fails("b")).unwrap_err().to_string(), "b");
    }
}
