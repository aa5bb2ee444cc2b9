//! The zip archive of an FMU.
//!
//! Two builds of the same content give the same bytes: entries are sorted and have one fixed time
//! and fixed permissions. For importers that read the archive as a stream there are deflate,
//! forward slashes and no data descriptors.

use std::collections::BTreeMap;
use std::io::{Seek, Write};

use anyhow::{Context, ensure};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

/// The files of an archive before it is written, by their path in it.
#[derive(Debug, Default)]
pub struct Archive {
    entries: BTreeMap<String, Vec<u8>>,
}

impl Archive {
    /// Adds a file under a path with forward slashes.
    ///
    /// # Errors
    /// The path is absolute, leaves the archive, has backslashes or is already taken.
    pub fn add(&mut self, path: impl Into<String>, content: Vec<u8>) -> anyhow::Result<()> {
        let path = path.into();
        let sound = !path.contains('\\')
            && path
                .split('/')
                .all(|part| !part.is_empty() && part != "." && part != "..");
        ensure!(sound, "`{path}` is no path inside an archive");
        let earlier = self.entries.insert(path.clone(), content);
        ensure!(earlier.is_none(), "`{path}` is in the archive twice");
        Ok(())
    }

    /// Writes the archive.
    ///
    /// # Errors
    /// The output can't be written.
    pub fn write<W: Write + Seek>(&self, output: W) -> anyhow::Result<W> {
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Deflated)
            .compression_level(Some(9))
            .last_modified_time(DateTime::default());
        let mut zip = ZipWriter::new(output);
        for (path, content) in &self.entries {
            let executable = path.starts_with("binaries/");
            let permissions = if executable { 0o755 } else { 0o644 };
            zip.start_file(path.as_str(), options.unix_permissions(permissions))
                .with_context(|| format!("can't add `{path}`"))?;
            zip.write_all(content)
                .with_context(|| format!("can't write `{path}`"))?;
        }
        zip.finish().context("can't finish the archive")
    }
}

#[cfg(test)]
mod tests {
    use std::io::{Cursor, Read};

    use super::*;

    fn bytes(files: &[(&str, &str)]) -> Vec<u8> {
        let mut archive = Archive::default();
        for (path, content) in files {
            archive.add(*path, content.as_bytes().to_vec()).unwrap();
        }
        let cursor = archive.write(Cursor::new(Vec::new())).unwrap();
        cursor.into_inner()
    }

    #[test]
    fn order_of_adding_changes_no_byte() {
        let one = bytes(&[("a/b.txt", "one"), ("modelDescription.xml", "two")]);
        let other = bytes(&[("modelDescription.xml", "two"), ("a/b.txt", "one")]);
        assert_eq!(one, other);
    }

    #[test]
    fn content_comes_back_without_data_descriptors() {
        let bytes = bytes(&[("resources/data.json", &"{}".repeat(1000))]);
        let flags = u16::from_le_bytes([bytes[6], bytes[7]]);
        assert_eq!(flags & (1 << 3), 0, "bit 3 announces a data descriptor");
        let mut zip = zip::ZipArchive::new(Cursor::new(bytes)).unwrap();
        let mut file = zip.by_name("resources/data.json").unwrap();
        assert_eq!(file.compression(), CompressionMethod::Deflated);
        let mut text = String::new();
        file.read_to_string(&mut text).unwrap();
        assert_eq!(text.len(), 2000);
    }

    #[test]
    fn paths_that_leave_the_archive_are_refused() {
        for path in ["/etc/passwd", "../up", "a\\b", "a//b", ""] {
            assert!(Archive::default().add(path, Vec::new()).is_err(), "{path}");
        }
        let mut archive = Archive::default();
        archive.add("twice", Vec::new()).unwrap();
        assert!(archive.add("twice", Vec::new()).is_err());
    }
}
