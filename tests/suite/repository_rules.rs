//! Repository rules: man pages, help, README, and rules for every file.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use clap::Parser;
use cli::Cli;
use gpu::selftest::ROWS;
use kernels::{DRAWINGS, KERNELS, ShaderFile};

use crate::documents::DOCUMENTS;

/// Width at which help text is wrapped, in columns.
const HELP_COLUMNS: usize = 100;
/// Maximum length of a source file, in lines.
const MAX_LINES: usize = 650;

pub(crate) fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

pub(crate) fn read(path: impl AsRef<Path>) -> String {
    let path = root().join(path);
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Returns the files below `folder`, sorted. All paths are relative to the repository root.
pub(crate) fn files_below(folder: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![root().join(folder)];
    while let Some(folder) = folders.pop() {
        let Ok(entries) = fs::read_dir(&folder) else { continue };
        for entry in entries {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                found.push(path.strip_prefix(root()).unwrap().to_path_buf());
            }
        }
    }
    found.sort();
    found
}

/// Returns the Rust sources of all packages, without build scripts.
pub(crate) fn sources() -> Vec<PathBuf> {
    let mut sources = files_below("src");
    let is_source = |path: &Path| path.extension().is_some_and(|extension| extension == "rs");
    sources.retain(|path| is_source(path) && !path.ends_with("build.rs") && !path.starts_with("src/build"));
    sources
}

/// Returns the numbered lines of a source, without comment lines and without the `#[cfg(test)]` module at its end.
pub(crate) fn product_lines(text: &str) -> Vec<(usize, &str)> {
    let end = text.find("\n#[cfg(test)]\nmod ").unwrap_or(text.len());
    text[..end]
        .lines()
        .enumerate()
        .filter(|(_, line)| !line.trim_start().starts_with("//"))
        .map(|(number, line)| (number + 1, line))
        .collect()
}

#[test]
fn every_shader_is_in_a_row_and_says_what_it_mirrors() {
    let path = |file: &ShaderFile| Path::new("shaders").join(file.path);
    let of_kernels = KERNELS.iter().flat_map(|kernel| kernel.files);
    let used: BTreeSet<PathBuf> =
        of_kernels.chain(DRAWINGS.iter().flat_map(|drawing| drawing.files)).map(path).collect();
    let mut shaders = files_below("shaders");
    shaders.retain(|path| path.extension().is_some_and(|extension| extension == "wgsl"));
    assert!(shaders.len() > 10, "only {} shaders were found", shaders.len());
    for path in shaders {
        assert!(used.contains(&path), "{} is in no row of shaders/kernels.json", path.display());
        let text = read(&path);
        assert!(text.starts_with("// "), "{} does not say what it is", path.display());
        assert!(text.lines().count() <= MAX_LINES, "{} is too long", path.display());
        let mirrored = text.lines().take_while(|line| line.starts_with("//")).flat_map(str::split_whitespace);
        let named =
            mirrored.map(|word| word.trim_end_matches(['.', ',', ';', ':'])).filter(|word| word.starts_with("src/"));
        for source in named {
            assert!(root().join(source).exists(), "{} mirrors {source}, which is not there", path.display());
        }
    }
    // A reader kernel is tested together with its kernel.
    let run = ROWS.iter().flat_map(|row| row.kernel.reader.into_iter().chain([row.kernel]));
    let rows: BTreeSet<_> = run.map(|kernel| kernel.name).collect();
    let kernels: BTreeSet<_> = KERNELS.iter().map(|kernel| kernel.name).collect();
    assert_eq!(rows, kernels, "kernels, and rows of inputs in src/gpu/selftest.rs");
}

