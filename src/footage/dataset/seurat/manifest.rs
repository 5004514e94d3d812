//! The JSON manifest of a Seurat capture (formats/manifest.md 5). Keys that the Seurat release ignores are noted.

use std::path::Path;

use glam::DVec3;
use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::Value;

use super::camera::{CameraMatrices, DepthType, SeuratCamera};
use super::json::{Node, Notes};
use super::view::{Channel, ImageFile, SeuratView};
use crate::account::Account;
use crate::dataset::manifest::{MANIFEST_NAME, MAX_SIDE, read_text};
use crate::text;
use codec::error::{Error, Result};

/// Channel names that denote a constant value.
const CONSTANTS: [(&str, f32); 2] = [("CONSTANT_ZERO", 0.0), ("CONSTANT_ONE", 1.0)];

/// A parsed manifest. Images are read separately, view by view.
#[derive(Debug, Clone)]
pub struct SeuratCapture {
    /// Centre of the viewing region in metres, in the space of the cameras.
    pub headbox_center: Option<DVec3>,
    pub group_count: usize,
    /// All views, ordered by group.
    pub views: Vec<SeuratView>,
    /// Keys that are ignored, and values that are probably wrong; one sentence each.
    pub notes: Vec<String>,
}

/// Returns true if a file should be read as a Seurat manifest: it has the extension .json, and neither its name nor its content
/// is that of a `lightfield.json`.
pub fn is_manifest(path: &Path) -> bool {
    #[derive(Deserialize)]
    struct Head {
        lightfield: Option<IgnoredAny>,
    }
    let is_json = path.extension().is_some_and(|extension| extension == "json");
    if !is_json || path.file_name().is_some_and(|name| name == MANIFEST_NAME) {
        return false;
    }
    let Ok(bytes) = read_text(path) else { return false };
    text::json::<Head>(&bytes, "a manifest").map_or(true, |head| head.lightfield.is_none())
}

impl SeuratCapture {
    pub fn open(path: &Path) -> Result<SeuratCapture> {
        let folder = path.parent().unwrap_or(Path::new(""));
        SeuratCapture::from_json(&read_text(path)?, folder).map_err(|error| error.in_file(path))
    }

    /// Parses and checks a manifest; file paths are relative to `folder`.
    pub fn from_json(bytes: &[u8], folder: &Path) -> Result<SeuratCapture> {
        let value: Value = text::json(bytes, "a Seurat manifest")?;
        let root = Node::root(&value);
        let groups = root.get("view_groups")?.ok_or_else(|| {
            Error::invalid("the key \"view_groups\" is missing, the list of views of a Seurat manifest")
        })?;
        let mut notes = Notes::default();
        root.note_unknown(&["headbox_center", "view_groups"], &mut notes)?;
        let headbox_center = match root.get("headbox_center")? {
            Some(center) => Some(DVec3::from_array(center.numbers()?)),
            None => None,
        };
        let (mut views, mut group_count) = (Vec::new(), 0);
        for (group_index, group) in groups.list()?.enumerate() {
            group.note_unknown(&["views"], &mut notes)?;
            for (index, view) in group.need("views")?.list()?.enumerate() {
                let reader = ViewReader { folder, place: [group_index, index] };
                views.push(reader.view(&view, &mut notes)?);
            }
            group_count += 1;
        }
        Ok(SeuratCapture { headbox_center, group_count, views, notes: notes.lines() })
    }

    /// Returns the account: views, image files and their channels; keys that are ignored are left out. Image files are not opened, so
    /// other channels of theirs are not named.
    pub fn account(&self) -> Account {
        let mut account = Account { left_out: self.notes.clone(), ..Account::default() };
        account.add("view", self.views.iter().map(SeuratView::json_path));
        for view in &self.views {
            let names = |channels: &[Channel]| -> Vec<String> {
                channels.iter().filter_map(Channel::name).map(str::to_owned).collect()
            };
            for (path, channels) in
                [(&view.color.path, names(&view.color.channels)), (&view.depth.path, names(&view.depth.channels))]
            {
                account.add("file", (!channels.is_empty()).then(|| path.display().to_string()));
                account.add("channel", channels);
            }
        }
        account
    }

    /// Returns the bounding box of the camera positions in metres, minimum and maximum; `None` without views.
    pub fn cameras_box(&self) -> Option<[DVec3; 2]> {
        let positions = self.views.iter().map(|view| view.camera.position());
        positions.fold(None, |found, at| {
            let [least, greatest] = found.unwrap_or([at; 2]);
            Some([least.min(at), greatest.max(at)])
        })
    }
}

struct ViewReader<'a> {
    folder: &'a Path,
    place: [usize; 2],
}

