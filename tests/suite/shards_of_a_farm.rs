//! `scan`, `encode --shard` and `pack` as a render farm runs them.

use std::fs;

use crate::commands::{fine, lightfold, refused};
use crate::resume_footage::dataset;

#[test]
fn a_farm_writes_the_bytes_of_one_machine() {
    let footage = dataset();
    let folder = footage.folder.path();
    fine("encode . --clip -o one.lfold --depth-codec quadtree --keyframe-interval 3", folder);
    let one = fs::read(folder.join("one.lfold")).unwrap();
    for number in 1..=3 {
        fine(&format!("scan . --shard {number}/3 -o scan-{number}.json"), folder);
    }
    let message = refused("encode . --clip --scan scan-2.json -o no.lfold", folder);
    assert!(message.contains("scan-2.json") && message.contains("merge them"), "{message}");
    let message = refused("scan --merge scan-1.json scan-3.json -o scan.json", folder);
    assert!(message.contains("no scan has frames 1") && message.contains("of probe "), "{message}");
    assert!(!folder.join("scan.json").exists());
    fine("scan --merge scan-3.json scan-1.json scan-2.json scan-1.json -o scan.json", folder);
    fine("scan . -o all.json", folder);
    assert_eq!(fs::read(folder.join("scan.json")).unwrap(), fs::read(folder.join("all.json")).unwrap());
    fine("scan . -o scan-1.json --resume", folder);
    assert_eq!(fs::read(folder.join("scan-1.json")).unwrap(), fs::read(folder.join("all.json")).unwrap());
    let options = "--clip --depth-codec quadtree --keyframe-interval 3";
    for (by, count, scan) in
        [("auto", 7, " --scan scan.json"), ("time", 3, ""), ("stream", 12, " --scan scan.json"), ("probe", 2, "")]
    {
        let mut names = Vec::new();
        for number in (1..=count).rev() {
            let name = format!("{by}-{number}.lfold");
            fine(&format!("encode . {options} --shard {number}/{count} --shard-by {by}{scan} -o {name}"), folder);
            names.push(name);
        }
        fine(&format!("pack {} {} -o joined.lfold", names.join(" "), names[0]), folder);
        assert!(fs::read(folder.join("joined.lfold")).unwrap() == one, "{count} shards by {by} join to other bytes");
        let message = refused(&format!("pack {} -o joined.lfold", names[1..].join(" ")), folder);
        assert!(message.contains(&format!("shard {count} of {count} is missing")), "{message}");
    }
    let message = refused("encode . --clip --shard 1/99 --shard-by stream -o no.lfold", folder);
    assert!(message.contains("at most 12 shards") && message.contains("--shard-by"), "{message}");
    let message = refused("encode . --clip --shard 4/3 -o no.lfold", folder);
    assert!(message.contains("a shard I/N with I from 1 to N was expected"), "{message}");
    assert!(!folder.join("no.lfold").exists());
}

#[test]
fn scans_that_have_not_ended_may_be_merged_later() {
    let footage = dataset();
    let folder = footage.folder.path();
    // `scan` accepts the options of `encode`, some of which do not affect it.
    fine("scan . -o scan.json --clip --depth-codec quadtree --psnr 45 --lzma2=1 --preset small", folder);
    let whole = fs::read(folder.join("scan.json")).unwrap();
    let mut scan: serde_json::Value = serde_json::from_slice(&whole).unwrap();
    scan["parts"].as_array_mut().unwrap().pop();
    scan["is_unfinished"] = true.into();
    fs::write(folder.join("part.json"), scan.to_string()).unwrap();
    let early = lightfold(&["scan", "--merge", "part.json", "-o", "merged.json"], folder);
    let said = String::from_utf8(early.stderr).unwrap();
    assert_eq!(early.status.code(), Some(75), "{said}");
    assert!(said.contains("part.json: this scan is unfinished, and no scan has frames 13-19 of "), "{said}");
    assert!(said.contains(" of probe b, face "), "{said}");
    assert!(!folder.join("merged.json").exists());
    for (words, is_said) in [("nothing to scan", false), ("nothing to scan", true)] {
        let said = String::from_utf8(fine("scan . -o part.json --resume", folder).stderr).unwrap();
        assert_eq!(said.contains(words), is_said, "{said}");
        assert!(fs::read(folder.join("part.json")).unwrap() == whole, "other bytes");
    }
    fine("scan --merge part.json -o merged.json", folder);
    assert!(fs::read(folder.join("merged.json")).unwrap() == whole, "other bytes");
}

