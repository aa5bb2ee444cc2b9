//! Equations of a page in Markdown: `$…$` in a line, `$$…$$` in a paragraph of its own, with
//! `\tag{number}`.
//!
//! A tag becomes the number beside the equation and its anchor, `#eq-number`, so the check of the links
//! finds a reference to an equation that is not there.

use std::fmt::Write as _;
use std::ops::Range;

use anyhow::{Context, bail, ensure};
use math_core::{LatexToMathML, MathDisplay};
use pulldown_cmark::{Event, Options, Parser, Tag, TagEnd};

/// The Markdown of the book's pages.
pub const SYNTAX: Options = Options::ENABLE_MATH
    .union(Options::ENABLE_TABLES)
    .union(Options::ENABLE_FOOTNOTES)
    .union(Options::ENABLE_STRIKETHROUGH);

/// Converts equations.
#[derive(Default)]
pub struct Typesetter {
    converter: LatexToMathML,
}

impl Typesetter {
    /// The page with MathML in the place of its equations; all else stays as it is.
    ///
    /// # Errors
    /// An equation can't be converted, two have one number, or a dollar sign in the text belongs to none.
    pub fn typeset(&self, markdown: &str) -> anyhow::Result<String> {
        let mut page = String::with_capacity(markdown.len());
        let (mut copied, mut numbers, mut in_program) = (0, Vec::new(), false);
        for (event, Range { start, end }) in Parser::new_ext(markdown, SYNTAX).into_offset_iter() {
            let line = || markdown[..start].matches('\n').count() + 1;
            let (latex, display) = match &event {
                Event::InlineMath(latex) => (latex.trim(), MathDisplay::Inline),
                Event::DisplayMath(latex) => (latex.trim(), MathDisplay::Block),
                Event::Start(Tag::CodeBlock(_)) => {
                    in_program = true;
                    continue;
                }
                Event::End(TagEnd::CodeBlock) => {
                    in_program = false;
                    continue;
                }
                Event::Text(text) => {
                    let escaped = usize::from(markdown[..start].ends_with('\\'));
                    ensure!(
                        in_program || !text.chars().skip(escaped).any(|letter| letter == '$'),
                        "line {}: `{text}`: the dollar sign begins no equation; if it shall not, write \\$",
                        line()
                    );
                    continue;
                }
                _ => continue,
            };
            let equation = self
                .equation(latex, display, &mut numbers)
                .with_context(|| format!("line {}: `{latex}`", line()))?;
            page.push_str(&markdown[copied..start]);
            page.push_str(&equation);
            copied = end;
        }
        page.push_str(&markdown[copied..]);
        Ok(page)
    }

    /// HTML of an equation, whose number `numbers` gets.
    fn equation(
        &self,
        latex: &str,
        display: MathDisplay,
        numbers: &mut Vec<String>,
    ) -> anyhow::Result<String> {
        let (latex, number) = untagged(latex)?;
        let converted = self.converter.convert_with_local_state(&latex, display);
        let mathml = match converted {
            Ok(converted) => escaped(&converted.mathml),
            Err(error) => bail!("{error}"),
        };
        if display == MathDisplay::Inline {
            ensure!(number.is_none(), "an equation in a line has no number");
            return Ok(mathml);
        }
        // A block of HTML ends at the next empty line.
        let mut block = String::from("\n\n<div class=\"equation\"");
        match number {
            Some(number) => {
                ensure!(!numbers.contains(&number), "there is another equation ({number})");
                write!(block, " id=\"eq-{number}\">{mathml}<span>({number})</span>")?;
                numbers.push(number);
            }
            None => write!(block, ">{mathml}")?,
        }
        block.push_str("</div>\n\n");
        Ok(block)
    }
}

/// The equation without its `\tag{…}`, and the text of that.
fn untagged(latex: &str) -> anyhow::Result<(String, Option<String>)> {
    let Some((before, rest)) = latex.split_once(r"\tag{") else {
        return Ok((latex.to_owned(), None));
    };
    let (number, after) = rest.split_once('}').context("the tag has no end")?;
    Ok((format!("{before}{after}"), Some(number.to_owned())))
}

/// MathML whose text has no letters that mean something in Markdown.
fn escaped(mathml: &str) -> String {
    let (mut text, mut in_tag) = (String::with_capacity(mathml.len()), false);
    for letter in mathml.chars() {
        match letter {
            '<' => in_tag = true,
            '>' => in_tag = false,
            _ => {}
        }
        if !in_tag && r"*_`[]|~\$".contains(letter) {
            text.push_str(&format!("&#{};", u32::from(letter)));
        } else {
            text.push(letter);
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn typeset(markdown: &str) -> anyhow::Result<String> {
        Typesetter::default().typeset(markdown)
    }

    #[test]
    fn equations_become_mathml() {
        let page =
            typeset("Let $a_1 * b_1 * |c|$ be.\n\n$$\nx = \\frac{1}{2} \\tag{3.2}\n$$\n\nEnd.").unwrap();
        let (line, rest) = page.split_once('\n').unwrap();
        assert!(
            line.starts_with("Let <math><msub><mi>a</mi><mn>1</mn></msub>"),
            "{line}"
        );
        assert!(line.ends_with("</math> be.") && !line.contains(['*', '|']), "{line}");
        let block = rest.trim().strip_suffix("\n\nEnd.").unwrap().trim();
        assert!(
            block.starts_with("<div class=\"equation\" id=\"eq-3.2\"><math display=\"block\">"),
            "{block}"
        );
        assert!(block.ends_with("</math><span>(3.2)</span></div>"), "{block}");
        assert!(block.contains("<mfrac>") && !block.contains('\n'), "{block}");
    }

    /// In programs and in sums of money.
    #[test]
    fn other_dollar_signs_stay() {
        let page = "`$x$` costs \\$5 or 6\\$.\n\n```\ncost=\"$(grep $x$)\"\n```\n\n    $$y$$\n";
        assert_eq!(typeset(page).unwrap(), page);
    }

    #[test]
    fn what_is_no_equation_is_an_error_with_its_place() {
        for (page, place) in [
            ("a\n\n$\\frac{1}$", r"line 3: `\frac{1}`: "),
            ("a\nb $\\frac{1}{$", "line 2: `$`: the dollar sign"),
            ("$x \\tag{1}$", "in a line"),
            (
                "$$x \\tag{1}$$\n\n$$y \\tag{1}$$",
                "line 3: `y \\tag{1}`: there is another equation (1)",
            ),
        ] {
            let error = format!("{:#}", typeset(page).unwrap_err());
            assert!(error.contains(place), "{error}");
        }
    }
}
