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
    ("json", ProgressForm::Json, "JSON on standard error, one object a line, at most two a second"),
    (
        "openjd",
        ProgressForm::OpenJd,
        "Lines of Open Job Description, on standard output, or on standard error where that carries the result",
    ),
    ("none", ProgressForm::None, "Nothing"),
];