#[test]
fn man_pages_are_fresh() {
    let again = "make them again: cargo run -- man man";
    let pages = cli::man::pages(cli::command()).unwrap();
    for page in &pages {
        let path = root().join("man").join(&page.name);
        let kept = fs::read(&path).unwrap_or_else(|error| panic!("man/{}: {error}; {again}", page.name));
        assert!(kept == page.text, "man/{} is not what the command line says; {again}", page.name);
    }
    let made: BTreeSet<_> = pages.iter().map(|page| Path::new("man").join(&page.name)).collect();
    let kept: BTreeSet<_> = files_below("man").into_iter().collect();
    assert_eq!(kept, made, "pages under man/; {again}");
}

/// Returns the visible subcommands, without `help`.
pub(crate) fn subcommands() -> Vec<clap::Command> {
    let mut root = cli::command();
    root.build();
    root.get_subcommands().filter(|command| !command.is_hide_set() && command.get_name() != "help").cloned().collect()
}

#[test]
fn every_subcommand_has_examples_that_parse() {
    for command in subcommands() {
        let name = command.get_name();
        let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
        let (_, examples) = help.split_once("Example").unwrap_or_else(|| panic!("{name}: no 'Example' in its help"));
        let mut parsed = 0;
        for line in examples.lines().filter(|line| line.starts_with(' ')) {
            assert!(line.chars().count() <= HELP_COLUMNS, "{name}: this line of its help would be broken: {line}");
        }
        for line in joined_lines(examples).iter().filter(|line| line.trim().starts_with("lightfold ")) {
            parsed += check_command_line(line, &format!("help of {name}"));
        }
        assert!(parsed > 0, "{name}: no command under 'Example'");
    }
}

/// Returns the lines of a shell script. A line that ends in a backslash is joined with the next one.
fn joined_lines(text: &str) -> Vec<String> {
    text.replace("\\\n", " ").lines().map(str::to_owned).collect()
}

/// Splits a shell command into words. Handles quotes and `#` comments, and no other shell syntax.
pub(crate) fn shell_words(line: &str) -> Vec<String> {
    let (mut words, mut word, mut quote) = (Vec::new(), None::<String>, None);
    for c in line.chars() {
        match (quote, c) {
            (Some(open), _) if c == open => quote = None,
            (None, '\'' | '"') => {
                quote = Some(c);
                word.get_or_insert_default();
            }
            (None, '#') if word.is_none() => break,
            (None, _) if c.is_whitespace() => words.extend(word.take()),
            _ => word.get_or_insert_default().push(c),
        }
    }
    words.extend(word);
    words
}

/// Parses every `lightfold` command of a line, which may have pipes and redirections. Returns the number of commands.
fn check_command_line(line: &str, place: &str) -> usize {
    let words = shell_words(line);
    let mut count = 0;
    for command in words.split(|word| matches!(word.as_str(), "|" | "&&" | ";")) {
        let command: Vec<_> = command.iter().take_while(|word| !matches!(word.as_str(), ">" | "<" | "2>")).collect();
        if command.first().is_some_and(|word| *word == "lightfold") {
            if let Err(error) = Cli::try_parse_from(&command) {
                panic!("{place}: `{line}` is not accepted: {error}");
            }
            count += 1;
        }
    }
    count
}

#[test]
fn shell_words_are_split() {
    assert_eq!(shell_words("a  'b c' d#e  # f"), ["a", "b c", "d#e"]);
    assert_eq!(shell_words("x \"\" y.####.exr"), ["x", "", "y.####.exr"]);
}

/// Returns the contents of the fenced code blocks of a language.
pub(crate) fn blocks<'a>(text: &'a str, language: &str) -> Vec<&'a str> {
    let fence = format!("```{language}\n");
    text.split(fence.as_str()).skip(1).map(|rest| rest.split("```").next().unwrap()).collect()
}

#[test]
fn commands_in_the_documents_are_accepted() {
    for document in ["README.md", "CONTRIBUTING.md"] {
        let text = read(document);
        let mut count = 0;
        for line in blocks(&text, "sh").iter().flat_map(|block| joined_lines(block)) {
            count += check_command_line(&line, document);
            if let Some(script) = line.split_whitespace().next().filter(|word| word.starts_with("scripts/")) {
                assert!(root().join(script).is_file(), "{document}: there is no {script}");
                count += 1;
            }
        }
        assert!(count > 0, "{document} shows no command");
    }
}

