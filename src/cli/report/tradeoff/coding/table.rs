//! Coding sweeps: bytes, quality and time of footage (CALF figures 7 and 8, GDC figures 5, 6 and 8).

use StreamKind::{Color, Depth, Material};

use crate::report::timing::{median, spread};
use crate::report::tradeoff::kind::{
    Better, DECIBELS, Format, Measure, Measured, Panel, PanelLine, Scale, Source, SweepKind, Trade, TradeAxis,
};
use crate::report::tradeoff::knob::{ALL_STREAMS, Knob, Stage};
use codec::image::StreamKind;

pub static CODING: SweepKind = SweepKind {
    stem: "tradeoff",
    title: "What accuracy costs",
    input_label: "Footage",
    knobs: KNOBS,
    measures: MEASURES,
    panels: PANELS,
    trades: TRADES,
    is_scored: true,
    is_resumable: true,
    survey_runs: 0,
    method: "Each point was encoded, decoded and compared by the commands that tradeoff.csv lists. A decoding run is the median \
             of several passes with the container in memory, without LZMA2; encoding includes reading the source. A frame \
             has the images of all probes and faces.",
};

const fn encode(
    name: &'static str,
    label: &'static str,
    streams: &'static [StreamKind],
    default: &'static str,
    usual: &'static [&'static str],
) -> Knob {
    Knob::new(Stage::Encode, name, label, default, usual).of(streams)
}

/// Knobs of encoding and decoding, in the order of reports.
pub const KNOBS: &[Knob] = &[
    encode("depth-codec", "depth codec", &[Depth], "predictive", &["predictive", "quadtree", "aabb", "bc4w"]),
    encode("depth-window", "depth window (frames)", &[Depth], "2", &["1", "2", "4", "8", "16"])
        .with(&[("depth-codec", "quadtree")]),
    encode("max-aabbs", "AABB limit", &[Depth, Material], "8", &["1", "2", "4", "8", "16"])
        .with(&[("depth-codec", "aabb")]),
    encode("update-threshold", "update threshold (codes)", &[Depth], "0, with bc5 100", &["0", "10", "30", "100"])
        .formerly("epsilon"),
    encode("max-error", "error bound E (codes)", &[Depth], "100", &["0", "10", "25", "50", "100", "200", "400", "800"])
        .formerly("error"),
    encode(
        "max-error-relative",
        "error bound (relative to the depth)",
        &[Depth],
        "as max-error",
        &["0%", "0.05%", "0.1%", "0.2%", "0.5%"],
    )
    .formerly("error-relative"),
    encode("depth-domain", "domain of functions", &[Depth], "log", &["log", "linear", "inverse"])
        .with(&[("depth-codec", "quadtree")]),
    encode("optimize", "optimization goal", &[Depth], "quality", &["quality", "size"]).formerly("decide"),
    encode("min-children", "children changed before one function is tried", &[Depth], "3", &["1", "2", "3", "4"])
        .with(&[("depth-codec", "quadtree")]),
    encode("depth-block", "depth blocks", &[Depth], "none", &["none", "bc5"]).with(&[("depth-codec", "aabb")]),
    encode(
        "depth-tile",
        "tile size (pixels)",
        &[Depth, Material],
        "128 for predictive, else half of the face",
        &["32", "64", "128", "256"],
    ),
    encode("keyframe-interval", "keyframe interval (frames)", &[Depth, Material], "64", &["4", "8", "16", "32", "64"]),
    encode("color-cell", "cell size (pixels)", &[Color], "64", &["8", "16", "32", "64", "128"]).formerly("cell"),
    encode("color-codec", "colour codec", &[Color], "transform", &["transform", "cells"]),
    encode("color-chunk", "chunk length of colour (frames)", &[Color], "24", &["6", "12", "24", "48", "96"])
        .with(&[("color-codec", "transform")]),
    encode("quality", "least quality to the eye", &[Color], "79, of cells none", &["60", "70", "79", "85", "90"])
        .with(&[("color-codec", "transform")]),
    encode(
        "psnr",
        "PSNR threshold (dB)",
        &[Color],
        "none, of cells 50, in blocks as psnr-final",
        &["30", "35", "40", "45", "50"],
    ),
    encode("color-block", "colour blocks", &[Color], "none", &["none", "bc1", "bc7"]),
    encode("psnr-final", "PSNR threshold in blocks (dB)", &[Color], "30 for bc1, else 40", &["30", "35", "40", "45"])
        .with(&[("color-block", "bc7")]),
    encode("lookahead", "keyframe lookahead (frames)", &[Color], "64", &["4", "16", "64", "256"])
        .formerly("keyframe-reach")
        .with(&[("color-codec", "cells")]),
    encode(
        "material-error",
        "error bound of material (steps of 8 bits)",
        &[Material],
        "0",
        &["0", "2", "4", "8", "16"],
    ),
    encode("effort", "effort", ALL_STREAMS, "normal", &["fast", "normal"]),
    Knob { without: Some("none"), ..encode("lzma2", "LZMA2 level", ALL_STREAMS, "none", &["none", "1", "6", "9"]) },
    Knob::new(Stage::Both, "threads", "threads", "all", &["1", "2", "4"]).of(ALL_STREAMS),
    Knob::new(Stage::Decode, "device", "device", "cpu", &["cpu", "gpu"]).of(ALL_STREAMS),
];

