//! Interrupted encodes, run as processes: signals, full disks, two encodes of one output, and their messages.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use codec::monitor::Silent;
use scene::{DemoKind, FootagePlan};
use tempfile::TempDir;

use crate::commands::fine;

const FRAMES: u32 = 40;

/// Folder with a dataset and an output folder, and an encode of many small chunks.
struct Place {
    folder: TempDir,
}

impl Place {
    fn new() -> Place {
        let folder = TempDir::new().unwrap();
        let plan = FootagePlan { kind: DemoKind::Courtyard, frames: FRAMES, face_size: 64, probes: 2 };
        plan.write(&folder.path().join("scene"), &Silent).unwrap();
        fs::create_dir(folder.path().join("out")).unwrap();
        Place { folder }
    }

    fn out(&self) -> PathBuf {
        self.folder.path().join("out")
    }

    fn encode(&self, more: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lightfold"));
        command.current_dir(self.folder.path()).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command
            .args(["encode", "scene", "--clip", "-o", "out/a.lfold", "--keyframe-interval", "2", "--threads", "1"])
            .args(more);
        command
    }

    fn run(&self, more: &[&str]) -> Output {
        self.encode(more).output().unwrap()
    }

    fn names(&self) -> Vec<String> {
        let mut names: Vec<_> =
            fs::read_dir(self.out()).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// Starts an encode and stops it with SIGSTOP after it has completed chunks, but before it ends. The process holds its locks
    /// until it is continued or killed.
    #[cfg(unix)]
    fn at_work(&self, more: &[&str]) -> Child {
        assert_eq!(self.chunks_in_journal(), 0);
        let mut child = self.encode(more).spawn().unwrap();
        assert!(self.waits_for_chunks(&mut child, 1), "it ended too soon");
        signal(&child, "-STOP");
        assert_eq!(self.names(), STATE, "it ended too soon");
        child
    }

    /// Waits until the journal has `count` chunks. Returns false if the encode ends first.
    fn waits_for_chunks(&self, child: &mut Child, count: usize) -> bool {
        let start = Instant::now();
        while self.chunks_in_journal() < count {
            if child.try_wait().unwrap().is_some() {
                return false;
            }
            assert!(start.elapsed() < Duration::from_secs(120), "it did not begin");
            std::thread::sleep(Duration::from_micros(300));
        }
        true
    }

    /// Counts the complete chunk records of the journal; src/codec/container/journal.rs has their layout.
    fn chunks_in_journal(&self) -> usize {
        let bytes = fs::read(self.out().join(".a.lfold.journal")).unwrap_or_default();
        let (mut rest, mut count) = (bytes.get(8..).unwrap_or_default(), 0);
        while let Some(length) = rest.first_chunk().map(|length| u32::from_le_bytes(*length) as usize) {
            let Some(next) = rest.get(9 + length..) else { break };
            count += usize::from(rest[8] == 1);
            rest = next;
        }
        count
    }

    fn whole(&self) -> Vec<u8> {
        let done = self.run(&[]);
        assert!(done.status.success(), "{}", said(&done));
        let file = self.out().join("a.lfold");
        let bytes = fs::read(&file).unwrap();
        fs::remove_file(file).unwrap();
        assert_eq!(self.names(), [""; 0]);
        bytes
    }

    /// Resumes the encode and checks that the file equals `whole`, that of an uninterrupted encode. Returns the messages.
    #[track_caller]
    fn finishes(&self, whole: &[u8]) -> String {
        let done = self.run(&["--resume"]);
        assert!(done.status.success(), "{}", said(&done));
        assert_eq!(self.names(), ["a.lfold"]);
        assert!(fs::read(self.out().join("a.lfold")).unwrap() == whole, "other bytes");
        fs::remove_file(self.out().join("a.lfold")).unwrap();
        said(&done)
    }
}

const STATE: [&str; 2] = [".a.lfold.journal", ".a.lfold.partial"];

fn said(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

fn end(mut child: Child) -> (Option<i32>, String) {
    let mut words = String::new();
    child.stderr.take().unwrap().read_to_string(&mut words).unwrap();
    (child.wait().unwrap().code(), words)
}

/// Parses the number of chunks from a message.
fn chunks(words: &str) -> u64 {
    let before = words.split(" chunk").next().unwrap();
    before.rsplit(|c: char| !c.is_ascii_digit()).next().unwrap().parse().unwrap_or_else(|_| panic!("{words}"))
}

/// Parses the number of resumed chunks, which an earlier run completed, from the messages.
fn taken_over(words: &str) -> u64 {
    let told =
        words.split([',', '\n']).find_map(|part| part.trim().trim_end_matches('s').strip_suffix(" resumed chunk"));
    told.and_then(|count| count.parse().ok()).unwrap_or_else(|| panic!("{words}"))
}

#[cfg(unix)]
fn signal(child: &Child, name: &str) {
    assert!(Command::new("kill").args([name, &child.id().to_string()]).status().unwrap().success());
}

#[test]
#[cfg(unix)]
fn signals_leave_what_is_complete_and_say_so() {
    let place = Place::new();
    let whole = place.whole();
    for (name, code) in [("-INT", Some(130)), ("-TERM", Some(130)), ("-KILL", None)] {
        let child = place.at_work(&[]);
        signal(&child, name);
        signal(&child, "-CONT");
        let (ended, words) = end(child);
        assert_eq!(ended, code, "{name}: {words}");
        assert_eq!(place.names(), STATE, "{name}");
        if code.is_some() {
            let expected = "lightfold: interrupted; safe in out/.a.lfold.partial: ";
            assert!(words.starts_with(expected), "{words}");
            assert!(words.ends_with("; the same command with --resume continues\n"), "{words}");
            assert_eq!(words.lines().count(), 1, "{words}");
            assert!(!words.contains("no unfinished file"), "{words}");
        }
        let resumed = place.finishes(&whole);
        assert!(resumed.contains("out/a.lfold: resuming after "), "{resumed}");
        assert!(taken_over(&resumed) > 0, "{resumed}");
        if code.is_some() {
            assert_eq!(chunks(&words), taken_over(&resumed), "{words}{resumed}");
        }
    }
}

#[test]
#[cfg(unix)]
fn a_killed_shard_resumes_and_all_join_to_the_same_bytes() {
    let place = Place::new();
    let whole = place.whole();
    let folder = place.folder.path();
    for shard in ["1/3", "2/3", "3/3"] {
        let is_killed = shard == "2/3";
        if is_killed {
            let child = place.at_work(&["--shard", shard]);
            signal(&child, "-KILL");
            assert_eq!(end(child).0, None);
            assert_eq!(place.names(), STATE);
        }
        let done = place.run(&["--shard", shard, "--resume"]);
        assert!(done.status.success(), "{}", said(&done));
        assert_eq!(said(&done).contains("resuming after "), is_killed, "{}", said(&done));
        fs::rename(place.out().join("a.lfold"), folder.join(format!("{}.lfold", &shard[..1]))).unwrap();
    }
    fine("pack 1.lfold 2.lfold 3.lfold -o joined.lfold", folder);
    assert!(fs::read(folder.join("joined.lfold")).unwrap() == whole, "other bytes");
}

#[cfg_attr(not(all_tests), ignore = "long: scripts/test all runs it")]
#[test]
#[cfg(unix)]
fn an_encode_is_killed_and_gone_on_with_many_times() {
    let place = Place::new();
    let whole = place.whole();
    let (mut kills, mut before) = (Vec::new(), 0);
    for round in 0..30 {
        let mut child = place.encode(&["--resume", "--quiet"]).spawn().unwrap();
        // Kill the encode 0 to 6 ms after it has more chunks than before; in every fifth round, without waiting for chunks.
        let at_work = round % 5 == 0 || place.waits_for_chunks(&mut child, before + 1 + round % 3 * 20);
        std::thread::sleep(Duration::from_millis((round * 37 % 7) as u64));
        let over = !at_work || child.try_wait().unwrap().is_some();
        if !over {
            child.kill().unwrap();
        }
        let (code, words) = end(child);
        assert!(code == Some(0) || !over, "{words}");
        let file = place.out().join("a.lfold");
        if file.exists() {
            // The encode is done, but may have been killed before it removed its journal.
            assert!(fs::read(&file).unwrap() == whole, "round {round}: other bytes");
            fs::remove_file(&file).unwrap();
            let _ = fs::remove_file(place.out().join(STATE[0]));
            assert_eq!(place.names(), [""; 0], "round {round}");
            before = 0;
            continue;
        }
        let now = place.chunks_in_journal();
        assert!(now >= before, "round {round}: {before} chunks were complete, {now} are");
        before = now;
        kills.push(now);
    }
    place.finishes(&whole);
    let with_chunks = kills.iter().filter(|&&chunks| chunks > 0).count();
    kills.sort_unstable();
    kills.dedup();
    assert!(with_chunks >= 10 && kills.len() >= 5, "{with_chunks} kills with chunks: {kills:?}");
}

#[test]
#[cfg(unix)]
fn two_encodes_of_one_output_refuse_each_other() {
    let place = Place::new();
    let whole = place.whole();
    let child = place.at_work(&[]);
    for more in [&[][..], &["--resume"]] {
        let second = place.run(more);
        assert_eq!(second.status.code(), Some(75));
        let expected = "lightfold: out/a.lfold: another lightfold process is writing it, in out/.a.lfold.partial: \
                        wait for it, or use another file\n";
        assert_eq!(said(&second), expected);
    }
    // Another command cannot write the file either.
    let mut pack = Command::new(env!("CARGO_BIN_EXE_lightfold"));
    fs::write(place.folder.path().join("whole.lfold"), &whole).unwrap();
    let pack =
        pack.current_dir(place.folder.path()).args(["pack", "whole.lfold", "-o", "out/a.lfold"]).output().unwrap();
    assert!(said(&pack).contains("another lightfold process is writing it"), "{}", said(&pack));
    signal(&child, "-KILL");
    end(child);
    place.finishes(&whole);
}

#[cfg_attr(not(all_tests), ignore = "long: scripts/test all runs it")]
#[test]
#[cfg(unix)]
fn an_old_state_is_replaced_where_nobody_asks_for_it() {
    let place = Place::new();
    let whole = place.whole();
    let killed = |more: &[&str]| {
        let child = place.at_work(more);
        signal(&child, "-KILL");
        end(child);
    };
    killed(&[]);
    let anew = place.run(&[]);
    assert!(anew.status.success());
    let words = said(&anew);
    assert!(words.contains("; --resume would continue it\n"), "{words}");
    assert!(!words.contains("resumed"), "{words}");
    assert_eq!(place.names(), ["a.lfold"]);
    assert!(fs::read(place.out().join("a.lfold")).unwrap() == whole, "other bytes");
    // A finished file has no state to resume, so it is encoded again.
    let again = place.finishes(&whole);
    assert!(again.contains("nothing to resume; starting from the beginning"), "{again}");
    // The state of an encode with other settings is neither resumed nor removed.
    killed(&["--color-cell", "16"]);
    let before: Vec<_> = STATE.map(|name| fs::read(place.out().join(name)).unwrap()).into();
    let refused = place.run(&["--resume"]);
    assert_eq!(refused.status.code(), Some(2));
    let expected = "lightfold: out/a.lfold: cannot resume the unfinished encode: --color-cell was 16 and is 64 now: use its \
                    settings, or leave out --resume to start over\n";
    assert_eq!(said(&refused), expected);
    let after: Vec<_> = STATE.map(|name| fs::read(place.out().join(name)).unwrap()).into();
    let sound = |bytes: &[u8], of: &[u8]| of.starts_with(bytes) && !bytes.is_empty();
    assert!(sound(&after[0], &before[0]) && sound(&after[1], &before[1]), "the state was touched");
    // Another command that writes the same output removes the state.
    let mut pack = Command::new(env!("CARGO_BIN_EXE_lightfold"));
    fs::write(place.folder.path().join("whole.lfold"), &whole).unwrap();
    let pack =
        pack.current_dir(place.folder.path()).args(["pack", "whole.lfold", "-o", "out/a.lfold"]).output().unwrap();
    assert!(pack.status.success(), "{}", said(&pack));
    assert_eq!(place.names(), ["a.lfold"]);
}

#[test]
fn a_broken_frame_late_in_the_work_keeps_what_came_before_it() {
    let place = Place::new();
    let whole = place.whole();
    let frame = place.folder.path().join("scene");
    let frame = find(&frame, "color", "0020.exr");
    let pixels = fs::read(&frame).unwrap();
    fs::write(&frame, &pixels[..pixels.len() / 2]).unwrap();
    let stopped = place.run(&[]);
    let words = said(&stopped);
    assert_eq!(stopped.status.code(), Some(2), "{words}");
    assert!(words.contains("0020.exr: ") && words.contains("; safe in out/.a.lfold.partial: "), "{words}");
    assert_eq!(place.names(), STATE);
    fs::write(&frame, &pixels).unwrap();
    place.finishes(&whole);
    // Without a complete chunk no state is kept, and the message does not mention any.
    let first = find(&place.folder.path().join("scene"), "face_px/color", "0000.exr");
    fs::write(&first, "").unwrap();
    let stopped = place.run(&["--quiet"]);
    assert!(!said(&stopped).contains("safe"), "{}", said(&stopped));
    assert_eq!(place.names(), [""; 0]);
}

/// Returns the last file in path order whose path contains `kind` and ends with `end`; for frame 0, the first.
fn find(root: &Path, kind: &str, end: &str) -> PathBuf {
    let (mut found, mut folders) = (Vec::new(), vec![root.to_path_buf()]);
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.to_str().unwrap().contains(kind) && path.to_str().unwrap().ends_with(end) {
                found.push(path);
            }
        }
    }
    found.sort();
    if end.starts_with("0000") { found.remove(0) } else { found.pop().unwrap() }
}

