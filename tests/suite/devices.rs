//! `decode --device` and `selftest` on a machine without a graphics device. Tests that need a device are in `tests/gpu/`.
#![cfg(target_os = "linux")]

use std::path::Path;
use std::process::{Command, Output};

/// Runs the program with a Vulkan loader that finds no driver. Returns the exit code, standard output and standard error.
fn without_drivers(arguments: &[&str]) -> (Option<i32>, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lightfold"));
    for variable in ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"] {
        command.env(variable, "no-driver-is-here.json");
    }
    let Output { status, stdout, stderr } = command.args(arguments).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (status.code(), text(stdout), text(stderr))
}

fn vector() -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/vectors/valid/nodes-w3.lfold").display().to_string()
}

#[test]
fn without_a_device_gpu_is_refused_and_auto_takes_the_cpu() {
    let input = vector();
    let (code, _, words) = without_drivers(&["decode", &input, "--null", "--device", "gpu"]);
    assert_eq!(code, Some(2), "{words}");
    assert!(words.contains("no graphics device was found") && words.contains("--device cpu"), "{words}");

    let (code, report, words) = without_drivers(&["decode", &input, "--null", "--device", "auto", "--json"]);
    assert_eq!(code, Some(0), "{words}");
    assert!(words.contains("using the CPU instead"), "{words}");
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    assert_eq!(report["device"], "cpu");
    assert_eq!(report["frames"], 9);

    let (code, _, words) = without_drivers(&["decode", &input, "--verify"]);
    assert_eq!(code, Some(2), "{words}");
    let (code, _, words) = without_drivers(&["selftest"]);
    assert_eq!(code, Some(2), "{words}");
    assert!(words.contains("no graphics device was found"), "{words}");

    let (code, list, _) = without_drivers(&["selftest", "--list-devices", "--json"]);
    assert_eq!((code, list.split_whitespace().collect::<String>().as_str()), (Some(0), r#"{"devices":[]}"#));
    let (code, list, _) = without_drivers(&["decode", "--list-devices"]);
    assert_eq!((code, list.as_str()), (Some(0), "no graphics device was found\n"));
}

#[test]
fn hard_cases_are_tested_without_a_device_which_is_said() {
    let only = ["selftest", "--hard-cases", "--family", "geometry"];
    let (code, report, words) = without_drivers(&[only.as_slice(), &["--json"]].concat());
    assert_eq!(code, Some(0), "{words}");
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    assert_eq!((&report["device_tested"], &report["failed"]), (&false.into(), &false.into()));
    assert_eq!(report["devices"].as_array().map(Vec::len), Some(0));
    let cases = report["hard_cases"].as_array().unwrap();
    assert!(cases.len() > 20, "{}", cases.len());
    for case in cases {
        assert_eq!((case["family"].as_str(), &case["passed"]), (Some("geometry"), &true.into()), "{case}");
        for key in ["name", "pipeline", "unit", "bound", "measured"] {
            assert!(!case[key].is_null(), "{key} of {case}");
        }
        assert!(case["device"].is_null() && case["mismatched_words"].is_null(), "{case}");
    }
    let (code, text, words) = without_drivers(&only);
    assert_eq!(code, Some(0), "{words}");
    assert!(text.contains(" 0 failed") && text.contains("no graphics device was found"), "{text}");
    assert_eq!(without_drivers(&["selftest", "--hard-cases", "--streams", "5"]).0, Some(2));
    assert_eq!(without_drivers(&["selftest", "--family", "geometry"]).0, Some(2));
    assert_eq!(without_drivers(&["selftest", "--hard-cases", "--family", "color"]).0, Some(2));
}

#[test]
fn options_that_contradict_each_other_are_refused() {
    let input = vector();
    let (code, _, words) = without_drivers(&["decode", &input, "--verify", "--device", "cpu"]);
    assert_eq!(code, Some(2));
    assert!(words.contains("--verify compares"), "{words}");
    assert_eq!(without_drivers(&["decode", &input, "--verify", "-o", "out"]).0, Some(2));
    assert_eq!(without_drivers(&["decode", &input]).0, Some(2));
    assert_eq!(without_drivers(&["decode", "--null"]).0, Some(2));
}
