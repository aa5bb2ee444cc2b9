//! All files below `src/` as a tree of modules, and which file uses which.

use crate::source::{Import, Scope, Source, Written};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::Path;

/// Names of modules from the crate down.
type Module = Vec<String>;

/// Where a path leads.
enum Target {
    /// An item in a file.
    Item(usize),
    /// A module itself.
    Module(Module),
}

/// Re-exports can lead round; no honest chain of them is longer.
const LONGEST_CHAIN: usize = 16;

/// A file uses another one.
#[derive(Debug)]
pub struct Use {
    pub from: usize,
    pub to: usize,
    /// As it is written, with its line.
    pub text: String,
}

pub struct File {
    /// From the top level.
    pub path: String,
    /// Below `src/` without extension, `ring/mod` as `ring`; the crate's root is empty.
    pub place: String,
    pub source: Source,
}

pub struct House {
    pub files: Vec<File>,
    /// File and scope of each module.
    modules: HashMap<Module, (usize, usize)>,
}

impl House {
    /// Reads every file below a folder.
    pub fn read(folder: &Path) -> Self {
        let mut files = BTreeMap::new();
        collect(folder, folder, &mut files);
        Self::new(&files)
    }

    /// From texts by their paths below `src/`, with forward slashes.
    pub fn new(texts: &BTreeMap<String, String>) -> Self {
        let mut files: Vec<File> = texts
            .iter()
            .map(|(path, text)| File {
                path: format!("src/{path}"),
                place: place(path),
                source: Source::parse(text),
            })
            .collect();
        let tests: Vec<String> = files
            .iter()
            .flat_map(|file| file.source.test_modules.iter().map(|name| join(&file.place, name)))
            .collect();
        files.retain(|file| !tests.iter().any(|test| below(&file.place, test)));
        let mut modules = HashMap::new();
        for (number, file) in files.iter().enumerate() {
            for (scope, Scope { inside, .. }) in file.source.scopes.iter().enumerate() {
                modules.insert(module(&file.place, inside), (number, scope));
            }
        }
        Self { files, modules }
    }

    /// Every use of one file by another. A re-export of what lies below a module is no use by that module.
    pub fn uses(&self) -> Vec<Use> {
        let mut uses = Vec::new();
        for (from, file) in self.files.iter().enumerate() {
            for scope in &file.source.scopes {
                let module = module(&file.place, &scope.inside);
                let mut add = |path: &[String], line: usize, targets: BTreeSet<usize>| {
                    let text = format!("{} in line {line}", path.join("::"));
                    uses.extend(targets.into_iter().filter(|&to| to != from).map(|to| Use {
                        from,
                        to,
                        text: text.clone(),
                    }));
                };
                for import in &scope.imports {
                    add(&import.path, import.line, self.imported(&module, scope, import));
                }
                for written in &scope.written {
                    if let Some(Target::Item(to)) = self.resolve(&module, &written.path, 0) {
                        add(&written.path, written.line, BTreeSet::from([to]));
                    }
                }
            }
        }
        uses
    }

    /// Files that give methods to a type of another file.
    pub fn extensions(&self) -> Vec<Use> {
        let mut extensions = Vec::new();
        for (from, file) in self.files.iter().enumerate() {
            for scope in &file.source.scopes {
                let module = module(&file.place, &scope.inside);
                for Written { path, line } in &scope.extended {
                    if let Some(Target::Item(to)) = self.resolve(&module, path, 0) {
                        let text = format!("{} in line {line}", path.join("::"));
                        extensions.push(Use { from, to, text });
                    }
                }
            }
        }
        extensions
    }

    /// Files that an import needs.
    fn imported(&self, module: &Module, scope: &Scope, import: &Import) -> BTreeSet<usize> {
        let target = self.resolve(module, &import.path, 0);
        let passed_on = import.public && !scope.words.contains(&import.name);
        match target {
            Some(Target::Item(to)) if !(passed_on && below(&self.files[to].place, &module.join("/"))) => {
                BTreeSet::from([to])
            }
            Some(Target::Module(all)) if import.name == "*" && !(import.public && all.starts_with(module)) => {
                self.names_of(&all)
            }
            _ => BTreeSet::new(),
        }
    }

    /// Files that hold what `use module::*` brings in.
    fn names_of(&self, module: &Module) -> BTreeSet<usize> {
        let (file, scope) = self.modules[module];
        let scope = &self.files[file].source.scopes[scope];
        let passed_on = scope
            .imports
            .iter()
            .filter(|import| import.public && import.name != "*");
        let mut files: BTreeSet<usize> = passed_on
            .filter_map(|import| match self.resolve(module, &import.path, 0) {
                Some(Target::Item(to)) => Some(to),
                _ => None,
            })
            .collect();
        if !self.files[file].source.only_declares() {
            files.insert(file);
        }
        files
    }