#[test]
#[cfg(unix)]
fn resume_needs_a_file_that_can_be_gone_on_with() {
    let place = Place::new();
    let mut command = Command::new(env!("CARGO_BIN_EXE_lightfold"));
    command.current_dir(place.folder.path()).args(["encode", "scene", "--clip", "--resume", "-o"]);
    let pipe = command.arg("-").output().unwrap();
    assert_eq!(pipe.status.code(), Some(2));
    assert_eq!(said(&pipe), "lightfold: --resume needs a file: an encode to standard output cannot be resumed\n");
    let mut command = Command::new(env!("CARGO_BIN_EXE_lightfold"));
    let null =
        command.current_dir(place.folder.path()).args(["encode", "scene", "--clip", "--resume", "-o", "/dev/null"]);
    let null = null.output().unwrap();
    assert!(null.status.success() && said(&null).contains("nothing to resume"), "{}", said(&null));
    // A symbolic link at the path of the partial file is not followed.
    let (theirs, link) = (place.folder.path().join("theirs"), place.out().join(".a.lfold.partial"));
    fs::write(&theirs, "theirs").unwrap();
    std::os::unix::fs::symlink(&theirs, &link).unwrap();
    let refused = place.run(&[]);
    assert!(said(&refused).contains(".a.lfold.partial exists"), "{}", said(&refused));
    assert_eq!(fs::read(&theirs).unwrap(), b"theirs");
}

