//! Forms of progress output.

use super::choice::Choices;

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum ProgressForm {
    #[default]
    Auto,
    Json,
    OpenJd,
    None,
}

pub const PROGRESS_FORMS: &Choices<ProgressForm> = &[
    ("auto", ProgressForm::Auto, "A bar on a terminal, nothing in a pipe"),
    ("json", ProgressForm::Json, "JSON on standard error: one object per line, at most two per second"),
    (
        "openjd",
        ProgressForm::OpenJd,
        "Open Job Description messages on standard output, or on standard error if the result goes to standard output",
    ),
    ("none", ProgressForm::None, "No progress"),
];
