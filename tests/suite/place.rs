//! `lightfold place` on the command line: files, reports and messages, and camera files as input for the next run.

use std::fs;
use std::path::Path;

use footage::dataset::CameraSet;
use footage::dataset::cameras::PlacedCamera;
use serde_json::Value;
use tempfile::TempDir;

use crate::commands::{fine, refused};

/// Region of the courtyard with few candidates and surface points, so that a run takes tenths of a second.
const SMALL: &str =
    "place courtyard --region=-0.6,1.1,-0.6,0.6,1.9,0.6 --candidates 40 --surface-samples 400 --frames 0-3";

fn json(line: &str, folder: &Path) -> Value {
    serde_json::from_slice(&fine(line, folder).stdout).unwrap()
}

fn read(path: impl AsRef<Path>) -> CameraSet {
    CameraSet::read(path.as_ref()).unwrap()
}

#[test]
fn cameras_are_written_and_what_they_cover_is_told() {
    let folder = TempDir::new().unwrap();
    let report = json(&format!("{SMALL} --cameras 3 -o cameras.json --json"), folder.path());
    let set = read(folder.path().join("cameras.json"));
    assert_eq!(set.cameras.len(), 3);
    let told = report["cameras"].as_array().unwrap();
    for (at, (camera, told)) in set.cameras.iter().zip(told).enumerate() {
        assert_eq!(told["name"], set.name_of(at));
        assert_eq!(told["position"], serde_json::json!(camera.position));
        assert_eq!(told["gain"].as_f64(), camera.gain);
        assert_eq!(told["coverage"].as_f64(), camera.coverage);
        let [x, y, z] = camera.position;
        assert!(x.abs() <= 0.6 && (1.1..=1.9).contains(&y) && z.abs() <= 0.6);
    }
    assert!(report["coverage"].as_f64().unwrap() > 0.3, "{report}");
    assert!(report["coverage"].as_f64() <= report["reachable"]["coverage"].as_f64());
    assert_eq!(report["frames_looked_at"], serde_json::json!([0, 1, 2, 3]));
    for key in [
        "objective_calls",
        "bound_calls",
        "plain_objective_calls",
        "seconds",
        "candidates",
        "surface_samples",
        "k_per_m",
    ] {
        assert!(report[key].is_number(), "{key}");
    }
    assert_eq!(set.extra.unwrap()["placed_for"]["scene"], "courtyard");
    // The table lists the same cameras, and standard output has the same file.
    let text = String::from_utf8(fine(&format!("{SMALL} --cameras 3 -o again.json"), folder.path()).stdout).unwrap();
    assert!(text.contains("Coverage") && text.contains("again.json"), "{text}");
    // The column is in percent of the reachable coverage.
    let of_reachable = format!("{:.2}", 100.0 * report["coverage_of_reachable"].as_f64().unwrap());
    let last = text.lines().find(|line| line.trim_start().starts_with("02 ")).unwrap();
    assert_eq!(last.split_whitespace().nth(5), Some(of_reachable.as_str()), "{text}");
    let piped = fine(&format!("{SMALL} --cameras 3 -q -o -"), folder.path());
    let written = fs::read(folder.path().join("cameras.json")).unwrap();
    assert!(piped.stdout == written && piped.stderr.is_empty());
    assert!(fs::read(folder.path().join("again.json")).unwrap() == written);
}

#[test]
fn threads_do_not_change_the_file() {
    let folder = TempDir::new().unwrap();
    let bytes = |threads: &str| {
        fine(&format!("{SMALL} --lighting specular --cameras 4 --threads {threads} -o {threads}.json"), folder.path());
        fs::read(folder.path().join(format!("{threads}.json"))).unwrap()
    };
    let one = bytes("1");
    assert!(one == bytes("2") && one == bytes("7"));
}