/// Runs an encode with `sh` in the folder of `place`, after the shell commands `before`.
#[cfg(unix)]
fn shell(place: &Place, before: &str, more: &str) -> Output {
    let line = format!(
        "{before} exec {} encode scene --clip -o out/a.lfold --keyframe-interval 2 --threads 1 {more}",
        env!("CARGO_BIN_EXE_lightfold")
    );
    Command::new("sh").current_dir(place.folder.path()).args(["-c", &line]).output().unwrap()
}

#[test]
#[cfg(unix)]
fn a_file_that_may_not_grow_is_told_with_what_is_safe() {
    let place = Place::new();
    let whole = place.whole();
    for share in [3, 2] {
        // `ulimit -f` counts blocks of 512 bytes.
        let limit = whole.len() / share / 512;
        let stopped = shell(&place, &format!("trap '' XFSZ; ulimit -f {limit};"), "");
        let words = said(&stopped);
        assert_eq!(stopped.status.code(), Some(2), "{words}");
        assert!(words.starts_with("lightfold: out/a.lfold: File too large (os error 27); safe in "), "{words}");
        assert!(chunks(&words) > 0, "{words}");
        assert_eq!(place.names(), STATE);
        // Under the same limit, the resumed encode stops as well.
        let again = shell(&place, &format!("trap '' XFSZ; ulimit -f {limit};"), "--resume --quiet");
        assert!(said(&again).contains("File too large"), "{}", said(&again));
        place.finishes(&whole);
    }
}

