//! Text report of `diff`: a row for each kind, the worst pixels, missing streams, exceeded bounds.

use comfy_table::{Table, presets};

use codec::color::quality::PU_STEPS;
use codec::error::counted;
use codec::image::StreamKind;
use codec::image::sequence::FrameRange;
use codec::image::transfer::Transfer;
use codec::streams::ColorFormat;
use footage::compare::{
    Bound, Coding, Comparison, Domain, Judgement, Lowest, Measured, Origin, SampleErrors, SampleTotal, Side,
    StreamReport, Violation, side_name,
};
use footage::metrics::depth_error::DepthErrors;

/// Maximum number of streams that get a row each by default.
pub const FEW_ROWS: usize = 12;
const MISSING_LINES: usize = 8;

/// Returns the whole report. Streams have rows if there are at most `max_rows`.
pub fn report(sides: &[Side; 2], comparison: &Comparison, judgement: &Judgement, max_rows: usize) -> String {
    let side = |(at, side): (usize, &Side)| {
        let streams = counted(side.streams.len() as u64, "stream");
        format!("{}  {} ({}, {streams})", side_name(at), side.path, side.form.name())
    };
    let heading: Vec<String> = sides.iter().enumerate().map(side).chain(domain_lines(comparison)).collect();
    let has_rows = comparison.streams.len() <= max_rows;
    let mut paragraphs = vec![
        heading.join("\n"),
        summary(comparison),
        if has_rows { stream_table(comparison) } else { String::new() },
        worst_table(comparison),
        notes(comparison).join("\n"),
        verdict_lines(comparison, judgement).join("\n"),
    ];
    paragraphs.retain(|paragraph| !paragraph.is_empty());
    paragraphs.join("\n\n") + "\n"
}

/// Returns a table. Headings are separated by `|`.
fn table(headings: &str) -> Table {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_header(headings.split('|'));
    table
}

fn range(frames: FrameRange) -> String {
    if frames.count() == 1 { frames.first.to_string() } else { frames.to_string() }
}

fn db(value: f64) -> String {
    match value {
        f64::INFINITY => "inf dB".into(),
        // NaN: the codes are equal although the bits differ.
        _ if value.is_nan() => "equal codes".into(),
        _ => format!("{value:.2} dB"),
    }
}

fn metres(value: f64) -> String {
    if value.is_finite() && value != 0.0 && value < 0.001 { format!("{value:.1e} m") } else { format!("{value:.4} m") }
}

fn lowest(lowest: Option<Lowest>) -> String {
    lowest.map_or_else(|| "-".into(), |lowest| db(lowest.value))
}

fn quality(lowest: Option<Lowest>) -> String {
    lowest.map_or_else(|| "-".into(), |lowest| format!("{:.1}", lowest.value))
}

fn ssim(value: Option<f64>) -> String {
    value.map_or_else(|| "-".into(), |value| format!("{value:.5}"))
}

/// Largest error of a stream, in the unit of its metric.
fn largest(stream: &StreamReport) -> String {
    match (&stream.measured, stream.domain.coding) {
        (Measured::Depth(errors), _) => counted(errors.max_error_codes.into(), "code"),
        (Measured::Color(errors), Coding::Color(ColorFormat::Half { .. }, _)) => {
            format!("{:.2} PU21", f64::from(errors.max_error) / PU_STEPS)
        }
        (Measured::Color(errors) | Measured::Bytes(errors), _) => format!("{} of 255", errors.max_error),
    }
}

fn summary(comparison: &Comparison) -> String {
    let mut table = table("kind|streams|images|differing|max error|in metres|PSNR|lowest frame, cell|quality|SSIM");
    let none = || "-".to_owned();
    // Adds a row: kind, streams, images and share of differing pixels, followed by `measures`.
    let mut add = |kind: StreamKind, differing: u64, measures: [String; 6]| {
        let of_kind = || comparison.streams.iter().filter(|stream| stream.id.kind == kind);
        let images: u64 = of_kind().map(|stream| stream.frames.count()).sum();
        let pixels: u64 =
            of_kind().map(|stream| stream.frames.count() * u64::from(stream.size[0]) * u64::from(stream.size[1])).sum();
        let share = match (differing, 100.0 * differing as f64 / pixels.max(1) as f64) {
            (0, _) => "none".to_owned(),
            (_, percent) if percent < 0.001 => "<0.001%".into(),
            (_, percent) => format!("{percent:.3}%"),
        };
        let counts = [kind.name().to_owned(), of_kind().count().to_string(), images.to_string(), share];
        table.add_row(counts.into_iter().chain(measures));
    };
    let of_samples = |total: &SampleTotal, lowest: String| {
        let least = quality(total.lowest_quality.map(|(_, lowest)| lowest));
        let error = total.worst.map_or_else(|| "0".into(), |at| largest(&comparison.streams[at]));
        [error, none(), db(total.psnr_db), lowest, least, ssim(total.ssim)]
    };
    if let Some(total) = comparison.color() {
        let of = |found: Option<(usize, Lowest)>| lowest(found.map(|(_, lowest)| lowest));
        let cells = format!("{}, {}", of(total.lowest_frame), of(total.lowest_cell));
        add(StreamKind::Color, total.differing_pixels, of_samples(&total, cells));
    }
    if let Some((errors, _)) = comparison.depth() {
        let error = counted(errors.max_error_codes.into(), "code");
        let measures = [error, metres(errors.max_error_m), db(errors.psnr_db()), none(), none(), none()];
        add(StreamKind::Depth, errors.differing_pixels, measures);
    }
    for kind in [StreamKind::Material, StreamKind::Alpha] {
        if let Some(total) = comparison.samples(kind) {
            add(kind, total.differing_pixels, of_samples(&total, none()));
        }
    }
    table.trim_fmt()
}

