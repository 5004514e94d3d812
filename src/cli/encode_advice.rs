//! Notes of encoding commands: what the values of the first frames suggest, and a result that is larger than its source.

use crate::cli::GlobalArgs;
use crate::cli::output::human_bytes;
use crate::convention::{self, Choice, MAX_PROBES, Verdict};
use crate::dataset::Source;
use crate::encode::{self, EncodeSettings, FrameSource};
use crate::image::StreamKind;
use crate::monitor::Silent;

/// Says what is odd about the values of the first frames, before anything is coded. The encoder reports what cannot be read.
pub fn note_values(source: &Source, settings: &EncodeSettings, global: &GlobalArgs) {
    // Checks keep an image for each thread, and more of it, which no limit counts.
    if settings.memory.bytes.is_some() {
        return;
    }
    let choice = Choice { max_probes: MAX_PROBES, ..Choice::default() };
    let findings = convention::check_values(source, &choice, &Silent).unwrap_or_default();
    let is_coded = |check: &str| {
        let of = |kind: StreamKind| settings.kinds.contains(&kind) && check.starts_with(kind.name());
        StreamKind::ALL.into_iter().any(of)
    };
    for finding in findings.iter().filter(|finding| finding.verdict == Verdict::Suspect && is_coded(finding.check)) {
        global.note(format_args!("warning: {}: {}", finding.check, finding.says));
    }
}

/// Says so where a container of `bytes` is larger than the files that it was made from; `instead` makes it smaller.
pub fn note_size(
    source: &dyn FrameSource,
    settings: &EncodeSettings,
    (bytes, instead): (u64, &str),
    global: &GlobalArgs,
) {
    let mut source_bytes = 0;
    for group in encode::selected_groups(source, settings) {
        let files = group.group.frames.iter().filter_map(|frame| source.file(group.group, frame).ok()?);
        source_bytes += files.filter_map(|file| Some(std::fs::metadata(file).ok()?.len())).sum::<u64>();
    }
    if bytes > source_bytes && source_bytes > 0 {
        let (made, files) = (human_bytes(bytes), human_bytes(source_bytes));
        global.note(format_args!("{made}, the source files are {files}: try {instead}"));
    }
}
