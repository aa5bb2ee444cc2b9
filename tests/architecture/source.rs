//! What one Rust file imports and which paths it writes, read from its tokens. What only tests see is left out.

use proc_macro2::{Delimiter, Group, TokenStream, TokenTree};
use std::collections::{BTreeSet, HashSet};

/// A `use` declaration, one for each name that it brings in.
#[derive(Clone, Debug)]
pub struct Import {
    /// The name in this file; `*` brings in all names of the path.
    pub name: String,
    pub path: Vec<String>,
    /// It passes the name on to others.
    pub public: bool,
    pub line: usize,
}

/// A path in code, such as `crate::ring::Ring` or `mesh::grade`.
#[derive(Debug)]
pub struct Written {
    pub path: Vec<String>,
    pub line: usize,
}

/// One module of a file: the file itself, or a `mod name { … }` in it.
#[derive(Debug, Default)]
pub struct Scope {
    /// Names of the modules inside the file that lead to it.
    pub inside: Vec<String>,
    pub imports: Vec<Import>,
    pub written: Vec<Written>,
    /// Types that get methods here which other files can call, other than those of a trait.
    pub extended: Vec<Written>,
    /// Names that it defines.
    pub items: HashSet<String>,
    /// All words in it outside of imports.
    pub words: HashSet<String>,
}

#[derive(Debug, Default)]
pub struct Source {
    pub scopes: Vec<Scope>,
    /// Modules in files of their own that only tests see.
    pub test_modules: Vec<String>,
    /// Lines without those of tests.
    pub lines: usize,
    test_lines: BTreeSet<usize>,
}

const ITEMS: [&str; 10] = [
    "fn",
    "struct",
    "enum",
    "trait",
    "type",
    "const",
    "static",
    "union",
    "impl",
    "macro_rules",
];

impl Source {
    pub fn parse(text: &str) -> Self {
        let tokens: TokenStream = text.parse().expect("a file of Rust tokens");
        let mut source = Self::default();
        source.scopes.push(Scope::default());
        source.read(tokens, 0);
        source.lines = text.lines().count() - source.test_lines.len();
        source
    }

    /// The file holds nothing but modules and imports.
    pub fn only_declares(&self) -> bool {
        let defines = |scope: &Scope| ITEMS.iter().any(|keyword| scope.words.contains(*keyword));
        !self.scopes.iter().any(defines)
    }

    fn read(&mut self, tokens: TokenStream, scope: usize) {
        let tokens: Vec<TokenTree> = tokens.into_iter().collect();
        let mut at = 0;
        while at < tokens.len() {
            at = match &tokens[at] {
                TokenTree::Punct(mark) if mark.as_char() == '#' => self.attribute(&tokens, at),
                TokenTree::Ident(word) if word == "use" && !is_mark(tokens.get(at + 1), '<') => {
                    self.import(&tokens, at, scope)
                }
                TokenTree::Ident(word) if word == "mod" && braced(tokens.get(at + 2)).is_some() => {
                    self.module(&tokens, at, scope)
                }
                TokenTree::Ident(word) if word == "impl" && starts_item(&tokens, at) => {
                    self.scopes[scope].extended.extend(extended_type(&tokens, at));
                    self.path(&tokens, at, scope)
                }
                TokenTree::Ident(_) => self.path(&tokens, at, scope),
                TokenTree::Group(group) => {
                    self.read(group.stream(), scope);
                    at + 1
                }
                _ => at + 1,
            };
        }
    }

    /// Passes over an attribute, and over the item behind it if that is for tests only.
    fn attribute(&mut self, tokens: &[TokenTree], start: usize) -> usize {
        let Some((for_tests, mut at)) = after_attribute(tokens, start) else {
            return start + 1;
        };
        if !for_tests {
            return at;
        }
        while let Some((_, after)) = after_attribute(tokens, at) {
            at = after;
        }
        let end = end_of_item(tokens, at);
        if let Some(name) = declared_module(&tokens[at..end]) {
            self.test_modules.push(name);
        }
        let last = tokens[end - 1].span().end().line;
        self.test_lines.extend(tokens[start].span().start().line..=last);
        end
    }

