//! The resource location: where the importer has unpacked the archive's `resources` directory.

use std::path::PathBuf;

/// The path of a `file:` URI, percent-decoded. The authority may be missing (`file:/a`), empty (`file:///a`) or
/// `localhost`; a drive letter loses the slash before it (`file:///C:/a` is `C:/a`).
///
/// # Errors
/// The reason, as a sentence.
pub fn path(uri: &str) -> Result<PathBuf, String> {
    let scheme_end = uri
        .find(':')
        .ok_or_else(|| format!("the resource location {uri:?} is not a URI"))?;
    let (scheme, rest) = (&uri[..scheme_end], &uri[scheme_end + 1..]);
    if !scheme.eq_ignore_ascii_case("file") {
        return Err(format!(
            "the resource location {uri:?} is not a file: URI; only local files can be read"
        ));
    }
    let encoded = match rest.strip_prefix("//") {
        None => rest,
        Some(rest) => {
            let start = rest.find('/').unwrap_or(rest.len());
            let (authority, path) = rest.split_at(start);
            if !authority.is_empty() && !authority.eq_ignore_ascii_case("localhost") {
                return Err(format!(
                    "the resource location {uri:?} names the host {authority:?}; only local files can be read"
                ));
            }
            path
        }
    };
    if !encoded.starts_with('/') {
        return Err(format!("the resource location {uri:?} has no absolute path"));
    }
    let decoded = percent_decode(encoded)
        .ok_or_else(|| format!("the resource location {uri:?} is not percent-encoded UTF-8 text"))?;
    let bytes = decoded.as_bytes();
    let has_drive = bytes.len() >= 3 && bytes[1].is_ascii_alphabetic() && bytes[2] == b':';
    Ok(PathBuf::from(if has_drive { &decoded[1..] } else { &decoded[..] }))
}

fn percent_decode(text: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.bytes();
    while let Some(byte) = rest.next() {
        if byte == b'%' {
            let mut digit = || char::from(rest.next()?).to_digit(16);
            let (high, low) = (digit()?, digit()?);
            bytes.push(u8::try_from(16 * high + low).ok()?);
        } else {
            bytes.push(byte);
        }
    }
    String::from_utf8(bytes).ok().filter(|s| !s.contains('\0'))
}

#[cfg(test)]
mod tests {
    use super::path;
    use std::path::Path;

    #[test]
    fn a_path_may_come_with_or_without_an_authority() {
        for uri in ["file:/tmp/a", "file:///tmp/a", "file://localhost/tmp/a", "FILE:/tmp/a"] {
            assert_eq!(path(uri).as_deref(), Ok(Path::new("/tmp/a")), "{uri}");
        }
    }

    #[test]
    fn percent_codes_are_decoded() {
        assert_eq!(path("file:///a%20b/%C3%A9").as_deref(), Ok(Path::new("/a b/é")));
        assert_eq!(
            path("file:///C:/Program%20Files").as_deref(),
            Ok(Path::new("C:/Program Files"))
        );
    }

    #[test]
    fn locations_that_are_not_local_files_are_refused() {
        for uri in [
            "",
            "/tmp/a",
            "https://x/y",
            "file://host/x",
            "file:relative",
            "file:///%zz",
            "file:///%4",
            "file:///%FF",
            "file:///%00",
        ] {
            let error = path(uri).expect_err(uri);
            assert!(error.contains(&format!("{uri:?}")), "{error}");
        }
    }
}
