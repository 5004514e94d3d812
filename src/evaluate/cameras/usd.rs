//! Cameras of USD (openusd.org, UsdGeomCamera and UsdGeomXformable): prims of type `Camera` of text files,
//! through sublayers, references, payloads and variants. They look along −Z with +Y up; apertures and focal length have the same
//! unit.
//!
//! Frames are time codes × frames per second / time codes per second. Values between samples are interpolated linearly, as USD
//! defines it, except rotations, including those in matrices, which use slerp, since linear interpolation of matrices would
//! shear. Metres per unit and the up axis of the stage are applied.

use std::fmt::Write as _;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use glam::{DMat4, DQuat, DVec3};
use openusd::ar::{self, Resolver};
use openusd::sdf::Value;
use openusd::usd::{Attribute, Prim, PrimPredicate, Stage};

use super::document::{Content, FileCamera, FileCameras, WriteSettings, Written, axes_of, check_count, matrix_of};
use super::poses::{Track, poses, tracks};
use codec::error::{Error, Result};
use codec::image::FrameRange;
use codec::math::Camera;
use footage::guard::guarded;
use footage::text::nesting;
use render::camera_path::TimedCamera;

/// Defaults for values that a file does not state.
const METRES_PER_UNIT: f64 = 0.01;
const HORIZONTAL_APERTURE: f64 = 20.955;
const VERTICAL_APERTURE: f64 = 15.2908;
const FOCAL_LENGTH: f64 = 50.0;
/// Width of 36 mm film in tenths of a metre.
const WRITTEN_APERTURE: f64 = 0.36;
/// Distance from a whole frame at which a time counts as that frame.
const NEAR_FRAME: f64 = 1e-6;

/// Maximum nesting of prims, and of brackets in text: the crate reads them by recursion.
const MAX_NESTING: usize = 64;

/// First bytes of text, binary and package files.
const FORMATS: [&[u8]; 3] = [b"#usda", b"PXR-USDC", b"PK\x03\x04"];

pub fn is_of(bytes: &[u8]) -> bool {
    FORMATS.iter().any(|start| bytes.starts_with(start))
}

pub fn read(content: &Content<'_>) -> Result<FileCameras> {
    guarded(|| read_stage(content)).unwrap_or_else(|| Err(Error::invalid("the USD file is damaged")))
}

fn read_stage(content: &Content<'_>) -> Result<FileCameras> {
    let stage = open(content)?;
    let unit_m = match stage.stage_metadata("metersPerUnit").map_err(damaged)? {
        Some(value) => number(&value)?,
        None => METRES_PER_UNIT,
    };
    let scale = DMat4::from_scale(DVec3::splat(unit_m));
    let to_world = match stage.stage_metadata("upAxis").map_err(damaged)?.as_ref().and_then(text) {
        Some("Z") => DMat4::from_rotation_x(-std::f64::consts::FRAC_PI_2) * scale,
        _ => scale,
    };
    let codes_per_second = stage.time_codes_per_second();
    let codes_per_frame = content.settings.fps.map_or(1.0, |fps| codes_per_second / fps);
    if !(codes_per_frame.is_finite() && codes_per_frame > 0.0) {
        return Err(Error::invalid(format!("{codes_per_second} time codes per second: a number above 0 was expected")));
    }
    let mut found = FileCameras::default();
    let mut chain = Vec::new();
    for root in stage.root_prims().map_err(damaged)? {
        let prim = stage.prim(format!("/{}", root.as_str()).as_str());
        let scene = Scene { to_world, codes_per_frame };
        scene.find(prim, &mut chain, &mut found)?;
    }
    found.notes.extend(stage.composition_errors().iter().map(|error| format!("left out: {error}")));
    Ok(found)
}

fn too_deep() -> Error {
    Error::unsupported(format!("the USD file is nested more than {MAX_NESTING} deep"))
}

