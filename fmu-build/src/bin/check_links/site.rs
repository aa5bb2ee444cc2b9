//! Links inside a folder of pages: each must lead to an existing file and anchor. No page may load
//! content from elsewhere, so that it can be read offline. Links to other sites are not followed.

use std::collections::HashMap;
use std::ffi::OsStr;
use std::fs;
use std::path::{Component, Path, PathBuf};

use anyhow::Context;
use percent_encoding::percent_decode_str;

use crate::page::Page;

/// The pages below one folder; links may lead to any file in it.
pub struct Site {
    root: PathBuf,
    pages: HashMap<PathBuf, Page>,
}

impl Site {
    /// A site without any page read.
    pub fn new(root: &Path) -> Self {
        Self {
            root: root.to_owned(),
            pages: HashMap::new(),
        }
    }

    /// Errors in the links of every HTML page and style sheet in this folder, except in `except`
    /// below it.
    ///
    /// # Errors
    /// A file can't be read.
    pub fn check_all(&mut self, except: &Path) -> anyhow::Result<Vec<String>> {
        let mut files = Vec::new();
        collect(&self.root, except, &mut files)?;
        files.sort();
        let mut problems = Vec::new();
        for file in files {
            match file.extension().and_then(OsStr::to_str) {
                Some("html") => problems.extend(self.check(&file)?),
                Some("css") => problems.extend(self.check_style(&file)?),
                _ => {}
            }
        }
        Ok(problems)
    }

    /// Errors in the links of one page.
    ///
    /// # Errors
    /// A file can't be read.
    pub fn check(&mut self, file: &Path) -> anyhow::Result<Vec<String>> {
        let shown = self.shown(file);
        let page = self.page(file)?;
        let (links, loads, base) = (page.links.clone(), page.loads.clone(), page.base.clone());
        let folder = match base {
            Some(base) => self.root.join(base.trim_start_matches('/')),
            None => file.parent().unwrap_or(&self.root).to_owned(),
        };
        let mut problems: Vec<String> = loads
            .iter()
            .filter(|address| is_elsewhere(address))
            .map(|address| format!("{shown} loads {address}"))
            .collect();
        for address in links.iter().chain(&loads).filter(|address| !has_scheme(address)) {
            if let Some(problem) = self.problem_of(address, file, &folder)? {
                problems.push(format!("{shown} links to {address}: {problem}"));
            }
        }
        Ok(problems)
    }

    fn problem_of(
        &mut self,
        address: &str,
        file: &Path,
        folder: &Path,
    ) -> anyhow::Result<Option<&'static str>> {
        let (path, anchor) = address.split_once('#').unwrap_or((address, ""));
        let path = path.split('?').next().unwrap_or_default();
        let path = percent_decode_str(path).decode_utf8_lossy();
        let anchor = percent_decode_str(anchor).decode_utf8_lossy();
        let mut target = match path.strip_prefix('/') {
            Some(path) => self.root.join(path),
            None if path.is_empty() => file.to_owned(),
            None => folder.join(&*path),
        };
        if !normal(&target).starts_with(normal(&self.root)) {
            return Ok(Some("outside of the folder"));
        }
        if target.join("index.html").is_file() {
            target.push("index.html");
        }
        if !target.exists() {
            return Ok(Some("no such file"));
        }
        let is_page = ["html", "md"]
            .iter()
            .any(|kind| target.extension() == Some(OsStr::new(kind)));
        if anchor.is_empty() || !is_page || self.page(&normal(&target))?.anchors.contains(&*anchor) {
            return Ok(None);
        }
        Ok(Some("no such anchor"))
    }

    fn page(&mut self, file: &Path) -> anyhow::Result<&Page> {
        if !self.pages.contains_key(file) {
            let text = read(file)?;
            let markdown = file.extension() == Some(OsStr::new("md"));
            let page = if markdown {
                Page::from_markdown(&text)
            } else {
                Page::from_html(&text)
            };
            self.pages.insert(file.to_owned(), page);
        }
        Ok(&self.pages[file])
    }

    fn check_style(&self, file: &Path) -> anyhow::Result<Vec<String>> {
        let text = read(file)?;
        let addresses = text
            .split("url(")
            .skip(1)
            .chain(text.split("@import").skip(1))
            .map(|rest| rest.trim_start_matches(['"', '\'', ' ']))
            .filter(|address| is_elsewhere(address))
            .map(|address| address.split(['"', '\'', ')', ';']).next().unwrap_or_default());
        let shown = self.shown(file);
        Ok(addresses.map(|address| format!("{shown} loads {address}")).collect())
    }

    fn shown(&self, file: &Path) -> String {
        file.strip_prefix(&self.root).unwrap_or(file).display().to_string()
    }
}

