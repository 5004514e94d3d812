//! No circular imports between source files.
//!
//! A file imports another file if it names that file in a path: `use crate::a::b::Item`, `crate::a::b::f()`, `super::b`, or a
//! module that it declares. A name that a module only re-exports stands for the file that defines it. A declaration (`mod b;`) is
//! not an import, and a file with nothing but declarations and re-exports imports nothing. Any other file that uses its own child
//! module, and is used by that child, forms a cycle. Code under `#[cfg(test)]` does not count.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::{Path, PathBuf};

use crate::repository_rules::{product_lines, read, sources};

/// Files that may be part of a cycle. The test also fails for an entry that is no longer needed.
const IN_CIRCLES: &[&str] = &[];

/// Module of one source file.
struct Module {
    file: String,
    /// Absolute paths of all imports, re-exports included, such as `["depth", "boxes", "split"]`.
    imports: Vec<Vec<String>>,
    reexports: Vec<Reexport>,
    /// True if the file has only declarations, imports and re-exports.
    is_door: bool,
}

struct Reexport {
    /// Exported name, or `*` for a glob re-export.
    name: String,
    path: Vec<String>,
}

/// Modules by path, which begins with the folder of the package below `src/`; the path of src/lib.rs is empty.
type Modules = BTreeMap<Vec<String>, Module>;

fn path_of(file: &Path) -> Option<Vec<String>> {
    let inside = file.strip_prefix("src").unwrap().with_extension("");
    let mut path: Vec<String> = inside.iter().map(|part| part.to_str().unwrap().to_owned()).collect();
    match path.last().unwrap().as_str() {
        "main" | "tests" => return None,
        "mod" | "lib" => drop(path.pop()),
        _ => {}
    }
    (!path.iter().any(|part| part == "tests")).then_some(path)
}

/// Expands a `use` tree to paths and names: `a::{b, c::{self, d as e}}` gives `(["a", "b"], "b")`, `(["a", "c"], "c")` and
/// `(["a", "c", "d"], "e")`.
fn expand(tree: &str) -> Vec<(Vec<String>, String)> {
    let tree = tree.trim();
    let Some((prefix, group)) = tree.split_once('{') else {
        let (path, name) = tree.split_once(" as ").map_or((tree, None), |(path, name)| (path, Some(name.trim())));
        let path: Vec<String> =
            path.split("::").map(|part| part.trim().to_owned()).filter(|part| !part.is_empty()).collect();
        let name = name.unwrap_or(path.last().map_or("", String::as_str)).to_owned();
        return vec![(path, name)];
    };
    let prefix: Vec<String> =
        prefix.split("::").map(|part| part.trim().to_owned()).filter(|part| !part.is_empty()).collect();
    let group = &group[..group.rfind('}').unwrap()];
    let (mut items, mut depth, mut start) = (Vec::new(), 0, 0);
    for (at, c) in group.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                items.push(&group[start..at]);
                start = at + 1;
            }
            _ => {}
        }
    }
    items.push(&group[start..]);
    let inner = items.into_iter().filter(|item| !item.trim().is_empty()).flat_map(expand);
    inner
        .map(|(path, name)| {
            let is_self = path == ["self"];
            let name = if is_self && name == "self" { prefix.last().unwrap().clone() } else { name };
            (prefix.iter().cloned().chain(path.into_iter().filter(|_| !is_self)).collect(), name)
        })
        .collect()
}

/// Resolves a path used in `module` to a path from the root of `src/`. Returns `None` for a path into another package: packages
/// do not depend on each other in circles.
fn absolute(path: &[String], module: &[String], children: &BTreeSet<String>) -> Option<Vec<String>> {
    match path.first()?.as_str() {
        "crate" => Some(module.first().into_iter().chain(&path[1..]).cloned().collect()),
        "self" => Some(module.iter().chain(&path[1..]).cloned().collect()),
        "super" => {
            let parent = &module[..module.len().checked_sub(1)?];
            match path.get(1).map(String::as_str) {
                Some("super") => absolute(&path[1..], parent, children),
                _ => Some(parent.iter().chain(&path[1..]).cloned().collect()),
            }
        }
        child if children.contains(child) => Some(module.iter().chain(path).cloned().collect()),
        _ => None,
    }
}

