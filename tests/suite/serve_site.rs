//! `lightfold view --export`: the static site.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use crate::commands::{fine, lightfold, refused};
use crate::serve::{bytes_below, place, player, write_glb};

fn names(folder: &Path) -> BTreeSet<String> {
    fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
}

fn described(site: &Path) -> Value {
    serde_json::from_slice(&fs::read(site.join("film.json")).unwrap()).unwrap()
}

#[test]
fn a_site_has_the_page_and_the_film_and_replaces_an_earlier_one() {
    let folder = place();
    let (at, site) = (folder.path(), folder.path().join("deep/site"));
    let film = fs::read(at.join("a.lfold")).unwrap();
    let output = fine("view a.lfold --export deep/site --json", at);
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let expected = json!({"kind": "lfold", "url": "film.lfold", "name": "a.lfold", "bytes": film.len()});
    assert_eq!(described(&site), expected);
    assert_eq!(fs::read(site.join("film.lfold")).unwrap(), film);
    let files = player();
    for (name, path) in &files {
        assert_eq!(fs::read(site.join(name)).unwrap(), fs::read(path).unwrap(), "{name}");
    }
    let bytes = bytes_below(&site);
    assert_eq!(report["site"], json!({"path": "deep/site", "files": files.len() + 2, "bytes": bytes}));
    assert_eq!(names(&at.join("deep")), BTreeSet::from(["site".to_owned()]));
    // Another film replaces the first.
    let before = names(&site);
    write_glb(&at.join("b.glb"), 50_000);
    fine("view b.glb --export deep/site", at);
    assert_eq!(described(&site)["url"], "film.glb");
    assert_eq!(fs::read(site.join("film.glb")).unwrap(), fs::read(at.join("b.glb")).unwrap());
    let mut after = before;
    assert!(after.remove("film.lfold") && after.insert("film.glb".to_owned()));
    assert_eq!(names(&site), after);
    // A film of the site can be exported to the same site.
    fine("view deep/site/film.glb --export deep/site", at);
    assert_eq!(fs::read(site.join("film.glb")).unwrap(), fs::read(at.join("b.glb")).unwrap());
}

#[test]
fn folders_of_something_else_are_left_alone() {
    let folder = place();
    let at = folder.path();
    for (name, files) in [("other", &["film.lfold"][..]), ("described", &["film.json"]), ("hidden", &[".x"])] {
        fs::create_dir(at.join(name)).unwrap();
        for file in files {
            fs::write(at.join(name).join(file), "{\"url\": \"other\"}").unwrap();
        }
        let said = refused(&format!("view a.lfold --export {name}"), at);
        assert!(said.contains("the folder has other files"), "{said}");
        assert_eq!(names(&at.join(name)), files.iter().map(|file| (*file).to_owned()).collect(), "{name}");
    }
    fine("view a.lfold --export mixed", at);
    let before = names(&at.join("mixed"));
    for name in ["film.png", "notes.txt"] {
        fs::write(at.join("mixed").join(name), "mine").unwrap();
        assert!(refused("view a.lfold --export mixed", at).contains(&format!("other files ({name})")));
        fs::remove_file(at.join("mixed").join(name)).unwrap();
    }
    fs::write(at.join("mixed/film.json"), "{\"url\": \"film.lfold\", \"x\": 1}").unwrap();
    assert!(refused("view a.lfold --export mixed", at).contains("other files"));
    assert_eq!(names(&at.join("mixed")), before);
    assert!(refused("view a.lfold --export a.lfold", at).contains("a file, where a folder was expected"));
    assert!(refused("view a.lfold --export .", at).contains("the folder has other files"));
    fs::create_dir(at.join("empty")).unwrap();
    fine("view a.lfold --export empty", at);
    assert!(at.join("empty/index.html").is_file());
}

#[test]
fn a_damaged_film_is_not_exported() {
    let folder = place();
    let at = folder.path();
    let whole = fs::read(at.join("a.lfold")).unwrap();
    fine("view a.lfold --export earlier", at);
    let earlier = names(&at.join("earlier"));
    let mut refused = 0;
    for place in (0..whole.len()).step_by(97) {
        let mut other = whole.clone();
        other[place] ^= 0x10;
        fs::write(at.join("b.lfold"), &other).unwrap();
        let verified = lightfold(&["inspect", "b.lfold", "--verify"], at).status.success();
        for to in ["new", "earlier"] {
            let output = lightfold(&["view", "b.lfold", "--export", to, "--json"], at);
            let said = String::from_utf8(output.stderr).unwrap();
            if verified {
                assert!(output.status.success(), "byte {place}: {said}");
                fs::remove_dir_all(at.join("new")).unwrap();
                break;
            }
            let report: Value = serde_json::from_slice(&output.stdout).unwrap();
            let code = output.status.code();
            // Damage to the first 8 bytes, which identify the file type, may have another exit code.
            assert!(code == Some(1) || place < 8, "byte {place}: {said}");
            assert!(said.contains("b.lfold: "), "byte {place}: {said}");
            assert_eq!(report["error"]["code"].as_i64(), code.map(i64::from), "byte {place}");
            refused += 1;
        }
        assert!(!at.join("new").exists(), "byte {place}");
        assert_eq!(names(&at.join("earlier")), earlier, "byte {place}");
    }
    assert_eq!(fs::read(at.join("earlier/film.lfold")).unwrap(), whole);
    assert!(refused > 10, "{refused}");
    assert!(names(at).iter().all(|name| !name.contains("partial")), "{:?}", names(at));
}