/// Sizes are those of CALF table 1: footage, temporal coding, blocks or functions, container, container with LZMA2.
/// Depth errors are in 16-bit log codes, material errors in 8-bit steps.
const MEASURES: &[Measure] = &[
    Measure::new("bytes_raw", Source::Count(Some(1))).shown("raw", Format::Bytes),
    Measure::new("bytes_temporal", Source::Count(Some(1))).shown("in time", Format::Bytes),
    Measure::new("bytes_spatial", Source::Count(None)).shown("blocks or functions", Format::Bytes),
    Measure::new("bytes_container", Source::Count(Some(1))).shown("container", Format::Bytes),
    Measure::new("bytes_lzma2", Source::Count(Some(1))).shown("+ LZMA2", Format::Bytes),
    Measure::derived("ratio_percent", |of| Some(percent(of, "bytes_container", "bytes_raw")))
        .shown("% of raw", Format::Decimals(2)),
    Measure::derived("ratio_lzma2_percent", |of| Some(percent(of, "bytes_lzma2", "bytes_raw"))),
    Measure::derived("encode_seconds", |of| median(of.runs("encode_runs")))
        .median_of("encode_runs")
        .shown("encode s", Format::Even),
    Measure::derived("encode_seconds_min", |of| Some(spread(of.runs("encode_runs"))?.low)),
    Measure::derived("encode_seconds_max", |of| Some(spread(of.runs("encode_runs"))?.high)),
    Measure::new("encode_runs", Source::Runs),
    Measure::derived("decode_seconds", |of| median(of.runs("decode_runs"))).median_of("decode_runs"),
    Measure::derived("decode_seconds_min", |of| Some(spread(of.runs("decode_runs"))?.low)),
    Measure::derived("decode_seconds_max", |of| Some(spread(of.runs("decode_runs"))?.high)),
    Measure::new("decode_runs", Source::Runs),
    Measure::new("decode_passes", Source::Count(Some(0))),
    Measure::derived("decode_ms_per_frame", |of| {
        Some(median(of.runs("decode_runs"))? * 1000.0 / of.count("frames").max(1) as f64)
    })
    .median_of("decode_runs")
    .shown("decode ms a frame", Format::Even),
    Measure::derived("megapixels_per_second", |of| {
        Some(of.count("pixels") as f64 / 1e6 / median(of.runs("decode_runs"))?.max(1e-9))
    })
    .shown("Mpixel/s", Format::Decimals(0)),
    Measure::derived("changed_percent", |of| Some(percent(of, "updated_pixels", "pixels")))
        .shown("changed %", Format::Decimals(1)),
    Measure::new("frames", Source::Count(Some(1))),
    Measure::new("images", Source::Count(Some(1))),
    Measure::new("pixels", Source::Count(Some(1))),
    Measure::new("updated_pixels", Source::Count(Some(0))),
    Measure::new("psnr_db", DECIBELS).shown("PSNR dB", Format::Decimals(2)),
    Measure::new("min_psnr_db", Source::Number { is_needed: false, may_be_infinite: true })
        .shown("worst cell dB", Format::Decimals(2)),
    Measure::new("min_quality", Source::Signed).shown("worst cell's quality", Format::Decimals(1)),
    Measure::new("ssim", Source::Signed).shown("SSIM", Format::Decimals(4)),
    Measure::new("max_error_codes", Source::Count(None)).shown("max error", Format::Decimals(0)),
    Measure::new("max_error_m", Source::Number { is_needed: false, may_be_infinite: false })
        .shown("max error m", Format::Even),
    Measure::new("encode_peak_bytes", Source::Count(None)).shown("encode memory", Format::Bytes),
    Measure::new("decode_peak_bytes", Source::Count(None)).shown("decode memory", Format::Bytes),
];