#[test]
fn a_set_is_gone_on_with_and_measured() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    fine(&format!("{SMALL} --cameras 5 -o whole.json"), folder.path());
    fine(&format!("{SMALL} --cameras 2 -o some.json"), folder.path());
    let told = json(&format!("{SMALL} --cameras 3 --start some.json -o rest.json --json"), folder.path());
    assert_eq!(read(at("rest.json")), read(at("whole.json")));
    let given: Vec<bool> =
        told["cameras"].as_array().unwrap().iter().map(|camera| camera["given"].as_bool().unwrap()).collect();
    assert_eq!(given, [true, true, false, false, false]);
    fine(&format!("{SMALL} --cameras 0 --start some.json -o same.json"), folder.path());
    assert_eq!(read(at("same.json")).cameras, read(at("some.json")).cameras);
    // Existing cameras keep their names, and new names differ from them.
    let named = r#"{"lightfold_cameras": 1, "cameras": [
        {"name": "01", "position": [0, 1.5, 0]}, {"name": "left", "position": [-0.3, 1.5, 0]}]}"#;
    fs::write(at("named.json"), named).unwrap();
    fine(&format!("{SMALL} --cameras 3 --start named.json -o more.json"), folder.path());
    let set = read(at("more.json"));
    let names: Vec<String> = (0..5).map(|at| set.name_of(at)).collect();
    assert_eq!(names, ["01", "left", "02", "03", "04"]);
    // Existing names also stay when numbers need three digits.
    let many = CameraSet::new(vec![PlacedCamera::at([0.0, 1.5, 0.0]); 99]);
    fs::write(at("many.json"), many.to_json().unwrap()).unwrap();
    fine(&format!("{SMALL} --cameras 3 --start many.json -q -o more.json"), folder.path());
    let set = read(at("more.json"));
    let names: Vec<String> = (0..102).map(|at| set.name_of(at)).collect();
    assert_eq!(
        (names[0].as_str(), names[98].as_str(), &names[99..]),
        ("00", "98", &["99", "100", "101"].map(String::from)[..])
    );
}

#[test]
fn charts_and_rows_have_both_kinds_of_lighting() {
    let folder = TempDir::new().unwrap();
    let line = format!("{SMALL} --cameras 4 --plot charts --csv rows.csv -o cameras.json --json");
    let report = json(&line, folder.path());
    for name in ["coverage.svg", "coverage.png", "convergence.svg", "convergence.png"] {
        assert!(folder.path().join("charts").join(name).is_file(), "{name}");
    }
    assert_eq!(report["files"].as_array().unwrap().len(), 6);
    let curves = report["convergence"].as_array().unwrap();
    let last = |at: usize| curves[at]["coverage"].as_array().unwrap().last().unwrap().as_f64().unwrap();
    assert_eq!([&curves[0]["lighting"], &curves[1]["lighting"]], ["diffuse", "specular"]);
    assert!(last(0) > last(1) && last(1) > 0.0);
    let rows = fs::read_to_string(folder.path().join("rows.csv")).unwrap();
    assert!(
        rows.starts_with("lighting,camera,started,x,y,z,gain,coverage,seen,weighted,within,k_per_m\ndiffuse,0,"),
        "{rows}"
    );
    assert_eq!(rows.lines().count(), 1 + 4 + 4);
}

