//! `lightfold schema NAME`: prints JSON Schemas of files.

use crate::options::{Choices, one_of};
use crate::{ExitStatus, output};
use codec::error::Result;

/// Names of schemas, their texts, and descriptions.
const SCHEMAS: &Choices<&str> = &[(
    "manifest",
    include_str!(concat!(env!("LIGHTFOLD_FORMATS"), "/schemas/manifest.json")),
    "Manifest of a dataset, lightfield.json",
)];

#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  lightfold schema manifest > manifest.schema.json\n\n\
    Editors complete and validate a lightfield.json whose first key is \"$schema\": \"manifest.schema.json\".")]
pub struct Args {
    /// File type that the schema describes
    #[arg(value_name = "NAME", value_parser = one_of(SCHEMAS))]
    pub name: &'static str,
}

pub fn run(args: &Args) -> Result<ExitStatus> {
    output::print_text(args.name).map(|()| ExitStatus::Passed)
}