/// Fails for layers that the crate cannot be trusted with: it allocates what damaged binary files state, and reads nested text by
/// recursion.
fn check_layer(layer: &[u8]) -> Result<()> {
    if FORMATS[1..].iter().any(|start| layer.starts_with(start)) {
        return Err(Error::unsupported(
            "a binary USD file or package: write it as text first, with the program usdcat (usdcat IN -o OUT.usda)",
        ));
    }
    if nesting(layer) > MAX_NESTING as i32 { Err(too_deep()) } else { Ok(()) }
}

fn damaged(error: impl std::fmt::Display) -> Error {
    Error::invalid(format!("the USD file cannot be read: {error:#}"))
}

/// Opens a file whose bytes are at hand; the layers that it names are opened relative to its path.
fn open(content: &Content<'_>) -> Result<Stage> {
    check_layer(content.bytes)?;
    // The crate reads text without a byte order mark, and knows it by the name.
    let bytes = content.text()?.into_owned().into_bytes();
    check_layer(&bytes)?;
    let folder = std::path::absolute(content.path).ok().and_then(|path| Some(path.parent()?.to_path_buf()));
    let name = content.path.file_stem().unwrap_or_default();
    let root = folder.unwrap_or_default().join(name).with_extension("usda");
    let resolver = RootInMemory { root: root.clone(), bytes, files: ar::DefaultResolver::new() };
    Stage::builder().resolver(resolver).open(&root.to_string_lossy()).map_err(damaged)
}

/// Resolves the root layer to bytes in memory and other layers to files.
struct RootInMemory {
    root: PathBuf,
    bytes: Vec<u8>,
    files: ar::DefaultResolver,
}

impl Resolver for RootInMemory {
    fn create_identifier(&self, path: &str, anchor: Option<&ar::ResolvedPath>) -> String {
        if Path::new(path) == self.root { path.to_owned() } else { self.files.create_identifier(path, anchor) }
    }

    fn resolve(&self, path: &str) -> Option<ar::ResolvedPath> {
        if Path::new(path) == self.root { Some(ar::ResolvedPath::new(path)) } else { self.files.resolve(path) }
    }

    fn resolve_for_new_asset(&self, path: &str) -> Option<ar::ResolvedPath> {
        self.files.resolve_for_new_asset(path)
    }

    fn open_asset(&self, path: &ar::ResolvedPath) -> std::io::Result<Box<dyn ar::Asset>> {
        let path: &Path = path;
        let bytes = match path == self.root {
            true => self.bytes.clone(),
            false => self.files.open_asset(&ar::ResolvedPath::new(path))?.read_all()?,
        };
        check_layer(&bytes).map_err(std::io::Error::other)?;
        Ok(Box::new(Cursor::new(bytes)))
    }
}

/// How coordinates and times of a stage become metres and frames.
#[derive(Clone, Copy)]
struct Scene {
    to_world: DMat4,
    codes_per_frame: f64,
}

/// Attributes that define the field of view.
const LENS: [&str; 5] =
    ["focalLength", "horizontalAperture", "verticalAperture", "horizontalApertureOffset", "verticalApertureOffset"];

impl Scene {
    /// Adds the camera at a prim and those below it; `chain` holds the prims on the path to it.
    fn find(self, prim: Prim, chain: &mut Vec<Prim>, found: &mut FileCameras) -> Result<()> {
        if chain.len() >= MAX_NESTING {
            return Err(too_deep());
        }
        let stage = prim.stage().clone();
        if !PrimPredicate::DEFAULT_PROXIES.matches(stage.prim_status(prim.path().clone()).map_err(damaged)?) {
            return Ok(());
        }
        let is_camera = prim.type_name().map_err(damaged)?.is_some_and(|name| name.as_str() == "Camera");
        let children = prim.children().map_err(damaged)?;
        chain.push(prim);
        if is_camera {
            let path = chain[chain.len() - 1].path().as_str().to_owned();
            let name = path.rsplit('/').next().unwrap_or_default().to_owned();
            found.add(&name, self.camera(chain, &name, found.cameras.len()));
        }
        for child in children {
            self.find(child, chain, found)?;
        }
        chain.pop();
        Ok(())
    }

