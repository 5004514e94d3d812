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
pub fn pages(mut root: clap::Command) -> Result<Vec<Page>> {
    root.build();
    let mut pages = vec![page("lightfold".to_owned(), root.clone())?];
    for command in root.get_subcommands().filter(|command| !command.is_hide_set() && command.get_name() != "help") {
        let name = format!("lightfold-{}", command.get_name());
        pages.push(page(name, command.clone())?);
    }
    Ok(pages)
}

fn page(title: String, command: clap::Command) -> Result<Page> {
    let man =
        clap_mangen::Man::new(command).title(title.clone()).source(concat!("lightfold ", env!("CARGO_PKG_VERSION")));
    let name = format!("{title}.1");
    let mut text = Vec::new();
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
