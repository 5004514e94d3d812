//! Panics of file parsers, converted to errors.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};

thread_local! {
    static IS_GUARDED: Cell<bool> = const { Cell::new(false) };
}

/// Returns true while this thread converts panics to errors; the panic hook then prints nothing.
pub fn is_guarded() -> bool {
    IS_GUARDED.get()
}

/// Returns the result of a parser, or `None` if it panics. For parsers whose crate does not guarantee that it never panics. State
/// that a panic leaves half-written must be dropped.
pub fn guarded<T>(work: impl FnOnce() -> T) -> Option<T> {
    IS_GUARDED.set(true);
    let done = catch_unwind(AssertUnwindSafe(work));
    IS_GUARDED.set(false);
    done.ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panics_of_guarded_work_are_known_to_hooks() {
        assert_eq!((guarded(is_guarded), is_guarded()), (Some(true), false));
        let panicked = guarded(|| std::panic::resume_unwind(Box::new("a panic without a hook")));
        assert_eq!((panicked, is_guarded()), (None::<()>, false));
    }
}