#[test]
fn what_makes_no_sense_is_said_in_a_sentence() {
    let folder = TempDir::new().unwrap();
    let said = |more: &str| {
        let words = refused(&format!("place courtyard {more}"), folder.path());
        assert!(!folder.path().join("c.json").exists());
        assert!(words.trim_end().lines().count() <= 6, "{words}");
        words
    };
    let region = "--region=-0.3,1.3,-0.3,0.3,1.7,0.3 --candidates 8 --surface-samples 64 -o c.json";
    assert!(said("--region 1,2,3 -o c.json").contains("x0,y0,z0,x1,y1,z1"));
    assert!(
        said("--region sphere:0,2.3,6,0.2 --candidates 8 --surface-samples 64 -o c.json").contains("no free space")
    );
    assert!(said(&format!("{region} --theta 30")).contains("--lighting specular"));
    assert!(said(&format!("{region} --lighting specular --theta 0")).contains("--cameras"));
    assert!(said(&format!("{region} --lighting specular --theta 0 --cameras 2 --until 0.1")).contains("--cameras"));
    assert!(said(&format!("{region} --lighting specular --theta 181")).contains("0 to 180"));
    // The search does not end for so small an angle, so a number of cameras is required.
    assert!(said(&format!("{region} --lighting specular --theta 0.9")).contains("--cameras"));
    fine(&format!("place courtyard {region} --lighting specular --theta 0.9 --cameras 2"), folder.path());
    fs::remove_file(folder.path().join("c.json")).unwrap();
    assert!(said(&format!("{region} --cameras 0")).contains("--start"));
    assert!(said(&format!("{region} --uniform 2 --cameras 2")).contains("--cameras"));
    assert!(said(&format!("{region} --compare-k 1,2")).contains("--plot"));
    assert!(said(&format!("{region} --until 1")).contains("no camera was placed"));
    assert!(said(&format!("{region} --start missing.json")).contains("missing.json"));
    assert!(said(&format!("{region} --k=-1")).contains("0 or more"));
    assert!(said("--region=-0.3,1.3,-0.3,0.3,1.7,0.3 --json -o -").contains("standard output"));
    assert!(refused("place nowhere.glb --region 0,0,0,1,1,1 -o c.json", folder.path()).contains("nowhere.glb"));
    fine(&format!("place courtyard {region} --lighting specular --theta 0 --cameras 2"), folder.path());
}

#[test]
fn a_search_without_an_end_stops_at_a_thousand_cameras() {
    let folder = TempDir::new().unwrap();
    let line = "place cornell --region=-0.9,0.1,-0.9,0.9,1.9,0.9 --lighting specular --theta 1 --until 0 --effort fast \
                --candidates 1100 --surface-samples 64 -o c.json";
    let done = fine(line, folder.path());
    assert_eq!(read(folder.path().join("c.json")).cameras.len(), 1000);
    assert!(String::from_utf8_lossy(&done.stderr).contains("stopped after 1000 cameras"));
}

#[test]
fn cameras_are_spread_without_a_search_and_measured() {
    let folder = TempDir::new().unwrap();
    let report = json(&format!("{SMALL} --uniform 6 -o even.json --json"), folder.path());
    let set = read(folder.path().join("even.json"));
    assert_eq!(set.cameras.len(), 6);
    for (at, camera) in set.cameras.iter().enumerate() {
        let [x, y, z] = camera.position;
        assert!(x.abs() <= 0.6 && (1.1..=1.9).contains(&y) && z.abs() <= 0.6);
        assert_eq!(report["cameras"][at]["given"], false);
        assert!(camera.coverage.unwrap() > 0.0);
    }
    assert_eq!(report["objective_calls"], 0);
    // Their coverage equals that of the same cameras given with `--start`.
    let measured = json(&format!("{SMALL} --cameras 0 --start even.json -o same.json --json"), folder.path());
    assert_eq!(measured["coverage"], report["coverage"]);
    // New cameras follow those of `--start`.
    json(&format!("{SMALL} --uniform 2 --start even.json -o more.json --json"), folder.path());
    assert_eq!(read(folder.path().join("more.json")).cameras[..6], set.cameras[..]);
}