fn stream_table(comparison: &Comparison) -> String {
    let mut table = table("stream|frames|max error|in metres|PSNR|lowest frame, cell|quality|SSIM");
    for stream in &comparison.streams {
        let name = match &stream.other_id {
            Some(other) => format!("{} = {}/{}", stream.id, other.probe, other.face.name()),
            None => stream.id.to_string(),
        };
        let color = stream.color();
        let psnr = stream.measured.psnr_db();
        let [of_frame, of_cell, of_eye] = color.map(SampleErrors::lowest).unwrap_or_default();
        table.add_row(vec![
            name,
            range(stream.frames),
            largest(stream),
            stream.depth().map_or_else(|| "-".into(), |errors| metres(errors.max_error_m)),
            db(psnr),
            color.map_or_else(|| "-".into(), |_| format!("{}, {}", lowest(of_frame), lowest(of_cell))),
            quality(of_eye),
            ssim(color.and_then(SampleErrors::ssim)),
        ]);
    }
    table.trim_fmt()
}

fn worst_table(comparison: &Comparison) -> String {
    let pixel = |what: &'static str, at: Option<usize>| {
        let stream = &comparison.streams[at?];
        Some((what, stream, stream.worst()?.0, largest(stream)))
    };
    let lowest = |what: &'static str, found: Option<(usize, Lowest)>| {
        let (at, Lowest { value, spot }) = found.filter(|(_, lowest)| lowest.value.is_finite())?;
        Some((what, &comparison.streams[at], spot, db(value)))
    };
    let color = comparison.color();
    let rows = [
        pixel("colour pixel", color.as_ref().and_then(|total| total.worst)),
        lowest("colour frame", color.as_ref().and_then(|total| total.lowest_frame)),
        lowest("colour cell", color.as_ref().and_then(|total| total.lowest_cell)),
        pixel("depth pixel", comparison.depth().and_then(|(_, at)| at)),
        pixel("material pixel", comparison.samples(StreamKind::Material).and_then(|total| total.worst)),
        pixel("alpha pixel", comparison.samples(StreamKind::Alpha).and_then(|total| total.worst)),
    ];
    let mut table = table("worst|stream|frame|x|y|error or PSNR");
    for (what, stream, spot, value) in rows.into_iter().flatten() {
        let has_place = what != "colour frame";
        let [x, y] = [spot.x, spot.y].map(|at| if has_place { at.to_string() } else { "-".to_owned() });
        table.add_row([what.to_owned(), stream.id.to_string(), spot.frame.to_string(), x, y, value]);
    }
    if table.row_count() == 0 { String::new() } else { table.trim_fmt() }
}

/// Returns one line for each kind: range or encoding, and its origin.
fn domain_lines(comparison: &Comparison) -> Vec<String> {
    let mut lines = Vec::new();
    for kind in StreamKind::ALL {
        let name = if kind == StreamKind::Color { "colour" } else { kind.name() };
        let mut seen: Vec<Domain> = Vec::new();
        for stream in comparison.streams.iter().filter(|stream| stream.id.kind == kind) {
            if !seen.contains(&stream.domain) {
                seen.push(stream.domain);
            }
        }
        let Some(first) = seen.first() else { continue };
        let more = match seen.len() {
            1 => String::new(),
            count => format!(" (the first of {count}, by probe or stream)"),
        };
        lines.push(format!("{name} in {}{more}", domain_text(first)));
    }
    lines
}

fn domain_text(domain: &Domain) -> String {
    let of = match domain.origin {
        Origin::Container(side) => format!(" of {}", side_name(side)),
        Origin::Manifest(side) => format!(" of {}'s manifest", side_name(side)),
        Origin::Default => String::new(),
    };
    match domain.coding {
        Coding::Depth(range) => {
            let found = if domain.origin == Origin::Default { ", the range of both sides" } else { "" };
            format!("16-bit log codes{of}, {range}{found}")
        }
        Coding::Color(ColorFormat::EightBit(tone), cell) => {
            let curve = if tone.transfer == Transfer::Srgb { "sRGB" } else { "linear light" };
            let exposure = match tone.exposure_ev {
                0.0 => String::new(),
                stops => format!(" at {stops:+} EV"),
            };
            format!("8-bit {curve}{exposure}{of}, cells of {cell} pixels")
        }
        Coding::Color(ColorFormat::Half { white_cd_m2 }, cell) => {
            format!("half floats{of}, PSNR of PU21 with white at {white_cd_m2} cd/m2, cells of {cell} pixels")
        }
        Coding::Bytes => "8-bit codes".to_owned(),
    }
}

