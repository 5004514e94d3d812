//! Entry point: hands the command line to [`lightfold::cli`].

fn main() {}