    /// Returns the poses of the camera at the end of a chain of prims.
    fn camera(self, chain: &[Prim], name: &str, count: usize) -> Result<Vec<FileCamera>> {
        let Some(prim) = chain.last() else { return Ok(Vec::new()) };
        let projection = prim.attribute("projection").get::<Value>().map_err(damaged)?;
        if projection.as_ref().and_then(text) == Some("orthographic") {
            return Err(Error::unsupported("it is orthographic"));
        }
        let chain: Vec<Transform> = chain.iter().map(Transform::of).collect::<Result<_>>()?;
        let lens = LENS.map(|name| Samples::of(&prim.attribute(name), ""));
        let lens: Vec<Samples> = lens.into_iter().collect::<Result<_>>()?;
        let at = |code: f64| -> Result<Camera> {
            let mut placed = DMat4::IDENTITY;
            for transform in &chain {
                let local = transform.at(code)?;
                placed = if transform.is_reset { local } else { placed * local };
            }
            let (eye, axes) = axes_of(&(self.to_world * placed))?;
            let mut values = [FOCAL_LENGTH, HORIZONTAL_APERTURE, VERTICAL_APERTURE, 0.0, 0.0];
            for (samples, value) in lens.iter().zip(&mut values) {
                if let Some(&[stated]) = samples.at(code).as_deref() {
                    *value = stated;
                }
            }
            let [focal, width, height, right, up] = values;
            Camera::with_window(eye, axes, [width, height].map(|size| size / 2.0 / focal), [right / focal, -up / focal])
        };
        let of = |camera: Camera, frames: Option<FrameRange>| FileCamera {
            name: name.to_owned(),
            size: None,
            timed: TimedCamera { camera, frames },
        };
        let moved = chain.iter().flat_map(|transform| transform.steps.iter().map(|step| &step.samples));
        let Some([first, last]) = moved.chain(&lens).filter_map(Samples::ends).reduce(join) else {
            return Ok(vec![of(at(0.0)?, None)]);
        };
        let [first, last] = [first, last].map(|code| code / self.codes_per_frame);
        let [first, last] = [(first - NEAR_FRAME).ceil(), (last + NEAR_FRAME).floor()];
        if first < 0.0 || last > f64::from(u32::MAX) || first > last {
            return Err(Error::unsupported(format!(
                "its time samples are between frames {first} and {last}: frames from 0 on were expected"
            )));
        }
        check_count(count, last - first + 1.0)?;
        let frames = first as u32..=last as u32;
        frames
            .map(|frame| {
                let camera = at(f64::from(frame) * self.codes_per_frame)?;
                Ok(of(camera, Some(FrameRange { first: frame, last: frame })))
            })
            .collect()
    }
}

fn join([a, b]: [f64; 2], [c, d]: [f64; 2]) -> [f64; 2] {
    [a.min(c), b.max(d)]
}

/// Transform from a prim to its parent.
struct Transform {
    steps: Vec<Step>,
    /// True if the transforms of the prim's parents are ignored.
    is_reset: bool,
}

struct Step {
    /// Name of the attribute, such as `xformOp:rotateX:tilt`.
    name: String,
    is_inverse: bool,
    samples: Samples,
}

impl Transform {
    fn of(prim: &Prim) -> Result<Transform> {
        let order = prim.attribute("xformOpOrder").get::<Value>().map_err(damaged)?;
        let order: Vec<String> = match order {
            None => Vec::new(),
            Some(Value::TokenVec(names)) => names.iter().map(|name| name.as_str().to_owned()).collect(),
            Some(_) => return Err(Error::invalid("\"xformOpOrder\" lists names")),
        };
        let mut transform = Transform { steps: Vec::new(), is_reset: false };
        for op in order {
            if op == "!resetXformStack!" {
                transform = Transform { steps: Vec::new(), is_reset: true };
                continue;
            }
            let name = op.strip_prefix("!invert!").unwrap_or(&op).to_owned();
            let samples = Samples::of(&prim.attribute(name.as_str()), kind(&name))?;
            if samples.keys.is_empty() {
                return Err(Error::invalid(format!("{name} of \"xformOpOrder\" has no value")));
            }
            transform.steps.push(Step { is_inverse: name.len() < op.len(), name, samples });
        }
        Ok(transform)
    }