fn read(file: &Path) -> anyhow::Result<String> {
    fs::read_to_string(file).with_context(|| format!("can't read {}", file.display()))
}

/// The address names a protocol, such as `https:` or `mailto:`, or another host.
fn has_scheme(address: &str) -> bool {
    let scheme = address.split(['/', '#', '?']).next().unwrap_or_default();
    scheme.contains(':') || address.starts_with("//")
}

fn is_elsewhere(address: &str) -> bool {
    ["http:", "https:", "//"].iter().any(|start| address.starts_with(start))
}

/// The path without `.` and `..`.
fn normal(path: &Path) -> PathBuf {
    let mut normal = PathBuf::new();
    for component in path.components() {
        match component {
            Component::ParentDir => {
                normal.pop();
            }
            Component::CurDir => {}
            other => normal.push(other),
        }
    }
    normal
}

fn collect(folder: &Path, except: &Path, files: &mut Vec<PathBuf>) -> anyhow::Result<()> {
    for entry in fs::read_dir(folder).with_context(|| format!("can't read {}", folder.display()))? {
        let path = entry?.path();
        if path.is_dir() && path != except {
            collect(&path, except, files)?;
        } else if path.is_file() {
            files.push(path);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Errors found in a folder with these files.
    fn problems(name: &str, files: &[(&str, &str)]) -> Vec<String> {
        let root = std::env::temp_dir().join(format!("fmu-build-{name}-{}", std::process::id()));
        for (path, text) in files {
            let path = root.join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        let problems = Site::new(&root).check_all(&root.join("api")).unwrap();
        fs::remove_dir_all(root).unwrap();
        problems
    }

    #[test]
    fn links_that_lead_somewhere_pass() {
        let index = r##"<h1 id="top">x</h1><a href="#top">1</a><a href="part/a%20b.html?x#über">2</a><a href="api/">3</a>
            <a href="https://example.org/none">4</a><a href="mailto:a@b">5</a><img src="part/p.png"><a href="/part/p.png">6</a>
            <img src="data:image/png;base64,x"><a href="#">7</a>"##;
        let files = [
            ("index.html", index),
            ("part/a b.html", r#"<p id="über"><a href="../index.html#top">up</a>"#),
            ("part/p.png", ""),
            ("part/s.css", "a { background: url(\"p.png\") }"),
            ("api/index.html", r#"<a href="none">not looked at</a>"#),
        ];
        assert_eq!(problems("sound", &files), Vec::<String>::new());
    }

    #[test]
    fn what_leads_nowhere_or_loads_from_elsewhere_is_listed() {
        let index = r##"<a href="none.html">1</a><a href="#none">2</a><a href="api/index.html#none">3</a><a href="../up.html">4</a>
            <script src="https://example.org/x.js"></script><img src="//example.org/x.png"><img src="none.png">"##;
        let files = [
            ("index.html", index),
            ("api/index.html", ""),
            (
                "s.css",
                "@import 'https://example.org/a.css'; b { background: url(http://example.org/p.png) }",
            ),
        ];
        let expected = [
            "index.html loads https://example.org/x.js",
            "index.html loads //example.org/x.png",
            "index.html links to none.html: no such file",
            "index.html links to #none: no such anchor",
            "index.html links to api/index.html#none: no such anchor",
            "index.html links to ../up.html: outside of the folder",
            "index.html links to none.png: no such file",
            "s.css loads http://example.org/p.png",
            "s.css loads https://example.org/a.css",
        ];
        assert_eq!(problems("broken", &files), expected);
    }
}