#[test]
fn a_shard_that_is_complete_is_not_encoded_again() {
    let footage = dataset();
    let folder = footage.folder.path();
    let file = folder.join("a.lfold");
    let line = "encode . --clip --shard 2/3 --resume --json -o a.lfold";
    // Returns whether the shard was already complete, and its report without times.
    let run = |line: &str| {
        let done = fine(line, folder);
        let mut report: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
        let is_complete = report["coding_thread_seconds"] == 0.0;
        for key in [
            "seconds",
            "reading_thread_seconds",
            "scanning_thread_seconds",
            "coding_thread_seconds",
            "peak_memory_bytes",
            "resumed_chunks",
        ] {
            report.as_object_mut().unwrap().remove(key);
        }
        (is_complete, report)
    };
    let (is_complete, report) = run(line);
    let (bytes, written) = (fs::read(&file).unwrap(), fs::metadata(&file).unwrap().modified().unwrap());
    assert!(!is_complete);
    assert_eq!(run(line), (true, report.clone()));
    let said = String::from_utf8(fine(&line.replace(" --json", ""), folder).stderr).unwrap();
    assert!(said.contains("a.lfold: this shard is complete; nothing to encode"), "{said}");
    assert_eq!(fs::metadata(&file).unwrap().modified().unwrap(), written, "it was written again");
    // The shard is encoded again if its file is truncated, if images are newer than the shard, or without --resume.
    fs::write(&file, &bytes[..bytes.len() - 1]).unwrap();
    assert_eq!(run(line), (false, report.clone()));
    for face in ["px", "ny"] {
        let image = folder.join(format!("b/{face}/c.0015.exr"));
        fs::write(&image, fs::read(&image).unwrap()).unwrap();
    }
    assert_eq!(run(line), (false, report.clone()));
    assert_eq!(run(line), (true, report.clone()));
    assert_eq!(run(&line.replace(" --resume", "")), (false, report));
    assert!(fs::read(&file).unwrap() == bytes, "other bytes");
    // Another shard and other settings are encoded again.
    for (from, to) in [("2/3", "1/3"), ("2/3", "3/3"), ("--clip", "--clip --psnr 30")] {
        assert!(!run(&line.replace(from, to)).0, "{to}");
        assert!(!run(line).0, "after {to}");
    }
}

#[test]
fn a_studio_says_what_a_shard_has() {
    let footage = dataset();
    let folder = footage.folder.path();
    let options = "encode . --clip --depth-codec quadtree --keyframe-interval 3";
    fine(&format!("{options} -o one.lfold"), folder);
    for (number, choice) in [
        (1, "--shard-stream color"),
        (2, "--shard-stream depth,material --shard-frames 10-15"),
        (3, "--shard-stream depth,material --shard-frames 16-20"),
    ] {
        fine(&format!("{options} --shard {number}/3 {choice} -o {number}.lfold"), folder);
    }
    fine("pack 2.lfold 3.lfold 1.lfold -o joined.lfold", folder);
    let read = |name: &str| fs::read(folder.join(name)).unwrap();
    assert!(read("joined.lfold") == read("one.lfold"), "other bytes");
    // An output may not replace the dataset or an input scan.
    for line in ["scan . -o lightfield.json", "encode . --shard 1/2 --clip --scan all.json -o all.json"] {
        fine("scan . -o all.json", folder);
        assert!(refused(line, folder).contains("an input file would be overwritten"), "{line}");
    }
    // Shards with the same streams, in addition to others, overlap in any order.
    fine(&format!("{options} --shard 1/3 --shard-stream color,depth -o more.lfold"), folder);
    for (inputs, other) in [("1.lfold more.lfold", "1.lfold"), ("more.lfold 2.lfold", "2.lfold")] {
        let line = format!("pack {inputs} -o joined.lfold");
        let output = lightfold(&line.split(' ').collect::<Vec<_>>(), folder);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains("shards must not overlap"), "{said}");
        assert!(said.contains(other), "{said}");
    }
    let said = refused(&format!("{options} --shard 1/2 --shard-frames 10-14 --shard-stream depth -o no.lfold"), folder);
    assert!(said.contains("--shard-frames 10-14: depth of probe a can end at frame 12 or 15, not at 14"), "{said}");
    refused(&format!("{options} --shard-frames 10-15 -o no.lfold"), folder);
    refused(&format!("{options} --shard 1/2 --shard-by time --shard-probe a -o no.lfold"), folder);
}
