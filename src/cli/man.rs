//! `lightfold man DIR`: writes the man pages of `man/`.

use std::path::{Path, PathBuf};

use crate::ExitStatus;
use codec::error::{Error, Result};
use footage::files::OutputFolder;

#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder to write into
    pub folder: PathBuf,
}

pub struct Page {
    /// File name such as `lightfold-encode.1`.
    pub name: String,
    pub text: Vec<u8>,
}

/// Returns one page for the program and one for each visible command.
pub fn pages(root: clap::Command) -> Result<Vec<Page>> {
    // `help` has no page, so none may refer to it.
    let mut root = root.disable_help_subcommand(true);
    root.build();
    let visible = root.get_subcommands().filter(|command| !command.is_hide_set());
    let subcommands = visible.map(|command| (format!("lightfold-{}", command.get_name()), command));
    std::iter::once(("lightfold".to_owned(), &root)).chain(subcommands).map(page).collect()
}

fn page((title, command): (String, &clap::Command)) -> Result<Page> {
    let name = format!("{title}.1");
    let source = concat!("lightfold ", env!("CARGO_PKG_VERSION"));
    let mut text = Vec::new();
    let man = clap_mangen::Man::new(command.clone()).title(title).source(source);
    man.render(&mut text).map_err(|error| Error::io(&name, error))?;
    // The program's own page lists its commands instead.
    if command.get_subcommands().next().is_none() {
        text.extend_from_slice(b".SH \"SEE ALSO\"\nlightfold(1)\n");
    }
    Ok(Page { name, text })
}

pub fn run(args: &Args, root: clap::Command) -> Result<ExitStatus> {
    let folder = OutputFolder::create(&args.folder)?;
    for page in pages(root)? {
        folder.write_bytes(Path::new(&page.name), &page.text)?;
    }
    folder.commit()?;
    Ok(ExitStatus::Passed)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the names before `(1)` in a page, without font and hyphen escapes.
    fn cited(text: &str) -> Vec<String> {
        let plain = ["\\fB", "\\fI", "\\fR", "\\"].iter().fold(text.to_owned(), |text, mark| text.replace(mark, ""));
        let is_name = |c: char| c.is_ascii_alphanumeric() || c == '-';
        let before = plain.match_indices("(1)").map(|(at, _)| &plain[..at]);
        before.map(|before| before.rsplit(|c| !is_name(c)).next().unwrap_or_default().to_owned()).collect()
    }

    #[test]
    fn cited_pages_exist_and_values_have_names_and_help() {
        let pages = pages(crate::command()).unwrap();
        let text = |page: &Page| String::from_utf8(page.text.clone()).unwrap();
        let mut citations = 0;
        for page in &pages {
            for name in cited(&text(page)) {
                let is_there = pages.iter().any(|other| other.name == format!("{name}.1"));
                assert!(is_there, "{} cites {name}(1)", page.name);
                citations += 1;
            }
        }
        assert_eq!(citations, 2 * (pages.len() - 1));
        let encode = pages.iter().find(|page| page.name == "lightfold-encode.1").map(text).unwrap();
        for words in ["predictive: Prediction and residuals", "json: JSON on standard error", "\\fI<CODEC>\\fR"] {
            assert!(encode.contains(words), "{words}: {encode}");
        }
    }
}
