//! Output: CSV files with a header, text in quotes.

use std::fmt::Write as _;
use std::fs;
use std::io;
use std::path::Path;

/// A cell.
pub enum Cell {
    Text(String),
    Number(f64),
    Empty,
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<f64> for Cell {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl From<usize> for Cell {
    fn from(count: usize) -> Self {
        Self::Number(count as f64)
    }
}

impl From<u64> for Cell {
    fn from(count: u64) -> Self {
        Self::Number(count as f64)
    }
}

impl<T: Into<Self>> From<Option<T>> for Cell {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::Empty, Into::into)
    }
}

/// A table of a CSV file.
pub struct Table {
    file: &'static str,
    text: String,
}

impl Table {
    /// A table with these columns.
    pub fn new(file: &'static str, columns: &str) -> Self {
        Self {
            file,
            text: format!("{columns}\n"),
        }
    }

    /// Adds a row.
    pub fn add(&mut self, cells: impl IntoIterator<Item = Cell>) {
        for (k, cell) in cells.into_iter().enumerate() {
            if k > 0 {
                self.text.push(',');
            }
            match cell {
                Cell::Text(text) => write!(self.text, "\"{}\"", text.replace('"', "\"\"")),
                Cell::Number(number) => write!(self.text, "{number:e}"),
                Cell::Empty => Ok(()),
            }
            .expect("writing to a string");
        }
        self.text.push('\n');
    }

    /// Writes the file.
    ///
    /// # Errors
    /// The folder is not writable.
    pub fn write(&self, folder: &Path) -> io::Result<()> {
        fs::write(folder.join(self.file), &self.text)
    }
}

/// A row for [`Table::add`] from values of any cell type.
#[macro_export]
macro_rules! row {
    ($($value:expr),* $(,)?) => { [$($crate::tables::Cell::from($value)),*] };
}