    fn import(&mut self, tokens: &[TokenTree], start: usize, scope: usize) -> usize {
        let end = (start..tokens.len())
            .find(|&at| is_mark(tokens.get(at), ';'))
            .unwrap_or(tokens.len());
        let in_parentheses = matches!(start.checked_sub(1).map(|at| &tokens[at]),
            Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Parenthesis);
        let before = start.checked_sub(if in_parentheses { 2 } else { 1 });
        let public = before.is_some_and(|at| word(tokens.get(at)).as_deref() == Some("pub"));
        let mut found = Vec::new();
        use_tree(&tokens[start + 1..end], Vec::new(), &mut found);
        let line = tokens[start].span().start().line;
        let imports = found.into_iter().map(|(name, path)| Import {
            name,
            path,
            public,
            line,
        });
        self.scopes[scope].imports.extend(imports);
        end
    }

    fn module(&mut self, tokens: &[TokenTree], start: usize, scope: usize) -> usize {
        let mut inside = self.scopes[scope].inside.clone();
        inside.extend(word(tokens.get(start + 1)));
        self.scopes.push(Scope {
            inside,
            ..Scope::default()
        });
        if let Some(body) = braced(tokens.get(start + 2)) {
            self.read(body.stream(), self.scopes.len() - 1);
        }
        start + 3
    }

    fn path(&mut self, tokens: &[TokenTree], start: usize, scope: usize) -> usize {
        let (written, at) = path_at(tokens, start);
        let scope = &mut self.scopes[scope];
        scope.words.extend(written.path.iter().cloned());
        if let (Some(keyword), Some(name)) = (written.path.last(), word(tokens.get(at)))
            && ITEMS.contains(&keyword.as_str())
        {
            scope.items.insert(name);
        }
        if written.path.len() > 1 {
            scope.written.push(written);
        }
        at
    }
}

/// The path that starts here, and where it ends.
fn path_at(tokens: &[TokenTree], start: usize) -> (Written, usize) {
    let mut path = Vec::new();
    let mut at = start;
    while let Some(name) = word(tokens.get(at)) {
        path.push(name);
        if !(is_mark(tokens.get(at + 1), ':') && is_mark(tokens.get(at + 2), ':')) {
            at += 1;
            break;
        }
        at += 3;
    }
    let line = tokens.get(start).map_or(0, |tree| tree.span().start().line);
    (Written { path, line }, at)
}

/// Whether an item can start here: at the start of a body, behind another item or behind an attribute.
fn starts_item(tokens: &[TokenTree], at: usize) -> bool {
    match at.checked_sub(1).map(|before| &tokens[before]) {
        None => true,
        Some(TokenTree::Group(group)) => group.delimiter() != Delimiter::Parenthesis,
        before => is_mark(before, ';'),
    }
}

/// The type of an `impl` without a trait, if it has a method for others.
fn extended_type(tokens: &[TokenTree], start: usize) -> Option<Written> {
    let mut at = start + 1;
    if is_mark(tokens.get(at), '<') {
        let mut open = 0;
        loop {
            if is_mark(tokens.get(at), '<') {
                open += 1;
            } else if is_mark(tokens.get(at), '>') && !is_mark(tokens.get(at - 1), '-') {
                open -= 1;
            }
            at += 1;
            if open == 0 || at == tokens.len() {
                break;
            }
        }
    }
    let body = (at..tokens.len()).find(|&at| braced(tokens.get(at)).is_some())?;
    let of_trait =
        (at..body).any(|at| word(tokens.get(at)).as_deref() == Some("for") && !is_mark(tokens.get(at + 1), '<'));
    let mut methods = braced(tokens.get(body))?.stream().into_iter();
    let for_others = methods.any(|tree| word(Some(&tree)).as_deref() == Some("pub"));
    let (written, _) = path_at(tokens, at);
    (for_others && !of_trait && !written.path.is_empty()).then_some(written)
}

