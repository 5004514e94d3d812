//! Entry point: passes the command line to [`lightfold::run_command_line`].

use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments: Vec<_> = std::env::args_os().collect();
    lightfold::restart_within_limit(&arguments);
    lightfold::run_command_line(arguments)
}
