//! Entry point: hands the command line to [`lightfold::cli`].

use std::process::ExitCode;

fn main() -> ExitCode {
    lightfold::cli::run(std::env::args_os())
}