    /// Where a path leads that is written in a module; none for other crates and for names of the file's own.
    fn resolve(&self, module: &Module, path: &[String], depth: usize) -> Option<Target> {
        if depth > LONGEST_CHAIN {
            return None;
        }
        match path.first()?.as_str() {
            "crate" => self.walk(Module::new(), &path[1..], depth),
            "self" | "super" => self.walk(module.clone(), path, depth),
            head if self.modules.contains_key(&extended(module, head)) => self.walk(module.clone(), path, depth),
            head => self.through_imports(module, head, &path[1..], depth),
        }
    }

    fn walk(&self, module: Module, path: &[String], depth: usize) -> Option<Target> {
        let Some((head, rest)) = path.split_first() else {
            return Some(Target::Module(module));
        };
        if head == "self" {
            return self.walk(module, rest, depth);
        }
        if head == "super" {
            let parent = module.split_last().map(|(_, parent)| parent.to_vec());
            return self.walk(parent?, rest, depth);
        }
        let child = extended(&module, head);
        if self.modules.contains_key(&child) {
            return self.walk(child, rest, depth);
        }
        let found = self.through_imports(&module, head, rest, depth);
        found.or_else(|| Some(Target::Item(self.modules.get(&module)?.0)))
    }

    /// Follows a name that a module imports.
    fn through_imports(&self, module: &Module, name: &str, rest: &[String], depth: usize) -> Option<Target> {
        let &(file, scope) = self.modules.get(module)?;
        let scope = &self.files[file].source.scopes[scope];
        if let Some(import) = scope.imports.iter().find(|import| import.name == name) {
            let path: Vec<String> = import.path.iter().chain(rest).cloned().collect();
            return self.resolve(module, &path, depth + 1);
        }
        if scope.items.contains(name) {
            return None;
        }
        let all = scope.imports.iter().filter(|import| import.name == "*");
        all.filter_map(|import| match self.resolve(module, &import.path, depth + 1)? {
            Target::Module(other) if other != *module => self.offered(&other, name, rest, depth + 1),
            _ => None,
        })
        .next()
    }

    /// Follows a name into a module if that has it.
    fn offered(&self, module: &Module, name: &str, rest: &[String], depth: usize) -> Option<Target> {
        let &(file, scope) = self.modules.get(module)?;
        let child = extended(module, name);
        if self.modules.contains_key(&child) {
            return self.walk(child, rest, depth);
        }
        if self.files[file].source.scopes[scope].items.contains(name) {
            return Some(Target::Item(file));
        }
        self.through_imports(module, name, rest, depth)
    }
}

/// Sets of more than one file that all lead to one another.
pub fn circles(count: usize, uses: &[Use]) -> Vec<BTreeSet<usize>> {
    let reached: Vec<BTreeSet<usize>> = (0..count)
        .map(|start| {
            let mut seen = BTreeSet::new();
            let mut open = vec![start];
            while let Some(file) = open.pop() {
                let next = uses.iter().filter(|one| one.from == file).map(|one| one.to);
                open.extend(next.filter(|&to| seen.insert(to)));
            }
            seen
        })
        .collect();
    let circles: BTreeSet<BTreeSet<usize>> = (0..count)
        .map(|file| {
            let back = reached[file]
                .iter()
                .copied()
                .filter(|&other| reached[other].contains(&file));
            back.collect::<BTreeSet<usize>>()
        })
        .filter(|circle| circle.len() > 1)
        .collect();
    circles.into_iter().collect()
}

/// Whether a place is a folder or file, or lies below it.
pub fn below(place: &str, folder: &str) -> bool {
    folder.is_empty()
        || place
            .strip_prefix(folder)
            .is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
}

fn collect(root: &Path, folder: &Path, files: &mut BTreeMap<String, String>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            collect(root, &path, files);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let parts: Vec<_> = path.strip_prefix(root).expect("a path below").iter().collect();
            let parts: Vec<_> = parts.iter().map(|part| part.to_string_lossy()).collect();
            files.insert(parts.join("/"), std::fs::read_to_string(&path).expect("text"));
        }
    }
}

fn place(path: &str) -> String {
    let place = path.trim_end_matches(".rs");
    if place == "lib" || place == "mod" {
        return String::new();
    }
    place.strip_suffix("/mod").unwrap_or(place).to_owned()
}

fn module(place: &str, inside: &[String]) -> Module {
    let names = place.split('/').filter(|name| !name.is_empty()).map(str::to_owned);
    names.chain(inside.iter().cloned()).collect()
}

fn join(place: &str, name: &str) -> String {
    module(place, &[name.to_owned()]).join("/")
}

fn extended(module: &[String], name: &str) -> Module {
    module
        .iter()
        .map(String::as_str)
        .chain([name])
        .map(str::to_owned)
        .collect()
}
