//! The account of an input at the end of a command.

use clap::Args;
use serde::Serialize;

use crate::global::{EXIT_INTERRUPTED, exit_code};
use crate::{GlobalArgs, output};
use codec::error::Result;
use footage::account::Account;

/// Maximum number of sentences that are printed without `--verbose`.
const MAX_NOTES: usize = 40;

#[derive(Debug, Clone, Args)]
pub struct AccountArgs {
    /// List everything that is used of the input, and everything that is left out
    #[arg(long, short)]
    pub verbose: bool,
}

impl AccountArgs {
    /// Prints the first sentences about what is left out, before the work begins.
    pub fn notes(&self, account: &Account, global: &GlobalArgs) {
        if self.verbose {
            return;
        }
        account.left_out.iter().take(MAX_NOTES).for_each(|sentence| global.note(sentence));
        if account.left_out.len() > MAX_NOTES {
            let more = account.left_out.len() - MAX_NOTES;
            global.note(format_args!("{more} more; --verbose lists all"));
        }
    }

    /// Reports the result of a command with the account: as JSON on standard output, or as notes that end with one line, or with
    /// all of the account if `--verbose`.
    pub fn report(
        &self,
        (account, as_json): (&Account, bool),
        report: impl Serialize,
        text: impl FnOnce() -> String,
        global: &GlobalArgs,
    ) -> Result<()> {
        global.report(as_json, WithAccount { report, account }, text)?;
        if !as_json {
            self.print(account, global);
        }
        Ok(())
    }

    /// Prints the sentences about what is left out and the account of an input that was inspected, unless JSON has them.
    pub fn print_inspected(&self, account: &Account, as_json: bool, global: &GlobalArgs) {
        if !as_json {
            self.notes(account, global);
            self.print(account, global);
        }
    }

    /// Prints the account of an input whose use failed, unless a signal stopped it; returns the result as it is.
    pub fn print_if_failed<T>(&self, result: Result<T>, account: &Account, global: &GlobalArgs) -> Result<T> {
        if result.as_ref().is_err_and(|error| exit_code(error) != EXIT_INTERRUPTED) {
            self.print(account, global);
        }
        result
    }

    /// Prints the account: one line, or all of it with `--verbose`.
    pub fn print(&self, account: &Account, global: &GlobalArgs) {
        match self.verbose {
            true => account.lines().iter().for_each(output::note),
            false => global.note(account.summary()),
        }
    }
}

/// A report with the account of its input.
#[derive(Serialize)]
pub struct WithAccount<'a, T> {
    #[serde(flatten)]
    pub report: T,
    pub account: &'a Account,
}