impl ViewReader<'_> {
    fn view(&self, node: &Node<'_>, notes: &mut Notes) -> Result<SeuratView> {
        node.note_unknown(&["projective_camera", "depth_image_file"], notes)?;
        let camera = camera(&node.need("projective_camera")?, notes)?;
        let image = node.need("depth_image_file")?;
        image.note_unknown(&["color", "depth"], notes)?;
        let color_keys = ["channel_0", "channel_1", "channel_2", "channel_alpha"];
        let color = self.file(&image.need("color")?, color_keys, notes)?;
        let depth_node = image.need("depth")?;
        let depth = self.file(&depth_node, ["channel_0"], notes)?;
        if depth.channels == [Channel::Named("A".to_owned())] {
            notes.add(format!("{}.channel_0 is A, which usually is an alpha and no depth", depth_node.kind()));
        }
        Ok(SeuratView { place: self.place, camera, color, depth })
    }

    fn file<const N: usize>(&self, node: &Node<'_>, keys: [&str; N], notes: &mut Notes) -> Result<ImageFile<N>> {
        let known: Vec<&str> = keys.into_iter().chain(["path"]).collect();
        node.note_unknown(&known, notes)?;
        let mut channels = keys.map(|_| Channel::Constant(0.0));
        for (channel, key) in channels.iter_mut().zip(keys) {
            let name = node.need(key)?.text()?;
            let constant = CONSTANTS.iter().find(|(constant, _)| *constant == name);
            *channel = constant.map_or_else(|| Channel::Named(name.to_owned()), |(_, value)| Channel::Constant(*value));
        }
        let is_read = channels.iter().any(|channel| matches!(channel, Channel::Named(_)));
        let path = match node.get("path")? {
            Some(path) => path.text()?,
            None => "",
        };
        if is_read && path.is_empty() {
            return Err(node.fault("\"path\" names no file, and not all channels are constants"));
        }
        // `join` keeps an absolute path unchanged.
        Ok(ImageFile { path: self.folder.join(path), channels })
    }
}

