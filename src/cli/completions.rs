//! `lightfold completions SHELL`: prints a completion script.

use crate::{ExitStatus, output};
use codec::error::Result;

#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  lightfold completions bash > ~/.local/share/bash-completion/completions/lightfold")]
pub struct Args {
    /// Shell to complete commands in
    #[arg(value_enum)]
    pub shell: clap_complete::Shell,
}

pub fn run(args: &Args, mut root: clap::Command) -> Result<ExitStatus> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut root, "lightfold", &mut script);
    output::print_text(&String::from_utf8_lossy(&script))?;
    Ok(ExitStatus::Passed)
}