#[test]
fn each_k_has_its_rows_and_its_lines() {
    let folder = TempDir::new().unwrap();
    let line = format!("{SMALL} --cameras 3 --compare-k 0.1,4 --plot charts --csv rows.csv -o cameras.json --json");
    let report = json(&line, folder.path());
    assert!(folder.path().join("charts/decay.svg").is_file() && folder.path().join("charts/decay.png").is_file());
    let curves = report["decay"].as_array().unwrap();
    assert_eq!([&curves[0]["k_per_m"], &curves[1]["k_per_m"]].map(|k| k.as_f64().unwrap()), [0.1, 4.0]);
    let last = |curve: &Value, key: &str| curve[key].as_array().unwrap().last().unwrap().as_f64().unwrap();
    assert!(last(&curves[0], "weighted") > last(&curves[1], "weighted"));
    let rows = fs::read_to_string(folder.path().join("rows.csv")).unwrap();
    assert_eq!(rows.lines().filter(|row| row.ends_with(",4.0")).count(), 3, "{rows}");
    // The written cameras are those of the default k.
    fine(&format!("{SMALL} --cameras 3 -o alone.json"), folder.path());
    assert!(read(folder.path().join("alone.json")) == read(folder.path().join("cameras.json")));
}

#[test]
fn the_table_says_what_is_compared_and_a_lost_region_is_told() {
    let folder = TempDir::new().unwrap();
    let text = |more: &str| {
        let done = fine(&format!("{SMALL} --cameras 2 -o c.json {more}"), folder.path());
        String::from_utf8(done.stdout).unwrap() + &String::from_utf8(done.stderr).unwrap()
    };
    let compared = text("--lighting specular --csv rows.csv");
    let [first, second] = [compared.find("specular").unwrap(), compared.find("diffuse").unwrap()];
    assert!(
        first < second && compared[second..].contains("not written") && !compared[..second].contains("not written")
    );
    // Specular coverage counts directions and diffuse coverage counts area, so the columns of area, except `Seen`, are only in
    // the diffuse table.
    assert!(!compared[..second].contains("Weighted") && compared[second..].contains("Weighted"), "{compared}");
    assert!(!text("--threads 1").contains("check --region"));
    let far = "place cornell --region=500,1,500,501,2,501 --candidates 1 --surface-samples 64 --cameras 1 -o far.json";
    let said = fine(far, folder.path());
    let words = String::from_utf8(said.stderr).unwrap();
    assert!(words.contains("from the scene") && words.contains("check --region"), "{words}");
    assert!(String::from_utf8(said.stdout).unwrap().contains("1 candidate, 64 points"));
}

/// Returns the number of cameras with which a curve reaches 90% of the reachable coverage; the length of the curve plus 1 if it
/// does not.
fn converged(curve: &Value) -> usize {
    let enough = 0.9 * curve["reachable"]["coverage"].as_f64().unwrap();
    let coverage = curve["coverage"].as_array().unwrap();
    coverage.iter().position(|share| share.as_f64().unwrap() >= enough).unwrap_or(coverage.len()) + 1
}

/// Checks CALF, figure 4: diffuse surfaces need fewer cameras than specular ones, and surfaces that are hidden from everywhere,
/// at least the fraction `hidden`, stay uncovered.
fn has_the_order_of_figure_4(scene: &str, region: &str, hidden: f64, few: u64) {
    let folder = TempDir::new().unwrap();
    let line = format!(
        "place {scene} --region={region} --effort fast --cameras 24 --plot charts -o cameras.json --json --quiet"
    );
    let report = json(&line, folder.path());
    let curves = report["convergence"].as_array().unwrap();
    let [diffuse, specular] = [&curves[0], &curves[1]];
    assert!(converged(diffuse) < converged(specular), "{scene}: {report}");
    let pairs = diffuse["coverage"].as_array().unwrap().iter().zip(specular["coverage"].as_array().unwrap());
    assert!(pairs.clone().count() > 8 && pairs.clone().all(|(a, b)| a.as_f64() > b.as_f64()), "{scene}: {report}");
    let seen = diffuse["reachable"]["seen"].as_f64().unwrap();
    assert!(seen <= 1.0 - hidden && report["coverage"].as_f64().unwrap() <= seen, "{scene}: {seen}");
    // Most gains are not computed, even in so few rounds and if each camera sees nearly everything.
    for curve in curves {
        asks_a_part(curve, few, scene);
    }
}

