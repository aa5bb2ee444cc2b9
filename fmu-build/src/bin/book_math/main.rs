//! Typesets the equations of the book: LaTeX between dollar signs in its Markdown becomes MathML, which
//! browsers show without a script.
//!
//! mdBook runs it as a preprocessor (`docs/book.toml`): it reads the book as JSON and writes it back.
//! `book-math page PAGE.md` writes one page as HTML that needs no book, for the wheel.

mod equations;
mod page;

use std::io::Read as _;
use std::path::Path;
use std::process::ExitCode;

use anyhow::{Context, bail};
use serde_json::Value;

use crate::equations::Typesetter;

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> anyhow::Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let typesetter = Typesetter::default();
    match words.as_slice() {
        [] => {
            let mut input = String::new();
            std::io::stdin()
                .read_to_string(&mut input)
                .context("can't read the book")?;
            println!("{}", typeset_book(&typesetter, &input)?);
        }
        // Every renderer that shows HTML.
        ["supports", _] => {}
        ["page", file] => println!("{}", page::standalone(&typesetter, Path::new(file))?),
        _ => bail!("usage: book-math [page PAGE.md]; without words it is a preprocessor of mdBook"),
    }
    Ok(())
}

/// The book of mdBook's input, a pair of context and book, with typeset equations.
fn typeset_book(typesetter: &Typesetter, input: &str) -> anyhow::Result<Value> {
    let [_, mut book]: [Value; 2] = serde_json::from_str(input).context("the input is not that of mdBook")?;
    typeset_chapters(typesetter, &mut book)?;
    Ok(book)
}

/// Typesets each chapter in a part of the book.
fn typeset_chapters(typesetter: &Typesetter, part: &mut Value) -> anyhow::Result<()> {
    match part {
        Value::Array(items) => items.iter_mut().try_for_each(|item| typeset_chapters(typesetter, item)),
        Value::Object(fields) => {
            if let Some(Value::String(text)) = fields.get("content") {
                let file = fields.get("path").and_then(Value::as_str).unwrap_or("a draft");
                let typeset = typesetter.typeset(text).with_context(|| file.to_owned())?;
                fields.insert("content".to_owned(), typeset.into());
            }
            fields
                .values_mut()
                .try_for_each(|field| typeset_chapters(typesetter, field))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn book(content: &str) -> String {
        let inner = serde_json::json!({"Chapter": {"content": content, "path": "b.md", "sub_items": []}});
        let outer = serde_json::json!({"Chapter": {"content": "", "path": "a.md", "sub_items": [inner]}});
        serde_json::json!([{"root": ""}, {"sections": ["Separator", outer]}]).to_string()
    }

    #[test]
    fn chapters_at_every_depth_are_typeset() {
        let typeset = typeset_book(&Typesetter::default(), &book("$x$")).unwrap();
        let content = &typeset["sections"][1]["Chapter"]["sub_items"][0]["Chapter"]["content"];
        assert!(content.as_str().unwrap().starts_with("<math>"), "{content}");
    }

    #[test]
    fn an_error_names_page_line_and_equation() {
        let error = typeset_book(&Typesetter::default(), &book("a\n\nb $\\nothing$")).unwrap_err();
        let text = format!("{error:#}");
        assert!(text.starts_with(r"b.md: line 3: `\nothing`: "), "{text}");
    }
}