    fn at(&self, code: f64) -> Result<DMat4> {
        let mut matrix = DMat4::IDENTITY;
        for step in &self.steps {
            let value = step.samples.at(code).unwrap_or_default();
            let own = matrix_of_step(&step.name, &value).map_err(|error| error.context(&step.name))?;
            matrix *= if step.is_inverse { own.inverse() } else { own };
        }
        Ok(matrix)
    }
}

/// Returns the kind of a transform operation, such as `rotateX`.
fn kind(name: &str) -> &str {
    name.split(':').nth(1).unwrap_or_default()
}

/// Value of an attribute over time.
struct Samples {
    /// Time codes with the numbers of the value, in increasing order; one of any time code for a value that does not change.
    keys: Vec<(f64, Vec<f64>)>,
    is_still: bool,
    /// Kind of the transform operation whose value it is, or empty.
    kind: String,
}

impl Samples {
    fn of(attribute: &Attribute, kind: &str) -> Result<Samples> {
        let times = attribute.time_sample_times().map_err(damaged)?;
        let mut keys = Vec::new();
        for &time in &times {
            let value = attribute.get_at::<Value>(openusd::usd::TimeCode::new(time)).map_err(damaged)?;
            keys.extend(value.map(|value| numbers(&value)).transpose()?.map(|numbers| (time, numbers)));
        }
        let is_still = keys.is_empty();
        if is_still {
            let value = attribute.get::<Value>().map_err(damaged)?;
            keys.extend(value.map(|value| numbers(&value)).transpose()?.map(|numbers| (0.0, numbers)));
        }
        Ok(Samples { keys, is_still, kind: kind.to_owned() })
    }

    /// Returns the first and last time code of samples.
    fn ends(&self) -> Option<[f64; 2]> {
        let ends = [self.keys.first()?.0, self.keys.last()?.0];
        (!self.is_still).then_some(ends)
    }

    /// Returns the value at a time code; `None` if the attribute has none.
    fn at(&self, code: f64) -> Option<Vec<f64>> {
        let behind = self.keys.partition_point(|(at, _)| *at <= code);
        match (behind.checked_sub(1).map(|at| &self.keys[at]), self.keys.get(behind)) {
            (Some((from_code, from)), Some((to_code, to))) => {
                Some(mix(from, to, (code - from_code) / (to_code - from_code), &self.kind))
            }
            (Some((_, value)), None) | (None, Some((_, value))) => Some(value.clone()),
            (None, None) => None,
        }
    }
}

/// Returns the matrix of a transform operation, by its name and value.
fn matrix_of_step(name: &str, value: &[f64]) -> Result<DMat4> {
    let kind = kind(name);
    let turn = |axis: char, degrees: f64| match axis {
        'X' => DMat4::from_rotation_x(degrees.to_radians()),
        'Y' => DMat4::from_rotation_y(degrees.to_radians()),
        _ => DMat4::from_rotation_z(degrees.to_radians()),
    };
    match kind {
        "transform" => {
            let rows =
                <[f64; 16]>::try_from(value).map_err(|_| Error::invalid("a matrix of 4 by 4 numbers was expected"))?;
            // USD matrices apply to row vectors, so the rows of the file are the columns of `DMat4`.
            Ok(DMat4::from_cols_array(&rows))
        }
        "translate" => Ok(DMat4::from_translation(three(value)?)),
        "translateX" | "translateY" | "translateZ" => Ok(DMat4::from_translation(along(kind) * one(value)?)),
        "scale" => Ok(DMat4::from_scale(three(value)?)),
        "scaleX" | "scaleY" | "scaleZ" => Ok(DMat4::from_scale(DVec3::ONE + along(kind) * (one(value)? - 1.0))),
        "orient" => match *value {
            [w, x, y, z] => Ok(DMat4::from_quat(DQuat::from_xyzw(x, y, z, w).normalize())),
            _ => Err(Error::invalid("a quaternion of four numbers was expected")),
        },
        "rotateX" | "rotateY" | "rotateZ" => Ok(turn(kind.chars().last().unwrap_or('X'), one(value)?)),
        "rotateXYZ" | "rotateXZY" | "rotateYXZ" | "rotateYZX" | "rotateZXY" | "rotateZYX" => {
            let degrees = three(value)?;
            let of = |axis: char| turn(axis, degrees[(axis as usize) - ('X' as usize)]);
            // The first axis is applied first.
            Ok(kind.chars().skip("rotate".len()).fold(DMat4::IDENTITY, |matrix, axis| of(axis) * matrix))
        }
        _ => Err(Error::unsupported("it is not a known operation")),
    }
}

