//! README, ARCHITECTURE, BENCHMARKS and the other documents: links, commands and tables.

use std::collections::BTreeSet;
use std::path::PathBuf;

use codec::image::channels;
use footage::dataset::Manifest;

use crate::repository_rules::{blocks, files_below, read, root, subcommands};

/// Documents in the root folder.
pub const DOCUMENTS: [&str; 5] = ["README.md", "ARCHITECTURE.md", "BENCHMARKS.md", "CONTRIBUTING.md", "CHANGELOG.md"];

/// Documents in other folders, except formats/ and man/.
const MORE_DOCUMENTS: [&str; 2] = ["shaders/README.md", "python/README.md"];

#[test]
fn the_readme_shows_what_there_is() {
    let text = read("README.md");
    let commands = text.split("## Commands").nth(1).and_then(|rest| rest.split("\n## ").next()).expect("the commands");
    let rows = commands.lines().filter(|line| line.starts_with("| ")).flat_map(|row| row.split('`').skip(1).step_by(2));
    let mut listed: Vec<&str> = rows.collect();
    listed.sort_unstable();
    let all = subcommands();
    let mut names: Vec<&str> = all.iter().map(|command| command.get_name()).collect();
    names.sort_unstable();
    assert_eq!(listed, names, "commands in README.md, and those of the program");
    for manifest in blocks(&text, "json") {
        Manifest::from_json(manifest.as_bytes()).unwrap();
    }
}

#[test]
fn manifest_md_names_every_channel() {
    let text = read("formats/manifest.md");
    let names = [channels::DEPTH_CHANNELS, channels::DEPTH_ENDINGS, channels::COLOR_LAYERS, channels::GRAY_CHANNELS];
    for name in names.into_iter().flatten().chain(channels::COLOR_COMPONENTS.iter().flatten()) {
        assert!(name.is_empty() || text.contains(&format!("`{name}`")), "manifest.md does not name the channel {name}");
    }
}

#[test]
fn benchmarks_md_has_the_table_that_a_script_writes() {
    let text = read("BENCHMARKS.md");
    let (begin, end) = ("<!-- table:builtin -->", "<!-- end:builtin -->");
    let table = text.split(begin).nth(1).and_then(|rest| rest.split(end).next());
    let rows = table.unwrap_or_else(|| panic!("BENCHMARKS.md has no {begin} or {end}"));
    assert!(rows.lines().filter(|line| line.starts_with('|')).count() > 2, "{begin} is empty");
}

/// Returns the anchor of a heading, as Git hosts generate it.
fn anchor(heading: &str) -> String {
    let kept = |c: &char| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_');
    heading.trim_start_matches('#').trim().to_lowercase().chars().filter(kept).collect::<String>().replace(' ', "-")
}

#[test]
fn links_lead_somewhere() {
    let documents = DOCUMENTS.iter().map(PathBuf::from).chain(MORE_DOCUMENTS.map(PathBuf::from));
    for document in documents.chain(files_below("formats")) {
        let text = read(&document);
        for link in text.split("](").skip(1).map(|rest| rest.split(')').next().unwrap()) {
            let (path, fragment) = link.split_once('#').unwrap_or((link, ""));
            if path.starts_with("https:") || path.starts_with("http:") {
                continue;
            }
            let target = if path.is_empty() { document.clone() } else { document.with_file_name(path) };
            assert!(root().join(&target).exists(), "{}: {link} leads nowhere", document.display());
            if !fragment.is_empty() {
                let found = read(&target).lines().any(|line| line.starts_with('#') && anchor(line) == fragment);
                assert!(found, "{}: no heading for {link}", document.display());
            }
        }
    }
}

/// Returns the documents of the root folder, formats/, man/ and [`MORE_DOCUMENTS`].
fn documents() -> Vec<PathBuf> {
    let mut documents: Vec<PathBuf> = DOCUMENTS.iter().map(PathBuf::from).collect();
    documents.extend(files_below("formats").into_iter().chain(files_below("man")));
    documents.extend(MORE_DOCUMENTS.map(PathBuf::from));
    documents
}

#[test]
fn no_document_holds_a_placeholder() {
    for document in documents() {
        let text = read(&document);
        // A placeholder is a word of capitals, digits and underscores between two `@`. The text after the last `@` is not between
        // two.
        let between: Vec<&str> = text.split('@').skip(1).collect();
        let placeholder = between.iter().rev().skip(1).find(|word| {
            !word.is_empty() && word.chars().all(|c| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_')
        });
        assert_eq!(placeholder, None, "{}", document.display());
    }
}

#[test]
fn no_document_names_a_folder_outside_the_repository() {
    let beside = ["..", "shared"].join("/");
    for document in documents() {
        assert!(!read(&document).contains(&beside), "{} names {beside}", document.display());
    }
}

/// Returns the names that `src/lib.rs` re-exports without `#[doc(hidden)]`.
fn public_face() -> BTreeSet<String> {
    let text = read("src/lib.rs");
    let mut names = BTreeSet::new();
    let mut hidden = false;
    for statement in text.split(';') {
        hidden |= statement.contains("#[doc(hidden)]");
        if let Some((_, path)) = statement.split_once("pub use ") {
            if !hidden {
                let last = path.trim().rsplit("::").next().unwrap();
                let list = path.split_once('{').map_or(last, |(_, list)| list.trim_end_matches('}'));
                names.extend(list.split(',').map(|name| name.trim().to_owned()).filter(|name| !name.is_empty()));
            }
            hidden = false;
        }
    }
    names
}

#[test]
fn architecture_md_lists_the_public_face() {
    let text = read("ARCHITECTURE.md");
    let table = text.split("<!-- api:").nth(1).expect("ARCHITECTURE.md has a table marked <!-- api: -->");
    let rows = table.lines().skip_while(|line| !line.starts_with('|')).take_while(|line| line.starts_with('|')).skip(2);
    let listed: BTreeSet<String> = rows
        .flat_map(|row| row.split('|').nth(1).unwrap().split(','))
        .map(|name| name.trim().trim_matches('`').to_owned())
        .collect();
    let face = public_face();
    assert!(face.len() > 10, "{face:?}");
    assert_eq!(listed, face, "names in ARCHITECTURE.md, and names that src/lib.rs re-exports");
}