fn is_word(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_'
}

/// Returns the paths in `code` that begin with `crate`, `self`, `super` or a child module.
fn paths_in(code: &str, children: &BTreeSet<String>) -> Vec<Vec<String>> {
    let starts = ["crate", "super", "self"].into_iter().chain(children.iter().map(String::as_str));
    let mut found = Vec::new();
    for start in starts {
        for (at, word) in code.match_indices(&format!("{start}::")) {
            if code[..at].ends_with(|c: char| is_word(c) || c == ':' || c == '$') {
                continue;
            }
            let rest = &code[at + word.len()..];
            let end = rest.find(|c: char| !is_word(c) && c != ':').unwrap_or(rest.len());
            let words = rest[..end].split("::").take_while(|part| !part.is_empty() && part.chars().all(is_word));
            found.push([start].into_iter().chain(words).map(str::to_owned).collect());
        }
    }
    found
}

fn module(file: &Path, path: &[String]) -> Module {
    let text = read(file);
    let code: String = product_lines(&text).into_iter().map(|(_, line)| format!("{line}\n")).collect();
    let mut children = BTreeSet::new();
    let (mut uses, mut other, mut rest) = (Vec::new(), String::new(), code.as_str());
    // A declaration or a `use` begins a line and ends with a semicolon.
    while !rest.is_empty() {
        let line = rest.split('\n').next().unwrap();
        let trimmed = line.trim_start().trim_start_matches("pub(crate) ").trim_start_matches("pub(super) ");
        let trimmed = trimmed.trim_start_matches("pub ");
        if let Some(name) = trimmed.strip_prefix("mod ").and_then(|name| name.trim_end().strip_suffix(';')) {
            children.insert(name.to_owned());
        } else if trimmed.starts_with("use ") {
            let end = rest.find(';').unwrap();
            let statement = &rest[..end];
            let tree = &statement[statement.find("use ").unwrap() + 4..];
            uses.push((statement.trim_start().starts_with("pub"), tree.replace('\n', " ")));
            rest = rest[end + 1..].strip_prefix('\n').unwrap_or(&rest[end + 1..]);
            continue;
        } else {
            other += line;
            other.push('\n');
        }
        rest = rest.get(line.len() + 1..).unwrap_or("");
    }
    let is_attribute = |line: &str| line.starts_with("#[") || line.starts_with("#![");
    let is_door = other.lines().map(str::trim).all(|line| line.is_empty() || is_attribute(line));
    let mut found = Module { file: file.display().to_string(), imports: Vec::new(), reexports: Vec::new(), is_door };
    for (is_public, tree) in uses {
        for (used, name) in expand(&tree) {
            let Some(target) = absolute(&used, path, &children) else { continue };
            if is_public {
                found.reexports.push(Reexport { name, path: target.clone() });
            }
            found.imports.push(target);
        }
    }
    let inline = paths_in(&other, &children);
    found.imports.extend(inline.iter().filter_map(|inline| absolute(inline, path, &children)));
    found
}

/// Resolves a path to a module through at most `left` re-exports.
fn resolve<'a>(modules: &'a Modules, path: &[String], left: u32) -> Option<&'a Module> {
    let known = (0..=path.len()).rev().find(|&length| modules.contains_key(&path[..length]))?;
    let module = &modules[&path[..known]];
    let Some(name) = path.get(known).filter(|_| left > 0) else { return Some(module) };
    let behind = module.reexports.iter().filter(|reexport| reexport.name == *name || reexport.name == "*");
    for reexport in behind {
        let mut target = reexport.path.clone();
        if reexport.name == "*" {
            target.pop();
            target.push(name.clone());
        }
        target.extend_from_slice(&path[known + 1..]);
        if let Some(found) = resolve(modules, &target, left - 1)
            && (reexport.name != "*" || found.file != module.file)
        {
            return Some(found);
        }
    }
    Some(module)
}

