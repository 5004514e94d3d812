//! Notes of encoding commands: suspicious values in the first frames, and a container that is larger than its source.

use std::collections::HashSet;

use crate::output::human_bytes;
use crate::progress::Progress;
use crate::{GlobalArgs, depth_bound};
use codec::error::{Error, Result, counted};
use codec::image::StreamKind;
use footage::convention::{self, Choice, MAX_PROBES, Verdict};
use footage::dataset::Source;
use footage::dataset::manifest::Keep;
use footage::encode::{self, EncodeSettings, EncodeSummary, FrameSource};

/// Notes that colour is encoded as half floats because the manifest says so.
pub fn note_keep(keep: Option<Keep>, source: &Source, settings: &EncodeSettings, global: &GlobalArgs) {
    let groups = encode::selected_groups(source, settings);
    if keep == Some(Keep::Hdr) && groups.iter().any(|group| group.kind == StreamKind::Color) {
        global.note(
            "colour is kept as half floats, as the manifest says (\"keep\": \"hdr\"): --clip stores 8 bits instead",
        );
    }
}

/// Notes suspicious values of the first frames before encoding. Unreadable files are reported by the encoder.
///
/// # Errors
/// [`crate::Error::Interrupted`].
pub fn note_values(source: &Source, settings: &EncodeSettings, global: &GlobalArgs) -> Result<()> {
    // The checks hold more than an image per thread, which the memory limit does not count.
    if settings.memory.bytes.is_some() {
        return Ok(());
    }
    let choice = Choice { max_probes: MAX_PROBES, ..Choice::default() };
    let steps = convention::steps(source, &choice).unwrap_or(0);
    let progress = Progress::start(global, "checking", steps)?;
    if settings.kinds.contains(&StreamKind::Color)
        && let Some((file, pixels)) = source.unnamed_alpha()
    {
        let file = file.display();
        let instead = "list it as files.alpha in the manifest to keep it";
        global.note(format_args!(
            "warning: {file}: alpha is below 1 in {} and is not encoded: {instead}",
            counted(pixels, "pixel")
        ));
    }
    let findings = match convention::check_values(source, &choice, &progress) {
        Ok(findings) => findings,
        Err(Error::Interrupted) => return Err(Error::Interrupted),
        Err(_) => Vec::new(),
    };
    drop(progress);
    let is_coded = |check: &str| {
        let of = |kind: StreamKind| settings.kinds.contains(&kind) && check.starts_with(kind.name());
        StreamKind::ALL.into_iter().any(of) || check == "positions"
    };
    for finding in findings.iter().filter(|finding| finding.verdict == Verdict::Suspect && is_coded(finding.check)) {
        global.note(format_args!("warning: {}: {}", finding.check, finding.says));
    }
    Ok(())
}

/// Notes outlier pixels that take much of the depth precision, and the number of pixels outside near and far.
pub fn note_depth(summary: &EncodeSummary, global: &GlobalArgs) {
    for probe in &summary.depth {
        if let Some(strays) = &probe.strays {
            global.note(format_args!("warning: {}", depth_bound::stray_words(probe, strays)));
        }
    }
    if summary.outside_pixels > 0 {
        let pixels = counted(summary.outside_pixels, "depth pixel");
        global.note(format_args!("{pixels} outside near and far: replaced according to --invalid-depth"));
    }
}

/// Notes a container of `bytes` that is larger than its source files. `instead` suggests a smaller encoding.
pub fn note_size(
    source: &dyn FrameSource,
    settings: &EncodeSettings,
    (bytes, instead): (u64, &str),
    global: &GlobalArgs,
) {
    // Several kinds may share files.
    let mut files = HashSet::new();
    for group in encode::selected_groups(source, settings) {
        files.extend(group.frames.iter().flat_map(|frame| source.files(group, frame).unwrap_or_default()));
    }
    let source_bytes: u64 = files.iter().filter_map(|file| Some(std::fs::metadata(file).ok()?.len())).sum();
    if bytes > source_bytes && source_bytes > 0 {
        let (made, files) = (human_bytes(bytes), human_bytes(source_bytes));
        global.note(format_args!("{made}, the source files are {files}: try {instead}"));
    }
}