fn camera(node: &Node<'_>, notes: &mut Notes) -> Result<SeuratCamera> {
    let keys = ["image_width", "image_height", "clip_from_eye_matrix", "world_from_eye_matrix", "depth_type"];
    node.note_unknown(&keys, notes)?;
    let [width, height, clip_from_eye, world_from_eye, depth_type] = keys;
    let size = [node.need(width)?.count(MAX_SIDE)?, node.need(height)?.count(MAX_SIDE)?];
    let matrices = CameraMatrices {
        clip_from_eye: node.need(clip_from_eye)?.numbers()?,
        world_from_eye: node.need(world_from_eye)?.numbers()?,
    };
    let depth_node = node.need(depth_type)?;
    let name = depth_node.text()?;
    let depth_type = DepthType::ALL.into_iter().find(|depth_type| depth_type.name() == name);
    let depth_type = depth_type.ok_or_else(|| depth_node.expected("WINDOW_Z, EYE_Z or RAY_DEPTH"))?;
    SeuratCamera::new(size, depth_type, &matrices).map_err(|error| error.context(node.path()))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use serde_json::json;
    use tempfile::TempDir;

    use super::*;

    const IDENTITY: [f64; 16] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];

    fn view(x: f64) -> Value {
        let mut pose = IDENTITY;
        (pose[3], pose[15]) = (2.0 * x, 2.0);
        let constants =
            ["channel_0", "channel_1", "channel_2", "channel_alpha"].map(|key| (key.to_owned(), json!("R")));
        let mut color = serde_json::Map::from_iter(constants);
        color.insert("path".into(), "c.exr".into());
        json!({
            "projective_camera": {
                "image_width": 6, "image_height": 4, "depth_type": "EYE_Z",
                "clip_from_eye_matrix": IDENTITY, "world_from_eye_matrix": pose,
            },
            "depth_image_file": { "color": color, "depth": { "path": "d.exr", "channel_0": "Z" } },
        })
    }

    fn manifest() -> Value {
        json!({ "headbox_center": [1, 2.5, -3], "view_groups": [{ "views": [view(4.0), view(-1.0)] }, { "views": [] }] })
    }

    fn parsed(manifest: &Value) -> Result<SeuratCapture> {
        SeuratCapture::from_json(manifest.to_string().as_bytes(), Path::new("folder"))
    }

    #[test]
    fn a_manifest_holds_views_and_cameras() {
        let capture = parsed(&manifest()).unwrap();
        assert_eq!(capture.headbox_center, Some(DVec3::new(1.0, 2.5, -3.0)));
        assert_eq!((capture.group_count, capture.views.len()), (2, 2));
        assert_eq!(capture.cameras_box(), Some([DVec3::NEG_X, DVec3::X * 4.0]));
        let view = &capture.views[1];
        assert_eq!((view.json_path().as_str(), view.size()), ("view_groups[0].views[1]", [6, 4]));
        assert_eq!(view.depth.path, Path::new("folder/d.exr"));
        assert_eq!(view.depth.channels, [Channel::Named("Z".into())]);
        assert!(capture.notes.is_empty(), "{:?}", capture.notes);
        let empty = parsed(&json!({ "view_groups": [] })).unwrap();
        assert!(empty.views.is_empty() && empty.cameras_box().is_none() && empty.headbox_center.is_none());
    }

    #[test]
    fn unknown_keys_and_alphas_as_depth_are_noted() {
        let mut manifest = manifest();
        manifest["version"] = json!(3);
        for at in [0, 1] {
            let view = &mut manifest["view_groups"][0]["views"][at];
            view["projective_camera"]["fov"] = json!(90);
            view["depth_image_file"]["depth"]["channel_0"] = json!("A");
        }
        assert_eq!(
            parsed(&manifest).unwrap().notes,
            [
                "version is not read",
                "view_groups[].views[].depth_image_file.depth.channel_0 is A, which usually is an alpha and no depth (2 times)",
                "view_groups[].views[].projective_camera.fov is not read (2 times)",
            ]
        );
    }

    #[test]
    fn errors_name_the_path() {
        let camera = "/view_groups/0/views/1/projective_camera";
        let files = "/view_groups/0/views/1/depth_image_file";
        for (pointer, value, says) in [
            ("/headbox_center".to_owned(), json!([1, 2]), "headbox_center: a list of 3 numbers"),
            ("/view_groups".to_owned(), json!({}), "view_groups: a list"),
            ("/view_groups/1".to_owned(), json!([]), "view_groups[1]: an object"),
            ("/view_groups/1/views".to_owned(), json!(null), "view_groups[1]: the key \"views\" is missing"),
            (format!("{camera}/image_width"), json!(0), "image_width: a whole number of 1 to 65536"),
            (format!("{camera}/image_height"), json!(4294967296u64), "not 4294967296"),
            (format!("{camera}/clip_from_eye_matrix"), json!([1]), "clip_from_eye_matrix: a list of 16"),
            (
                format!("{camera}/clip_from_eye_matrix/5"),
                json!(0),
                "projective_camera: clip_from_eye_matrix is singular",
            ),
            (
                format!("{camera}/world_from_eye_matrix/5"),
                json!("1"),
                "world_from_eye_matrix[5]: a number was expected",
            ),
            (
                format!("{camera}/depth_type"),
                json!("Z"),
                "depth_type: WINDOW_Z, EYE_Z or RAY_DEPTH was expected, not the text",
            ),
            (format!("{files}/color"), json!(null), "the key \"color\" is missing"),
            (format!("{files}/color/channel_1"), json!(1), "color.channel_1: a text"),
            (format!("{files}/depth/path"), json!(""), "depth_image_file.depth: \"path\" names no file"),
        ] {
            let mut manifest = manifest();
            *manifest.pointer_mut(&pointer).unwrap() = value;
            let error = parsed(&manifest).unwrap_err().to_string();
            assert!(error.contains(says), "{pointer}: {error}");
            let is_of_view = pointer.contains("/views/1");
            assert_eq!(error.contains("view_groups[0].views[1]"), is_of_view, "{pointer}: {error}");
        }
        assert!(parsed(&json!({})).unwrap_err().to_string().contains("\"view_groups\""));
        assert!(parsed(&json!([])).unwrap_err().to_string().contains("an object was expected"));
    }

    #[test]
    fn files_are_told_apart() {
        let folder = TempDir::new().unwrap();
        let is_seurat = |name: &str, text: &str| {
            let path = folder.path().join(name);
            fs::write(&path, text).unwrap();
            is_manifest(&path)
        };
        assert!(is_seurat("a.json", "\u{feff}{\"view_groups\": []}"));
        assert!(SeuratCapture::open(&folder.path().join("a.json")).is_ok());
        assert!(is_seurat("a.json", "no JSON"));
        let error = SeuratCapture::open(&folder.path().join("a.json")).unwrap_err().to_string();
        assert!(error.contains("a.json: this is not JSON"), "{error}");
        assert!(!is_seurat("a.json", "{\"lightfield\": 1, \"view_groups\": []}"));
        assert!(!is_seurat("lightfield.json", "{\"view_groups\": []}"));
        assert!(!is_seurat("a.exr", "{\"view_groups\": []}"));
        assert!(!is_manifest(&folder.path().join("none.json")) && !is_manifest(folder.path()));
    }
}
