//! Entry point: hands the command line to [`lightfold::run_command_line`].

use std::process::ExitCode;

fn main() -> ExitCode {
    lightfold::run_command_line(std::env::args_os())
}