/// Interpolates between two values; `kind` is the kind of transform operation.
fn mix(from: &[f64], to: &[f64], part: f64, kind: &str) -> Vec<f64> {
    match (kind, from, to) {
        (_, from, to) if from.len() != to.len() => from.to_vec(),
        ("transform", from, to) if from.len() == 16 => {
            let parts = |rows: &[f64]| DMat4::from_cols_slice(rows).to_scale_rotation_translation();
            let ((from_scale, from_turn, from_place), (to_scale, to_turn, to_place)) = (parts(from), parts(to));
            let matrix = DMat4::from_scale_rotation_translation(
                from_scale.lerp(to_scale, part),
                from_turn.slerp(to_turn, part),
                from_place.lerp(to_place, part),
            );
            matrix.to_cols_array().to_vec()
        }
        ("orient", &[a, b, c, d], &[e, f, g, h]) => {
            let of = |[w, x, y, z]: [f64; 4]| DQuat::from_xyzw(x, y, z, w).normalize();
            let turn = of([a, b, c, d]).slerp(of([e, f, g, h]), part);
            vec![turn.w, turn.x, turn.y, turn.z]
        }
        (_, from, to) => from.iter().zip(to).map(|(from, to)| from + (to - from) * part).collect(),
    }
}

/// Returns the axis that ends the name of an operation.
fn along(kind: &str) -> DVec3 {
    match kind.chars().last() {
        Some('X') => DVec3::X,
        Some('Y') => DVec3::Y,
        _ => DVec3::Z,
    }
}

fn text(value: &Value) -> Option<&str> {
    match value {
        Value::Token(token) => Some(token.as_str()),
        Value::String(text) => Some(text),
        _ => None,
    }
}

fn number(value: &Value) -> Result<f64> {
    match numbers(value)?[..] {
        [number] => Ok(number),
        _ => Err(Error::invalid("a number was expected")),
    }
}

/// Returns the numbers of a scalar, a vector, a matrix by rows, or a quaternion from w on.
fn numbers(value: &Value) -> Result<Vec<f64>> {
    Ok(match value {
        Value::Int(number) => vec![f64::from(*number)],
        Value::Uint(number) => vec![f64::from(*number)],
        Value::Int64(number) => vec![*number as f64],
        Value::Uint64(number) => vec![*number as f64],
        Value::Half(number) => vec![number.to_f64()],
        Value::Float(number) => vec![f64::from(*number)],
        Value::Double(number) => vec![*number],
        Value::Vec3h(v) => [v.x, v.y, v.z].map(|number| number.to_f64()).to_vec(),
        Value::Vec3f(v) => [v.x, v.y, v.z].map(f64::from).to_vec(),
        Value::Vec3d(v) => vec![v.x, v.y, v.z],
        Value::Quath(q) => [q.w, q.x, q.y, q.z].map(|number| number.to_f64()).to_vec(),
        Value::Quatf(q) => [q.w, q.x, q.y, q.z].map(f64::from).to_vec(),
        Value::Quatd(q) => vec![q.w, q.x, q.y, q.z],
        Value::Matrix4d(matrix) => matrix.0.to_vec(),
        _ => return Err(Error::invalid("a number, a vector, a matrix or a quaternion was expected")),
    })
}

