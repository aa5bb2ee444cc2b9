//! Where values of real variables lie in the one array that a function passes: scalars, arrays of several values, and the time.

use super::description::TIME;
use crate::log::Status;
use crate::table::Table;

/// How references lie in an array of values.
#[derive(Debug, PartialEq, Eq)]
pub enum Layout {
    /// One value for each reference.
    Plain,
    /// The reference of each value: of a scalar, of an element of an array, or [`TIME`].
    Mixed(Vec<u32>),
}

impl Layout {
    /// The layout of these references in an array of `count` values.
    ///
    /// # Errors
    /// A sentence that says what doesn't fit.
    pub fn of<S, R>(table: &Table<S, R>, references: &[u32], count: usize) -> Result<Self, String> {
        let special = |reference: &u32| *reference == TIME || table.array_of(*reference).is_some();
        let layout = if references.iter().any(special) {
            let mut elements = Vec::with_capacity(count);
            for &reference in references {
                match table.array_of(reference) {
                    None => elements.push(reference),
                    Some(array) if array.first == reference => elements.extend(array.elements()),
                    Some(array) => {
                        return Err(format!(
                            "the value reference {reference} is that of an element of {}: ask for the array, value reference {}",
                            array.name, array.first
                        ));
                    }
                }
            }
            Self::Mixed(elements)
        } else {
            Self::Plain
        };
        let wanted = layout.elements(references).len();
        if wanted == count {
            Ok(layout)
        } else {
            Err(format!(
                "{count} values for {} variables, which have {wanted} together",
                references.len()
            ))
        }
    }

    /// The reference of each value.
    pub fn elements<'a>(&'a self, references: &'a [u32]) -> &'a [u32] {
        match self {
            Self::Plain => references,
            Self::Mixed(elements) => elements,
        }
    }

    /// Whether the time is among them.
    pub fn has_time(&self) -> bool {
        matches!(self, Self::Mixed(elements) if elements.contains(&TIME))
    }

    /// Reads all but the time.
    pub fn read(
        &self,
        references: &[u32],
        values: &mut [f64],
        mut get: impl FnMut(&[u32], &mut [f64]) -> Status,
    ) -> Status {
        if !self.has_time() {
            return get(self.elements(references), values);
        }
        let elements = self.elements(references).iter();
        let known: Vec<u32> = elements.copied().filter(|reference| *reference != TIME).collect();
        let mut found = vec![0.0; known.len()];
        let status = get(&known, &mut found);
        if status == Status::Ok {
            let mut found = found.into_iter();
            for (value, reference) in values.iter_mut().zip(self.elements(references)) {
                if *reference != TIME
                    && let Some(next) = found.next()
                {
                    *value = next;
                }
            }
        }
        status
    }

    /// Writes the time where it is asked for, s.
    pub fn write_time(&self, values: &mut [f64], time: f64) {
        if let Self::Mixed(elements) = self {
            let places = values.iter_mut().zip(elements);
            for (value, _) in places.filter(|(_, reference)| **reference == TIME) {
                *value = time;
            }
        }
    }
}
