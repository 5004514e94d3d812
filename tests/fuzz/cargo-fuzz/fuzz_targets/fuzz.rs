//! The fuzz program for all targets. The environment variable LIGHTFOLD_FUZZ selects the target; default: `container`.

#![no_main]

use std::sync::OnceLock;

use libfuzzer_sys::fuzz_target;

#[allow(dead_code)]
#[path = "../../targets/mod.rs"]
mod targets;

use targets::{TARGETS, Target};

fn chosen() -> &'static Target {
    static CHOSEN: OnceLock<&Target> = OnceLock::new();
    CHOSEN.get_or_init(|| {
        let name = std::env::var("LIGHTFOLD_FUZZ").unwrap_or_else(|_| "container".into());
        let found = TARGETS.iter().find(|target| target.name == name);
        found.unwrap_or_else(|| panic!("LIGHTFOLD_FUZZ is '{name}', which is no target"))
    })
}

fuzz_target!(|input: &[u8]| {
    if let Err(what) = (chosen().run)(input) {
        panic!("{what}");
    }
});