fn one(value: &[f64]) -> Result<f64> {
    match *value {
        [number] => Ok(number),
        _ => Err(Error::invalid("a number was expected")),
    }
}

fn three(value: &[f64]) -> Result<DVec3> {
    let numbers = <[f64; 3]>::try_from(value);
    numbers.map(DVec3::from_array).map_err(|_| Error::invalid("three numbers were expected"))
}

pub fn write(cameras: &[FileCamera], settings: &WriteSettings) -> Result<Written> {
    let tracks = tracks(&poses(cameras)?);
    let frames = || tracks.iter().flat_map(|track| track.keys.iter().filter_map(|(frame, _)| *frame));
    let mut head = "    defaultPrim = \"Cameras\"\n    metersPerUnit = 1\n    upAxis = \"Y\"\n".to_owned();
    if let (Some(first), Some(last)) = (frames().min(), frames().max()) {
        let _ = writeln!(head, "    startTimeCode = {first}\n    endTimeCode = {last}");
        let _ = writeln!(head, "    timeCodesPerSecond = {0}\n    framesPerSecond = {0}", settings.fps);
    }
    let prims: String = tracks.iter().map(prim).collect();
    Ok(Written::File(format!("#usda 1.0\n(\n{head})\n\ndef Xform \"Cameras\"\n{{\n{prims}}}\n").into_bytes()))
}

fn prim(track: &Track) -> String {
    let focal = |camera: &Camera| WRITTEN_APERTURE / 2.0 / camera.half()[0];
    let lens = |camera: &Camera| {
        let ([_, half_v], [middle_u, middle_v], focal) = (camera.half(), camera.middle(), focal(camera));
        [focal, 2.0 * half_v * focal, middle_u * focal, -middle_v * focal]
    };
    const OF_LENS: [&str; 4] =
        ["focalLength", "verticalAperture", "horizontalApertureOffset", "verticalApertureOffset"];
    let mut text = format!("    def Camera \"{}\"\n    {{\n", track.name);
    if let Some((_, camera)) = track.keys.first().filter(|(_, camera)| camera.has_range()) {
        let [near_m, far_m] = camera.depth_m();
        let _ = writeln!(text, "        float2 clippingRange = ({near_m}, {})", far_m.min(1e30));
    }
    let _ = writeln!(text, "        float horizontalAperture = {WRITTEN_APERTURE}");
    for (at, name) in OF_LENS.into_iter().enumerate() {
        // Adding 0.0 turns a negative zero into a positive one.
        attribute(&mut text, &format!("float {name}"), track, |camera| (lens(camera)[at] + 0.0).to_string());
    }
    attribute(&mut text, "matrix4d xformOp:transform", track, |camera| {
        let rows = matrix_of(camera.eye(), camera.axes()).to_cols_array_2d();
        let row = |[a, b, c, d]: [f64; 4]| format!("({a}, {b}, {c}, {d})");
        format!("( {} )", rows.map(row).join(", "))
    });
    text + "        uniform token[] xformOpOrder = [\"xformOp:transform\"]\n    }\n"
}

/// Writes an attribute, with a single value or with time samples.
fn attribute(text: &mut String, name: &str, track: &Track, value: impl Fn(&Camera) -> String) {
    let keys: Vec<(Option<u32>, String)> = track.keys.iter().map(|(frame, camera)| (*frame, value(camera))).collect();
    let is_still = keys.windows(2).all(|pair| pair[0].1 == pair[1].1);
    match &keys[..] {
        // A moving camera always has samples of its transform, even if it does not change.
        [(frame, value), ..] if frame.is_none() || (is_still && !name.starts_with("matrix")) => {
            let _ = writeln!(text, "        {name} = {value}");
        }
        _ => {
            let _ = writeln!(text, "        {name}.timeSamples = {{");
            for (frame, value) in &keys {
                let _ = writeln!(text, "            {}: {value},", frame.unwrap_or(0));
            }
            let _ = writeln!(text, "        }}");
        }
    }
}
