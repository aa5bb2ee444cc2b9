//! Links and anchors of a page in HTML or Markdown.

use std::collections::HashSet;

use html5gum::emitters::default::DefaultEmitter;
use html5gum::{Token, Tokenizer};
use pulldown_cmark::{Event, Options, Parser, Tag, TagEnd};

/// One page.
#[derive(Debug, Default)]
pub struct Page {
    /// Anchors.
    pub anchors: HashSet<String>,
    /// Addresses that a reader can follow.
    pub links: Vec<String>,
    /// Addresses whose content the page loads: pictures, style sheets, scripts.
    pub loads: Vec<String>,
    /// Base of relative addresses, if it is not the page.
    pub base: Option<String>,
}

impl Page {
    /// Reads a page in HTML.
    pub fn from_html(text: &str) -> Self {
        let mut page = Self::default();
        page.read_html(text);
        page
    }

    /// Reads a page in Markdown; anchors are those that GitHub gives its headings.
    pub fn from_markdown(text: &str) -> Self {
        let mut page = Self::default();
        let mut heading: Option<String> = None;
        for event in Parser::new_ext(text, Options::ENABLE_TABLES | Options::ENABLE_FOOTNOTES) {
            match event {
                Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) => {
                    page.links.push(dest_url.into_string());
                }
                Event::Html(html) | Event::InlineHtml(html) => page.read_html(&html),
                Event::Start(Tag::Heading { .. }) => heading = Some(String::new()),
                Event::Text(text) | Event::Code(text) => {
                    if let Some(heading) = &mut heading {
                        heading.push_str(&text);
                    }
                }
                Event::End(TagEnd::Heading(_)) => {
                    let anchor = slug(&heading.take().unwrap_or_default());
                    page.add_heading(anchor);
                }
                _ => {}
            }
        }
        page
    }

    fn read_html(&mut self, text: &str) {
        let mut emitter = DefaultEmitter::default();
        // Otherwise text inside scripts that resembles tags would count.
        emitter.naively_switch_states(true);
        for token in Tokenizer::new_with_emitter(text, emitter) {
            let Ok(Token::StartTag(tag)) = token else { continue };
            let name = text_of(&tag.name);
            for (attribute, value) in &tag.attributes {
                let value = text_of(&value.value);
                match (name.as_str(), text_of(attribute).as_str()) {
                    (_, "id") | ("a", "name") => {
                        self.anchors.insert(value);
                    }
                    ("base", "href") => self.base = Some(value),
                    ("link", "href") | ("object", "data") | (_, "src") => self.loads.push(value),
                    (_, "href") => self.links.push(value),
                    _ => {}
                }
            }
        }
    }

    /// Headings of the same text get a number.
    fn add_heading(&mut self, anchor: String) {
        let numbered = (1..).map(|number| format!("{anchor}-{number}"));
        let free = std::iter::once(anchor.clone())
            .chain(numbered)
            .find(|anchor| !self.anchors.contains(anchor));
        self.anchors.extend(free);
    }
}

fn text_of(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// A heading as an anchor: small letters, digits, `-` and `_`; blanks become `-`.
fn slug(heading: &str) -> String {
    heading
        .to_lowercase()
        .chars()
        .filter_map(|letter| match letter {
            ' ' => Some('-'),
            '-' | '_' => Some(letter),
            _ => letter.is_alphanumeric().then_some(letter),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn html_is_read_with_anchors_links_and_what_it_loads() {
        let page = Page::from_html(
            r##"<base href="/"><link rel="stylesheet" href="book.css"><h2 id="how">How</h2><a name="old"></a>
            <a href="page.html#how">x</a><img src="a.png"><script>var x = '<a href="no">';</script>"##,
        );
        assert_eq!(page.anchors, HashSet::from(["how".to_owned(), "old".to_owned()]));
        assert_eq!(page.links, ["page.html#how"]);
        assert_eq!(page.loads, ["book.css", "a.png"]);
        assert_eq!(page.base.as_deref(), Some("/"));
    }

    #[test]
    fn markdown_headings_become_anchors() {
        let page = Page::from_markdown(
            "# What a `change` touches\n## Start\n## Start\n<a id=\"x\"></a>[t](docs/a.md#b)",
        );
        for anchor in ["what-a-change-touches", "start", "start-1", "x"] {
            assert!(page.anchors.contains(anchor), "{anchor}: {page:?}");
        }
        assert_eq!(page.links, ["docs/a.md#b"]);
    }
}