#[test]
fn no_source_file_is_too_long() {
    let mut files = sources();
    files.extend(files_below("tests/suite"));
    files.extend(files_below("tests/gpu"));
    files.extend(files_below("python/src"));
    for path in files {
        let lines = read(&path).lines().count();
        assert!(lines <= MAX_LINES, "{} has {lines} lines; it wants splitting", path.display());
    }
}

/// Panics that product code may contain: (file, part of the line, reason why the panic cannot occur).
const PANICS_ALLOWED: &[(&str, &str, &str)] = &[];

#[test]
fn product_code_does_not_panic_on_purpose() {
    let words = [".unwrap()", ".expect(", "panic!(", "unreachable!(", "todo!(", "unimplemented!("];
    let mut wrong = Vec::new();
    // Files named tests.rs are declared under `#[cfg(test)]`.
    for path in sources().into_iter().filter(|path| !path.ends_with("tests.rs")) {
        let text = read(&path);
        for (number, line) in product_lines(&text) {
            let allowed = |(file, words, _): &(&str, &str, &str)| path.ends_with(file) && line.contains(words);
            if words.iter().any(|word| line.contains(word)) && !PANICS_ALLOWED.iter().any(allowed) {
                wrong.push(format!("{}:{number}: {}", path.display(), line.trim()));
            }
        }
    }
    assert!(wrong.is_empty(), "can panic; return an error instead:\n{}", wrong.join("\n"));
}

#[test]
fn nothing_names_a_path_of_one_machine() {
    let mut files = Vec::new();
    for folder in ["src", "tests", "formats", "man", "python", "scripts", ".ci", "shaders"] {
        files.extend(files_below(folder));
    }
    files.extend(["Cargo.toml", "pyproject.toml"].iter().chain(&DOCUMENTS).map(PathBuf::from));
    // Joined at run time, so that this file does not contain these paths.
    let forbidden = ["work", "root", "home", "Users"].map(|folder| format!("/{folder}/"));
    for path in files {
        let Ok(text) = fs::read_to_string(root().join(&path)) else { continue };
        for words in &forbidden {
            assert!(!text.contains(words.as_str()), "{} names a path below {words}", path.display());
        }
    }
}

/// True for a file that may name options: the commands, and the sweeps, which run command lines.
fn knows_options(path: &Path) -> bool {
    let is_library = path.starts_with("src/cli/report") || path.starts_with("src/cli/serve");
    path.starts_with("src/cli/report/tradeoff") || path.starts_with("src/cli") && !is_library
}

#[test]
fn messages_of_the_library_name_settings_and_not_options() {
    let options: BTreeSet<String> = subcommands()
        .iter()
        .flat_map(|command| command.get_arguments().filter_map(|option| option.get_long()).map(str::to_owned))
        .collect();
    let mut wrong = Vec::new();
    for path in sources() {
        if knows_options(&path) || path.ends_with("tests.rs") {
            continue;
        }
        let text = read(&path);
        for (number, line) in product_lines(&text) {
            let line = line.split(" // ").next().unwrap();
            let letter = |text: &str| text.starts_with(|c: char| c.is_ascii_lowercase());
            if line.match_indices("--").any(|(at, _)| letter(&line[at + 2..])) {
                wrong.push(format!("{}:{number}: names an option: {}", path.display(), line.trim()));
            }
            let is_name = |word: &&str| letter(word) && word.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
            for name in line.split('`').skip(1).step_by(2).filter(is_name) {
                if !options.contains(&name.replace('_', "-")) {
                    wrong.push(format!("{}:{number}: no option sets `{name}`", path.display()));
                }
            }
        }
    }
    assert!(
        wrong.is_empty(),
        "messages name settings, as in `depth_window`; only cli knows options:\n{}",
        wrong.join("\n")
    );
}