/// Returns the files that each file imports.
fn imports() -> BTreeMap<String, BTreeSet<String>> {
    let files: Vec<(PathBuf, Vec<String>)> =
        sources().into_iter().filter_map(|file| path_of(&file).map(|path| (file, path))).collect();
    let modules: Modules = files.iter().map(|(file, path)| (path.clone(), module(file, path))).collect();
    let mut imports = BTreeMap::new();
    for module in modules.values() {
        let targets: BTreeSet<String> = match module.is_door {
            true => BTreeSet::new(),
            false => module
                .imports
                .iter()
                .filter_map(|path| resolve(&modules, path, 8))
                .filter(|target| target.file != module.file && !target.is_door)
                .map(|target| target.file.clone())
                .collect(),
        };
        imports.insert(module.file.clone(), targets);
    }
    imports
}

/// Returns the shortest import cycle through a file, if there is one.
fn circle<'a>(imports: &'a BTreeMap<String, BTreeSet<String>>, start: &'a str) -> Option<Vec<&'a str>> {
    let mut before: BTreeMap<&str, &str> = BTreeMap::new();
    let mut queue = VecDeque::from([start]);
    while let Some(file) = queue.pop_front() {
        for next in &imports[file] {
            if next == start {
                let mut way = vec![start, file];
                while let Some(&earlier) = before.get(way.last().unwrap()) {
                    way.push(earlier);
                }
                way.reverse();
                return Some(way);
            }
            if !before.contains_key(next.as_str()) {
                before.insert(next, file);
                queue.push_back(next);
            }
        }
    }
    None
}

#[test]
fn files_import_each_other_in_no_circle() {
    let imports = imports();
    let edges: usize = imports.values().map(BTreeSet::len).sum();
    assert!(edges > 1000, "only {edges} imports were found");
    let mut wrong = Vec::new();
    for file in imports.keys() {
        match (circle(&imports, file), IN_CIRCLES.contains(&file.as_str())) {
            (Some(way), false) => wrong.push(way.join("\n    imports ")),
            (None, true) => wrong.push(format!("{file} is in no circle any more: take it from IN_CIRCLES")),
            _ => {}
        }
    }
    for file in IN_CIRCLES.iter().filter(|file| !imports.contains_key(**file)) {
        wrong.push(format!("{file} is gone: take it from IN_CIRCLES"));
    }
    wrong.sort_by_key(String::len);
    assert!(wrong.is_empty(), "{} files import each other in circles:\n{}", wrong.len(), wrong.join("\n\n"));
}

#[test]
fn trees_of_use_are_expanded() {
    let expanded = expand("a::{self, b as c, d::{e, *}}");
    let words: Vec<String> = expanded.iter().map(|(path, name)| format!("{} {name}", path.join("::"))).collect();
    assert_eq!(words, ["a a", "a::b c", "a::d::e e", "a::d::* *"]);
    let children = BTreeSet::from(["child".to_owned()]);
    let module = ["a".to_owned(), "b".to_owned()];
    let of = |path: &str| {
        let path: Vec<String> = path.split("::").map(str::to_owned).collect();
        absolute(&path, &module, &children).map(|path| path.join("::"))
    };
    assert_eq!(of("crate::x::y").unwrap(), "a::x::y");
    assert_eq!([of("super::c::f"), of("super::super::d")].map(Option::unwrap), ["a::c::f", "d"]);
    assert_eq!([of("child::f"), of("self::g")].map(Option::unwrap), ["a::b::child::f", "a::b::g"]);
    assert_eq!(of("std::fs"), None);
    assert_eq!(paths_in("x(child::f, $crate::no, other_child::no)", &children), [["child", "f"]]);
}