fn percent(of: &Measured, part: &str, whole: &str) -> f64 {
    100.0 * of.count(part) as f64 / of.count(whole).max(1) as f64
}

const SIZES: &[PanelLine] = &[
    PanelLine { label: "container", measure: "bytes_container" },
    PanelLine { label: "with LZMA2", measure: "bytes_lzma2" },
];
const PSNRS: &[PanelLine] = &[
    PanelLine { label: "all samples", measure: "psnr_db" },
    PanelLine { label: "worst cell", measure: "min_psnr_db" },
];

const PANELS: &[Panel] = &[
    Panel::new("Container", Scale::Bytes, SIZES).mapped(Better::Less),
    Panel::new("PSNR (dB)", Scale::Decibels, PSNRS).for_streams(&[Color]),
    Panel::new("PSNR (dB)", Scale::Decibels, &[PanelLine::of("psnr_db")]).for_streams(&[Depth, Material]),
    Panel::new("Quality of the worst cell", Scale::Linear, &[PanelLine::of("min_quality")]).for_streams(&[Color]),
    Panel::new("SSIM", Scale::Linear, &[PanelLine::of("ssim")]).for_streams(&[Color]),
    Panel::new("Largest error (16-bit codes)", Scale::Linear, &[PanelLine::of("max_error_codes")])
        .for_streams(&[Depth]),
    Panel::new("Largest error (8-bit steps)", Scale::Linear, &[PanelLine::of("max_error_codes")])
        .for_streams(&[Material]),
    Panel::new("Decoding (ms a frame)", Scale::Linear, &[PanelLine::of("decode_ms_per_frame")]).mapped(Better::Less),
    Panel::new("Encoding (s)", Scale::Linear, &[PanelLine::of("encode_seconds")]),
];

const RATE: TradeAxis =
    TradeAxis { label: "container (% of raw footage)", measure: "ratio_percent", scale: Scale::Logarithmic };
const TIME: TradeAxis =
    TradeAxis { label: "decoding (ms a frame)", measure: "decode_ms_per_frame", scale: Scale::Logarithmic };
const RATE_DISTORTION: Trade = Trade {
    name: "rate-distortion",
    title: "Rate and distortion",
    across: RATE,
    up: TradeAxis { label: "PSNR (dB)", measure: "psnr_db", scale: Scale::Decibels },
    better: Better::More,
    note: " PSNR is that of all samples; of depth, in 16-bit logarithmic codes.",
};

const TRADES: &[Trade] = &[
    RATE_DISTORTION,
    Trade { name: "time-distortion", title: "Decoding time and distortion", across: TIME, ..RATE_DISTORTION },
    Trade {
        name: "rate-time",
        title: "Rate and decoding time",
        up: TIME,
        better: Better::Less,
        note: " Quality is not in this figure.",
        ..RATE_DISTORTION
    },
];
