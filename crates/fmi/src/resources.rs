//! The resource location: where the importer has unpacked the archive's `resources` directory; and
//! the content of its files. FMI 2.0 passes a `file:` URI and FMI 3.0 a path. Importers pass either
//! in both, encoded or not, or nothing. So there are several folders to look in; the last one is
//! beside the library.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use percent_encoding::percent_decode_str;

/// The content of a regular file of at most `largest` bytes, without a byte-order mark; `None` if
/// there is no file, or none that can be looked for: too long a name, a loop of links, a folder
/// without permission.
///
/// # Errors
/// It is not a regular file, too large, or can't be read: a sentence without the path.
pub fn content(path: &Path, largest: u64) -> Result<Option<Vec<u8>>, String> {
    let Ok(data) = path.metadata() else {
        return Ok(None);
    };
    // To open a pipe would wait for its other end, and a device may have no end.
    if !data.is_file() {
        return Err("this is not a file".to_owned());
    }
    let (mut bytes, file) = (Vec::new(), File::open(path).map_err(|error| error.to_string())?);
    let read = file.take(largest + 1).read_to_end(&mut bytes);
    read.map_err(|error| error.to_string())?;
    if bytes.len() as u64 > largest {
        return Err(format!("it has more than {largest} bytes"));
    }
    if bytes.starts_with(BYTE_ORDER_MARK) {
        bytes.drain(..BYTE_ORDER_MARK.len());
    }
    Ok(Some(bytes))
}

/// U+FEFF in UTF-8, with which some editors begin a text.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// The folders that a resource location may mean, the most likely one first; none for an empty
/// location.
///
/// # Errors
/// It is neither an absolute path nor the URI of a local file.
pub(crate) fn folders(location: &str) -> Result<Vec<PathBuf>, String> {
    Ok(read(location, cfg!(windows))?.into_iter().map(PathBuf::from).collect())
}

/// The resources of the archive that a library was unpacked with: it is in the platform's folder in
/// `binaries`.
pub(crate) fn resources_of(library: &Path) -> Option<PathBuf> {
    let binaries = library.parent()?.parent()?;
    let unpacked = binaries.file_name()?.eq_ignore_ascii_case("binaries");
    unpacked.then(|| binaries.with_file_name("resources"))
}

fn read(location: &str, windows: bool) -> Result<Vec<String>, String> {
    if location.is_empty() {
        return Ok(Vec::new());
    }
    if location.starts_with('/') || location.starts_with(r"\\") || has_drive(location) {
        return Ok(as_is_or_decoded(location).into());
    }
    let (scheme, rest) = location
        .split_once(':')
        .ok_or_else(|| format!("the resource location {location:?} is neither an absolute path nor a URI"))?;
    if !scheme.eq_ignore_ascii_case("file") {
        return Err(format!(
            "the resource location {location:?} is not a file: URI; only local files can be read"
        ));
    }
    let path = path_of(rest, windows).map_err(|why| format!("the resource location {location:?} {why}"))?;
    // `/C:/a` is `C:/a`.
    let path = path.strip_prefix('/').filter(|path| has_drive(path)).unwrap_or(&path);
    let [as_is, decoded] = as_is_or_decoded(path);
    Ok(vec![decoded, as_is])
}

/// The path of a `file:` URI, which follows the colon. The authority may be missing (`/a`), empty
/// (`///a`), `localhost`, a drive letter by mistake (`//C:/a`), or on Windows another host
/// (`//server/a`).
fn path_of(rest: &str, windows: bool) -> Result<String, String> {
    let Some(rest) = rest.strip_prefix("//") else {
        return match rest.starts_with(['/', '\\']) || has_drive(rest) {
            true => Ok(rest.into()),
            false => Err("has no absolute path".into()),
        };
    };
    if has_drive(rest) {
        return Ok(rest.into());
    }
    let (authority, path) = rest.split_at(rest.find(['/', '\\']).unwrap_or(rest.len()));
    if path.is_empty() {
        Err("has no absolute path".into())
    } else if authority.is_empty() || authority.eq_ignore_ascii_case("localhost") {
        Ok(path.into())
    } else if windows {
        Ok(format!("//{authority}{path}"))
    } else {
        Err(format!("names the host {authority:?}; only local files can be read"))
    }
}

/// Whether a text begins with a drive letter, a colon and a slash of either kind.
fn has_drive(text: &str) -> bool {
    matches!(text.as_bytes(), [letter, b':', b'/' | b'\\', ..] if letter.is_ascii_alphabetic())
}

/// A path as it is, and with its percent-encoding decoded. What cannot be decoded stays as it is.
fn as_is_or_decoded(path: &str) -> [String; 2] {
    let decoded = percent_decode_str(path).decode_utf8().unwrap_or(path.into());
    [path, if decoded.contains('\0') { path } else { &decoded }].map(str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::{read, resources_of};
    use std::path::Path;

    #[test]
    fn locations_are_read_as_importers_write_them() {
        let (unix, windows) = (false, true);
        for (location, system, expected) in [
            ("", unix, &[][..]),
            // With and without an authority.
            ("file:/tmp/a", unix, &["/tmp/a"]),
            ("file:///tmp/a", unix, &["/tmp/a"]),
            ("FILE://localhost/tmp/a", unix, &["/tmp/a"]),
            // A drive letter may stand where the authority should.
            ("file:///C:/a b", windows, &["C:/a b"]),
            ("file://C:/a b", windows, &["C:/a b"]),
            ("file:C:/a b", windows, &["C:/a b"]),
            ("file:/C:/a b", windows, &["C:/a b"]),
            ("C:/a b", windows, &["C:/a b"]),
            (r"file:///C:\a\b", windows, &[r"C:\a\b"]),
            (r"C:\a\b", windows, &[r"C:\a\b"]),
            // A host is a share on Windows.
            ("file://host/a%20b", windows, &["//host/a b", "//host/a%20b"]),
            ("file:////server/share/a", windows, &["//server/share/a"]),
            (r"\\server\share\a", windows, &[r"\\server\share\a"]),
            // A percent sign may be encoded or not.
            ("file:///a%20b/%C3%A9", unix, &["/a b/é", "/a%20b/%C3%A9"]),
            ("/a%20b", unix, &["/a%20b", "/a b"]),
            ("/100%/a", unix, &["/100%/a"]),
            ("/a%4", unix, &["/a%4"]),
            ("/a%FF", unix, &["/a%FF"]),
            ("file:///a%00", unix, &["/a%00"]),
        ] {
            let mut found = read(location, system).unwrap_or_else(|why| panic!("{why}"));
            found.dedup();
            assert_eq!(found, expected, "{location}");
        }
    }

    #[test]
    fn locations_that_are_not_local_files_are_refused() {
        let relative = ["a/b", "%", "file:relative", "c:relative"];
        for location in [&relative[..], &["https://x/y", "file://", "file:", "file://server/a"]].concat() {
            let error = read(location, false).expect_err(location);
            assert!(error.contains(&format!("{location:?}")), "{error}");
        }
    }

    #[test]
    fn resources_are_beside_the_binaries() {
        let found = resources_of(Path::new("/x/binaries/linux64/a.so"));
        assert_eq!(found.as_deref(), Some(Path::new("/x/resources")));
        assert_eq!(resources_of(Path::new("/x/lib/linux64/a.so")), None);
        assert_eq!(resources_of(Path::new("linux64/a.so")), None);
    }
}
