//! `scan`, `encode --shard` and `pack` as a farm runs them.

use std::fs;

use crate::commands::{fine, refused};
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
    assert!(message.contains("write I/N with I from 1 to N"), "{message}");
    assert!(!folder.join("no.lfold").exists());
}