fn notes(comparison: &Comparison) -> Vec<String> {
    let (depth, color) = (comparison.depth().map(|(errors, _)| errors), comparison.color());
    let of_depth = |count: fn(&DepthErrors) -> u64| depth.as_ref().map_or(0, count);
    let of_color = |count: fn(&SampleTotal) -> u64| color.as_ref().map_or(0, count);
    let counts = [
        ("background on one side only:", of_depth(|errors| errors.background_mismatches), "depth pixel"),
        ("outside the range of the codes:", of_depth(|errors| errors.outside_pixels), "depth pixel"),
        ("beyond 8 bits:", of_color(|total| total.clipped_pixels), "colour pixel"),
        ("SSIM is the mean of", of_color(|total| total.ssim_frames), "image"),
    ];
    let counts = counts.into_iter().filter(|(_, count, _)| *count > 0);
    let mut notes: Vec<String> = counts.map(|(of, count, what)| format!("{of} {}", counted(count, what))).collect();
    if let Some(eye) = color.as_ref().map(|total| &total.eye)
        && let [Some(mean), Some(p10), Some(butteraugli)] =
            [eye.ssimulacra2(), eye.ssimulacra2_p10(), eye.butteraugli_3norm()]
    {
        notes.push(format!(
            "SSIMULACRA2 {mean:.2}, 10th percentile {p10:.2}, butteraugli (3-norm) {butteraugli:.3}: of {}",
            counted(eye.pictures(), "image")
        ));
    }
    for missing in comparison.missing.iter().take(MISSING_LINES) {
        notes.push(format!("only in {}: {} frames {}", side_name(missing.only_in), missing.id, range(missing.frames)));
    }
    if comparison.missing.len() > MISSING_LINES {
        notes.push(format!("and {} more on one side only", comparison.missing.len() - MISSING_LINES));
    }
    notes
}

fn verdict_lines(comparison: &Comparison, judgement: &Judgement) -> Vec<String> {
    let mut lines: Vec<String> =
        judgement.violations.iter().map(|violation| violation_text(comparison, violation)).collect();
    if let Some((count, first)) = comparison.bits()
        && count > 0
    {
        let place = first.map_or_else(String::new, |(at, spot)| {
            let id = &comparison.streams[at].id;
            format!(", the first at {id}, frame {}, pixel ({}, {})", spot.frame, spot.x, spot.y)
        });
        lines.push(format!("different: the bits of {} differ{place}", counted(count, "pixel")));
    }
    if !comparison.missing.is_empty() {
        lines.push("different: streams or frames are on one side only (--common leaves them out)".into());
    }
    if lines.is_empty() {
        let text = match (judgement.equal, judgement.bounded) {
            (true, _) if comparison.bits().is_some() => "equal in every bit",
            (true, _) => "equal in codes",
            (false, true) => "within bounds",
            (false, false) => "different; no bound was given",
        };
        lines.push(text.into());
    }
    lines
}

fn violation_text(comparison: &Comparison, violation: &Violation) -> String {
    let Violation { bound, limit, measured, stream, spot } = violation;
    let codes = |codes: f64| counted(codes as u64, "code");
    let (option, is, most, by) = match bound {
        Bound::MaxError => {
            ("--max-error", codes(*measured), codes(*limit), format!("{} too many", codes(measured - limit)))
        }
        Bound::Clipping => {
            return format!(
                "{} did not fit 8 bits, most in {}: encode with --hdr, or accept it with --allow-clipping",
                counted(*measured as u64, "colour pixel"),
                comparison.streams[*stream].id
            );
        }
        Bound::MinPsnr | Bound::MinCellPsnr => {
            let option = if *bound == Bound::MinPsnr { "--min-psnr" } else { "--min-cell-psnr" };
            (option, db(*measured), db(*limit), format!("{} too low", db(limit - measured)))
        }
        Bound::MinQuality => {
            let words = |quality: f64| format!("{quality:.2}");
            ("--min-quality", words(*measured), words(*limit), format!("{} too low", words(limit - measured)))
        }
    };
    let place = match (bound, spot) {
        (Bound::MinPsnr, Some(spot)) => format!(", frame {}", spot.frame),
        (Bound::MinCellPsnr | Bound::MinQuality, Some(spot)) => {
            format!(", frame {}, cell at ({}, {})", spot.frame, spot.x, spot.y)
        }
        (Bound::MaxError, Some(spot)) => format!(", frame {}, pixel ({}, {})", spot.frame, spot.x, spot.y),
        (Bound::Clipping, _) | (_, None) => String::new(),
    };
    format!("{option} {most} does not hold: {is} at {}{place}, {by}", comparison.streams[*stream].id)
}
