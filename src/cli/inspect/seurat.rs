//! `inspect MANIFEST.json`: reports views, cameras and depth types of a Seurat manifest.

use std::collections::BTreeMap;
use std::fmt::Write;

use serde::Serialize;

use super::args::Args;
use super::scene::box_text;
use crate::options::WithAccount;
use crate::report::Table;
use crate::{ExitStatus, GlobalArgs, output};
use codec::error::Result;
use footage::dataset::seurat::{DepthType, SeuratCapture, SeuratView};
use scene::SceneBounds;

#[derive(Serialize)]
struct Document {
    manifest: String,
    view_groups: usize,
    views: usize,
    pixels: u64,
    images: Vec<Images>,
    headbox_center_m: Option<[f64; 3]>,
    cameras_box_m: Option<SceneBounds>,
}

/// Number of views with equal properties.
#[derive(Serialize)]
struct Images {
    #[serde(flatten)]
    properties: Properties,
    views: usize,
}

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
struct Properties {
    width: u32,
    height: u32,
    projection: &'static str,
    depth_type: DepthType,
}

impl Properties {
    fn of(view: &SeuratView) -> Properties {
        let [width, height] = view.size();
        let projection = if view.camera.is_orthographic() { "orthographic" } else { "perspective" };
        Properties { width, height, projection, depth_type: view.camera.depth_type() }
    }
}

pub fn run(args: &Args, global: &GlobalArgs) -> Result<ExitStatus> {
    let manifest = args.input.display().to_string();
    args.refuse_all_but_json(&format!("{manifest}: a Seurat manifest"))?;
    let capture = SeuratCapture::open(&args.input)?;
    let account = capture.account();
    let document = WithAccount { report: Document::of(manifest, capture), account: &account };
    output::print_either(args.json, &document, || text(&document.report))?;
    args.account.print_inspected(&account, args.json, global);
    Ok(ExitStatus::Passed)
}

impl Document {
    fn of(manifest: String, capture: SeuratCapture) -> Document {
        let mut images = BTreeMap::<Properties, usize>::new();
        for view in &capture.views {
            *images.entry(Properties::of(view)).or_default() += 1;
        }
        let pixels = |view: &SeuratView| view.size().map(u64::from).iter().product::<u64>();
        let corners = |[min, max]: [glam::DVec3; 2]| SceneBounds { min: min.to_array(), max: max.to_array() };
        Document {
            manifest,
            view_groups: capture.group_count,
            views: capture.views.len(),
            pixels: capture.views.iter().map(pixels).sum(),
            images: images.into_iter().map(|(properties, views)| Images { properties, views }).collect(),
            headbox_center_m: capture.headbox_center.map(|center| center.to_array()),
            cameras_box_m: capture.cameras_box().map(corners),
        }
    }
}

fn text(document: &Document) -> String {
    let mut out = format!("{}: Seurat manifest\n", document.manifest);
    if let Some(bounds) = &document.cameras_box_m {
        let _ = writeln!(out, "Cameras: {}", box_text(bounds));
    }
    let _ = match document.headbox_center_m {
        Some([x, y, z]) => writeln!(out, "Headbox centre: {x:.3}, {y:.3}, {z:.3}"),
        None => writeln!(out, "No headbox centre"),
    };
    let mut table = Table::new("What|>Count");
    for (what, count) in
        [("view groups", document.view_groups as u64), ("views", document.views as u64), ("pixels", document.pixels)]
    {
        table.row([what.to_owned(), count.to_string()]);
    }
    let _ = write!(out, "\n{table}");
    if document.images.is_empty() {
        return out;
    }
    let mut table = Table::new(">Views|>Size|Projection|Depth");
    for Images { properties, views } in &document.images {
        let Properties { width, height, projection, depth_type } = properties;
        let words = [(*projection).to_owned(), depth_type.name().to_owned()];
        table.row([views.to_string(), format!("{width}x{height}")].into_iter().chain(words));
    }
    let _ = write!(out, "\n{table}");
    out
}
