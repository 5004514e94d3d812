//! `lightfold man DIR`: writes the man pages of `man/`.

use std::path::PathBuf;

use crate::cli::ExitStatus;
use crate::error::{Error, Result};

#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder to write into
    pub folder: PathBuf,
}

pub struct Page {
    /// Such as `lightfold-encode.1`.
    pub name: String,
    pub text: Vec<u8>,
}

/// One page for the program and one for each visible command.
pub fn pages(root: clap::Command) -> Result<Vec<Page>> {
    // `help` has no page, and none may cite it.
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
    Ok(Page { name, text })
}

pub fn run(args: &Args, root: clap::Command) -> Result<ExitStatus> {
    std::fs::create_dir_all(&args.folder).map_err(|error| Error::io(&args.folder, error))?;
    for page in pages(root)? {
        let path = args.folder.join(&page.name);
        std::fs::write(&path, &page.text).map_err(|error| Error::io(&path, error))?;
    }
    Ok(ExitStatus::Passed)
}