/// `scripts/test` runs this test where the system lets a user mount a file system.
#[test]
#[ignore = "mounts a disk (unshare -rm)"]
#[cfg(unix)]
fn a_full_disk_is_told_with_what_is_safe() {
    let place = Place::new();
    let whole = place.whole();
    let kilobytes = whole.len() * 2 / 3 / 1024;
    let binary = env!("CARGO_BIN_EXE_lightfold");
    // The state is copied to a disk with more free space, as a user would do.
    let script = format!(
        "mount -t tmpfs -o size={kilobytes}k none out && \
         {binary} encode scene --clip -o out/a.lfold --keyframe-interval 2 --threads 1; code=$?; \
         ls -A out >names; mkdir -p kept && cp -a out/. kept/; exit $code"
    );
    let mut stopped = Command::new("unshare");
    let stopped = stopped.args(["-rm", "sh", "-c", &script]).current_dir(place.folder.path()).output().unwrap();
    let words = said(&stopped);
    assert_eq!(stopped.status.code(), Some(75), "{words}");
    assert!(words.starts_with("lightfold: out/a.lfold: No space left on device (os error 28); safe in "), "{words}");
    assert_eq!(fs::read_to_string(place.folder.path().join("names")).unwrap(), STATE.join("\n") + "\n");
    for name in STATE {
        fs::copy(place.folder.path().join("kept").join(name), place.out().join(name)).unwrap();
    }
    let resumed = place.finishes(&whole);
    assert_eq!(chunks(&words), taken_over(&resumed), "{words}{resumed}");
}