/// Checks that the search calls the objective at most once for every `few` calls of the plain search.
fn asks_a_part(report: &Value, few: u64, scene: &str) {
    let [lazy, plain] = ["objective_calls", "plain_objective_calls"].map(|key| report[key].as_u64().unwrap());
    assert!(few * lazy <= plain, "{scene}: {lazy} of {plain}");
    assert!(report["bound_calls"].as_u64().unwrap() > 0);
}

/// Writes an OBJ file of a closed box around a smaller one and returns its path. The outer box has a slit in one side, and the
/// inner box is visible only through it.
fn box_in_a_box(folder: &Path) -> String {
    let mut text = String::new();
    let mut corners = 0;
    let mut quad = |points: [[f64; 3]; 4]| {
        points.iter().for_each(|[x, y, z]| text += &format!("v {x} {y} {z}\n"));
        text += &format!("f {} {} {} {}\n", corners + 1, corners + 2, corners + 3, corners + 4);
        corners += 4;
    };
    let mut sides = |half: f64, has_slit: bool| {
        for axis in 0..3 {
            for sign in [-1.0, 1.0] {
                // A side in one piece, or two strips that leave a tenth of it open.
                let strips: &[[f64; 2]] =
                    if has_slit && axis == 2 && sign > 0.0 { &[[-1.0, -0.1], [0.1, 1.0]] } else { &[[-1.0, 1.0]] };
                for [from, to] in strips {
                    let at = |u: f64, v: f64| {
                        let mut point = [0.0; 3];
                        point[axis] = sign * half;
                        point[(axis + 1) % 3] = sign * u * half;
                        point[(axis + 2) % 3] = v * half;
                        point
                    };
                    quad([at(*from, -1.0), at(*to, -1.0), at(*to, 1.0), at(*from, 1.0)]);
                }
            }
        }
    };
    sides(1.0, true);
    sides(0.6, false);
    let path = folder.join("boxes.obj");
    fs::write(&path, text).unwrap();
    path.display().to_string()
}

#[test]
fn a_box_in_a_box_stays_hidden_and_has_the_order_of_figure_4() {
    let folder = TempDir::new().unwrap();
    // The inner box has 8.64 of 32.2 square metres, and little more than one of its sides is visible.
    has_the_order_of_figure_4(&box_in_a_box(folder.path()), "-3,-3,-3,3,3,3", 0.1, 4);
}

#[test]
fn a_box_with_blocks_has_the_order_of_figure_4() {
    // The floor under the blocks and the back of the lamp are hidden.
    has_the_order_of_figure_4("cornell", "-0.9,0.1,-0.9,0.9,1.9,0.9", 0.01, 4);
    // If the search runs until gains are small, a tenth of the calls is enough.
    let folder = TempDir::new().unwrap();
    let line = "place cornell --region=-0.9,0.1,-0.9,0.9,1.9,0.9 --effort fast -o cameras.json --json --quiet";
    asks_a_part(&json(line, folder.path()), 10, "cornell");
}

#[test]
#[cfg_attr(not(footage_at_hand), ignore = "no footage at hand: see LIGHTFOLD_DATA in CONTRIBUTING.md")]
fn a_dragon_has_the_order_of_figure_4_and_asks_a_tenth() {
    let dragon = format!("{}/meshes/dragon.glb", option_env!("LIGHTFOLD_DATA").unwrap_or("no data"));
    let dragon = Path::new(&dragon).canonicalize().unwrap().display().to_string();
    has_the_order_of_figure_4(&dragon, "-2,-2,-2,2,2,2", 0.002, 4);
    let folder = TempDir::new().unwrap();
    let line = format!("place {dragon} --region=-2,-2,-2,2,2,2 --cameras 8 -o cameras.json --json --quiet");
    asks_a_part(&json(&line, folder.path()), 10, "dragon");
}
