//! One page of the book as a file of HTML for a reader without the book.

use std::fs;
use std::path::Path;

use anyhow::Context;
use pulldown_cmark::{Event, Parser, Tag, TagEnd, html};

use crate::equations::{SYNTAX, Typesetter};

/// What `book.css` leaves to the book.
const STYLE: &str = "body { max-width: 60em; margin: 1em auto; padding: 0 1em; font: 16px/1.5 sans-serif; color-scheme: light dark }
table { border-collapse: collapse; display: block; overflow-x: auto } td, th { border: 1px solid #8888; padding: 2px 10px }
img { max-width: 100% }";

/// The page of a file in Markdown. Its pictures are those beside it; links into the documentation of the
/// Rust API become text.
///
/// # Errors
/// A file can't be read, or an equation not be converted.
pub fn standalone(typesetter: &Typesetter, file: &Path) -> anyhow::Result<String> {
    let read =
        |path: &Path| fs::read_to_string(path).with_context(|| format!("can't read {}", path.display()));
    let style = read(&file.with_file_name("book.css"))?;
    let text = typesetter
        .typeset(&read(file)?)
        .with_context(|| file.display().to_string())?;
    let title = text.lines().next().unwrap_or_default().trim_start_matches("# ");
    Ok(format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\">\
         <title>pushbelt: {title}</title>\n<style>\n{STYLE}\n{style}</style></head><body class=\"content\">\n{}</body></html>",
        body(&text)
    ))
}

fn body(text: &str) -> String {
    let mut into_api = false;
    let events = Parser::new_ext(text, SYNTAX).filter(|event| match event {
        Event::Start(Tag::Link { dest_url, .. }) => {
            into_api = dest_url.starts_with("api/");
            !into_api
        }
        Event::End(TagEnd::Link) => !std::mem::take(&mut into_api),
        _ => true,
    });
    let mut out = String::new();
    html::push_html(&mut out, events);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_stands_alone() {
        let folder = std::env::temp_dir().join(format!("fmu-build-page-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join("book.css"), "math { color: red }\n").unwrap();
        let page = "# Title\n\n[`a.rs`](api/src/a.rs.html), [b](b.md)\n\n$$x \\tag{1}$$\n";
        fs::write(folder.join("page.md"), page).unwrap();
        let html = standalone(&Typesetter::default(), &folder.join("page.md")).unwrap();
        fs::remove_dir_all(folder).unwrap();
        for part in [
            "<title>pushbelt: Title</title>",
            "math { color: red }",
            "<p><code>a.rs</code>, <a href=\"b.md\">b</a></p>",
            "<div class=\"equation\" id=\"eq-1\"><math",
        ] {
            assert!(html.contains(part), "{part}: {html}");
        }
    }
}