/// Whether the attribute that starts here is for tests only, and where it ends.
fn after_attribute(tokens: &[TokenTree], start: usize) -> Option<(bool, usize)> {
    if !is_mark(tokens.get(start), '#') {
        return None;
    }
    let at = start + 1 + usize::from(is_mark(tokens.get(start + 1), '!'));
    let Some(TokenTree::Group(group)) = tokens.get(at) else {
        return None;
    };
    let mut inner = group.stream().into_iter();
    let conditional = word(inner.next().as_ref()).as_deref() == Some("cfg");
    let condition = inner.next().map(|tree| tree.to_string()).unwrap_or_default();
    let words: Vec<&str> = condition.split(|c: char| !c.is_alphanumeric()).collect();
    let for_tests = conditional && words.contains(&"test") && !words.contains(&"not");
    Some((for_tests, at + 1))
}

/// Where the item, statement or field that starts here ends.
fn end_of_item(tokens: &[TokenTree], start: usize) -> usize {
    let first = (start..tokens.len()).find_map(|at| word(tokens.get(at)).filter(|word| word != "pub"));
    let keyword = first.unwrap_or_default();
    let by_semicolon = ["use", "const", "static", "type", "let", "extern"].contains(&keyword.as_str());
    let by_body =
        !by_semicolon && (ITEMS.contains(&keyword.as_str()) || ["mod", "unsafe", "async"].contains(&keyword.as_str()));
    let ends = |at: &usize| {
        is_mark(tokens.get(*at), ';')
            || by_body && braced(tokens.get(*at)).is_some()
            || !by_body && !by_semicolon && is_mark(tokens.get(*at), ',')
    };
    (start..tokens.len()).find(ends).map_or(tokens.len(), |at| at + 1)
}

/// The name in `mod name;`.
fn declared_module(item: &[TokenTree]) -> Option<String> {
    let at = item
        .iter()
        .position(|tree| word(Some(tree)).as_deref() == Some("mod"))?;
    is_mark(item.get(at + 2), ';').then(|| word(item.get(at + 1)))?
}

/// All names that the tree of a `use` declaration brings in, with their paths.
fn use_tree(tokens: &[TokenTree], mut path: Vec<String>, found: &mut Vec<(String, Vec<String>)>) {
    for (at, tree) in tokens.iter().enumerate() {
        match tree {
            TokenTree::Ident(renaming) if renaming == "as" => {
                let name = word(tokens.get(at + 1)).expect("a name behind `as`");
                found.push((name, path));
                return;
            }
            TokenTree::Ident(name) if name == "self" && !path.is_empty() => {}
            TokenTree::Ident(name) => path.push(plain(&name.to_string())),
            TokenTree::Punct(mark) if mark.as_char() == '*' => {
                found.push(("*".to_owned(), path));
                return;
            }
            TokenTree::Group(group) => {
                let inner: Vec<TokenTree> = group.stream().into_iter().collect();
                for part in inner.split(|tree| is_mark(Some(tree), ',')) {
                    use_tree(part, path.clone(), found);
                }
                return;
            }
            _ => {}
        }
    }
    if let Some(name) = path.last() {
        found.push((name.clone(), path.clone()));
    }
}

fn word(tree: Option<&TokenTree>) -> Option<String> {
    match tree {
        Some(TokenTree::Ident(word)) => Some(plain(&word.to_string())),
        _ => None,
    }
}

fn plain(word: &str) -> String {
    word.trim_start_matches("r#").to_owned()
}

fn is_mark(tree: Option<&TokenTree>, mark: char) -> bool {
    matches!(tree, Some(TokenTree::Punct(found)) if found.as_char() == mark)
}

fn braced(tree: Option<&TokenTree>) -> Option<&Group> {
    match tree {
        Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Brace => Some(group),
        _ => None,
    }
}
