//! Properties of a container's footage, as attributes, which are omitted if they have their usual values (container.md 6.5).

use crate::container::index::{MAX_FRAME, is_probe_name};
use crate::container::{Attributes, Fields, Index};
use crate::error::{Error, Result};
use crate::image::{Face, Primaries, StreamKind};

const SECTION: &str = "container.md 6.5";
/// x and y of red, green, blue and white, as 32-bit floats.
const CHROMATICITIES: &str = "color.chromaticities";
/// Number of clipped pixels, as a 64-bit number.
const CLIPPED_PIXELS: &str = "color.clipped_pixels";
/// Rows of [`MissingFrame`], in ascending order.
const MISSING_FRAMES: &str = "frames.missing";
/// Rows of [`FramePose`], ascending by probe and frame.
const POSES: &str = "probes.poses";
/// A [`StartView`]: 7 64-bit floats.
const VIEW: &str = "view";
/// Stands for a frame of black colour and background depth.
const BLACK: u32 = u32::MAX;

/// A frame whose file was missing. The order of the values is that of the rows.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct MissingFrame {
    pub probe: String,
    pub kind: StreamKind,
    pub face: Face,
    pub frame: u32,
    /// Frame that replaces it; `None` for black colour and background depth.
    pub held: Option<u32>,
}

/// Pose of a moving probe in a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct FramePose {
    pub probe: String,
    pub frame: u32,
    /// Centre in metres.
    pub position: [f64; 3],
    /// Unit quaternion x, y, z, w that rotates the probe's axes into those of the world.
    pub orientation: [f64; 4],
}

impl FramePose {
    fn place(&self) -> (&str, u32) {
        (&self.probe, self.frame)
    }
}

impl MissingFrame {
    fn place(&self) -> (&str, StreamKind, Face, u32) {
        (&self.probe, self.kind, self.face, self.frame)
    }
}

/// Camera with which players open a film.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "encode", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct StartView {
    /// Position in metres.
    pub eye: [f64; 3],
    /// A point straight ahead in metres, other than `eye`; +Y is up.
    pub look_at: [f64; 3],
    /// Vertical field of view in degrees, above 0 and below 180.
    pub fov_y_deg: f64,
}

impl StartView {
    /// Returns the rule that the view breaks, if any.
    pub fn fault(&self) -> Option<&'static str> {
        let is_finite = self.eye.iter().chain(&self.look_at).all(|value| value.is_finite());
        if !is_finite || self.eye == self.look_at {
            return Some("eye and look_at must be two different points");
        }
        let is_angle = self.fov_y_deg > 0.0 && self.fov_y_deg < 180.0;
        (!is_angle).then_some("fov_y_deg must be above 0 and below 180")
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct FootageInfo {
    /// Primaries of colour; Rec. 709 has no attribute.
    pub primaries: Primaries,
    /// Number of colour pixels that were clipped when they were encoded in 8 bits; `None` if there were none, or if it is
    /// unknown.
    pub clipped_pixels: Option<u64>,
    pub missing_frames: Vec<MissingFrame>,
    /// Poses of moving probes, ascending by probe and frame when read.
    pub poses: Vec<FramePose>,
    /// Camera with which players open the film, if the footage states one.
    pub view: Option<StartView>,
}

impl Default for FootageInfo {
    fn default() -> Self {
        FootageInfo {
            primaries: Primaries::REC709,
            clipped_pixels: None,
            missing_frames: Vec::new(),
            poses: Vec::new(),
            view: None,
        }
    }
}

impl FootageInfo {
    /// Reads the attributes of an index.
    ///
    /// # Errors
    /// If an attribute has an invalid value.
    pub fn read(index: &Index) -> Result<FootageInfo> {
        FootageInfo::of(&index.attributes)
    }

    fn of(attributes: &Attributes) -> Result<FootageInfo> {
        let mut read = FootageInfo::default();
        if let Some(value) = attributes.get(CHROMATICITIES) {
            read.primaries = in_attribute(CHROMATICITIES, value, read_primaries)?;
        }
        if let Some(value) = attributes.get(CLIPPED_PIXELS) {
            read.clipped_pixels = Some(in_attribute(CLIPPED_PIXELS, value, |fields| fields.u64())?);
        }
        if let Some(value) = attributes.get(MISSING_FRAMES) {
            read.missing_frames = in_attribute(MISSING_FRAMES, value, read_missing_frames)?;
        }
        if let Some(value) = attributes.get(POSES) {
            read.poses = in_attribute(POSES, value, read_poses)?;
        }
        if let Some(value) = attributes.get(VIEW) {
            read.view = Some(in_attribute(VIEW, value, read_view)?);
        }
        Ok(read)
    }

    /// Returns the pose of a probe in a frame; `None` for a stationary probe.
    pub fn pose(&self, probe: &str, frame: u32) -> Option<&FramePose> {
        self.poses.binary_search_by(|pose| pose.place().cmp(&(probe, frame))).ok().map(|at| &self.poses[at])
    }

    /// Returns the poses of a probe, by frame; empty for a stationary probe.
    pub fn poses_of(&self, probe: &str) -> &[FramePose] {
        let start = self.poses.partition_point(|pose| pose.probe.as_str() < probe);
        let count = self.poses[start..].partition_point(|pose| pose.probe == probe);
        &self.poses[start..start + count]
    }

    /// Returns the names and values of the attributes, without those that have their usual values.
    pub fn to_values(&self) -> Vec<(&'static str, Vec<u8>)> {
        let mut values = Vec::new();
        if !self.primaries.is_rec709() {
            values.push((CHROMATICITIES, self.primaries.to_array().into_iter().flat_map(f32::to_le_bytes).collect()));
        }
        if let Some(count) = self.clipped_pixels {
            values.push((CLIPPED_PIXELS, count.to_le_bytes().to_vec()));
        }
        let mut rows: Vec<&MissingFrame> = self.missing_frames.iter().collect();
        rows.sort_unstable();
        rows.dedup();
        let mut bytes = Vec::new();
        for MissingFrame { probe, kind, face, frame, held } in rows {
            // Probe names have at most 100 bytes.
            bytes.extend((probe.len() as u16).to_le_bytes());
            bytes.extend(probe.as_bytes());
            bytes.extend([*kind as u8, *face as u8]);
            bytes.extend(frame.to_le_bytes());
            bytes.extend(held.unwrap_or(BLACK).to_le_bytes());
        }
        if !bytes.is_empty() {
            values.push((MISSING_FRAMES, bytes));
        }
        let mut poses: Vec<&FramePose> = self.poses.iter().collect();
        poses.sort_by_key(|pose| pose.place());
        poses.dedup_by_key(|pose| pose.place());
        let mut bytes = Vec::new();
        for FramePose { probe, frame, position, orientation } in poses {
            bytes.extend((probe.len() as u16).to_le_bytes());
            bytes.extend(probe.as_bytes());
            bytes.extend(frame.to_le_bytes());
            bytes.extend(position.iter().chain(orientation).flat_map(|value| value.to_le_bytes()));
        }
        if !bytes.is_empty() {
            values.push((POSES, bytes));
        }
        if let Some(StartView { eye, look_at, fov_y_deg }) = self.view {
            let numbers = eye.into_iter().chain(look_at).chain([fov_y_deg]);
            values.push((VIEW, numbers.flat_map(f64::to_le_bytes).collect()));
        }
        values
    }

    /// True if `name` is one of these attributes.
    pub fn has(name: &str) -> bool {
        [CHROMATICITIES, CLIPPED_PIXELS, MISSING_FRAMES, POSES, VIEW].contains(&name)
    }

    /// Joins the properties of a container with other streams or frames. The primaries are those of `other` if only `other`
    /// has colour; the view is that of `self`, if it has one.
    ///
    /// # Errors
    /// If both have colour, with different primaries.
    pub fn join(&mut self, other: FootageInfo, has_color: [bool; 2]) -> Result<()> {
        match has_color {
            [true, true] if !self.primaries.is_same(other.primaries) => {
                let [earlier, own] = [self.primaries, other.primaries].map(Primaries::to_array);
                return Err(Error::invalid(format!(
                    "the chromaticities of its colour are {own:?}, those of an earlier input {earlier:?}: decode one \
                    with `color_space`, and encode it again"
                )));
            }
            [false, true] => self.primaries = other.primaries,
            _ => {}
        }
        let clipped = self.clipped_pixels.unwrap_or(0).saturating_add(other.clipped_pixels.unwrap_or(0));
        self.clipped_pixels = Some(clipped).filter(|count| *count > 0);
        self.missing_frames.extend(other.missing_frames);
        self.poses.extend(other.poses);
        self.view = self.view.or(other.view);
        Ok(())
    }
}

/// Reads a complete value. Errors name the attribute, and have byte offsets from the start of its value.
fn in_attribute<T>(name: &str, value: &[u8], read: impl FnOnce(&mut Fields<'_>) -> Result<T>) -> Result<T> {
    let mut fields = Fields::new(value, 0, SECTION);
    let found = read(&mut fields).and_then(|found| fields.finish().map(|()| found));
    found.map_err(|error| match error {
        Error::Invalid { file, offset, message, .. } => {
            let place = offset.map(|offset| format!(", byte {offset} of its value")).unwrap_or_default();
            let message = format!("attribute {name}{place}: {message}");
            Error::Invalid { file, offset: None, section: SECTION, message }
        }
        error => error,
    })
}

fn read_primaries(fields: &mut Fields<'_>) -> Result<Primaries> {
    let mut values = [0.0; 8];
    for value in &mut values {
        *value = fields.f32()?;
    }
    Primaries::from_array(values)
}

fn read_missing_frames(fields: &mut Fields<'_>) -> Result<Vec<MissingFrame>> {
    let mut rows: Vec<MissingFrame> = Vec::new();
    while fields.remaining() > 0 {
        let start = fields.offset();
        let probe = read_probe_name(fields)?;
        let [kind, face] = [fields.u8()?, fields.u8()?];
        let known_kind = StreamKind::ALL.into_iter().find(|known| *known as u8 == kind);
        let (Some(known_kind), Some(known_face)) = (known_kind, Face::from_index(face)) else {
            return Err(fields.error_at(start, format!("a stream of kind {kind} and face {face} is unknown")));
        };
        let [frame, held] = fields.u32s()?;
        let held = Some(held).filter(|held| *held != BLACK);
        for frame in [Some(frame), held].into_iter().flatten() {
            check_frame(fields, start, frame)?;
        }
        let row = MissingFrame { probe, kind: known_kind, face: known_face, frame, held };
        if rows.last().is_some_and(|before| before.place() >= row.place()) {
            return Err(fields.error_at(start, "rows do not ascend by probe, kind, face and frame"));
        }
        rows.push(row);
    }
    Ok(rows)
}

fn read_poses(fields: &mut Fields<'_>) -> Result<Vec<FramePose>> {
    let mut rows: Vec<FramePose> = Vec::new();
    while fields.remaining() > 0 {
        let start = fields.offset();
        let (probe, frame) = (read_probe_name(fields)?, fields.u32()?);
        check_frame(fields, start, frame)?;
        let position = fields.finite_f64s("a position")?;
        let row = FramePose { probe, frame, position, orientation: fields.finite_f64s("an orientation")? };
        if rows.last().is_some_and(|before| before.place() >= row.place()) {
            return Err(fields.error_at(start, "rows do not ascend by probe and frame"));
        }
        rows.push(row);
    }
    Ok(rows)
}

fn read_view(fields: &mut Fields<'_>) -> Result<StartView> {
    let start = fields.offset();
    let (eye, look_at) = (fields.finite_f64s("an eye")?, fields.finite_f64s("a point")?);
    let view = StartView { eye, look_at, fov_y_deg: fields.finite_f64("a field of view")? };
    match view.fault() {
        None => Ok(view),
        Some(fault) => Err(fields.error_at(start, fault)),
    }
}

fn read_probe_name(fields: &mut Fields<'_>) -> Result<String> {
    let start = fields.offset();
    let name = fields.string("a probe's name")?;
    match is_probe_name(&name) {
        true => Ok(name),
        false => Err(fields.error_at(start, format!("{name:?} is not a probe name"))),
    }
}

/// Fails if a frame number in the row at `start` is too large.
fn check_frame(fields: &Fields<'_>, start: u64, frame: u32) -> Result<()> {
    if frame < MAX_FRAME {
        return Ok(());
    }
    Err(fields.error_at(start, format!("frame {frame}, frames are numbered below {MAX_FRAME}")))
}

#[cfg(feature = "encode")]
#[cfg(test)]
mod tests {
    use super::*;

    fn read(values: Vec<(&'static str, Vec<u8>)>) -> Result<FootageInfo> {
        let mut attributes = Attributes::default();
        values.into_iter().for_each(|(name, value)| attributes.set(name, value));
        FootageInfo::of(&attributes)
    }

    fn missing(probe: &str, frame: u32, held: Option<u32>) -> MissingFrame {
        MissingFrame { probe: probe.to_owned(), kind: StreamKind::Depth, face: Face::Nz, frame, held }
    }

    fn pose(probe: &str, frame: u32) -> FramePose {
        let position = [0.1, -2.0, f64::from(frame)];
        FramePose { probe: probe.to_owned(), frame, position, orientation: [0.0, 0.6, 0.0, 0.8] }
    }

    const VIEW_OF_TEST: StartView = StartView { eye: [0.0, 1.5, 2.0], look_at: [0.0, 1.0, -3.0], fov_y_deg: 50.0 };

    #[test]
    fn what_is_not_as_usual_comes_back_and_the_usual_takes_no_bytes() {
        assert!(FootageInfo::default().to_values().is_empty());
        assert_eq!(read(Vec::new()).unwrap(), FootageInfo::default());
        let all = FootageInfo {
            primaries: Primaries::ACESCG,
            clipped_pixels: Some(1 << 40),
            missing_frames: vec![missing("00", 3, Some(2)), missing("00", 4, None), missing("left", 0, None)],
            poses: vec![pose("a", 7), pose("a", 9), pose("b", 7)],
            view: Some(VIEW_OF_TEST),
        };
        assert_eq!((all.pose("a", 9), all.pose("a", 8)), (Some(&pose("a", 9)), None));
        let frames = |probe| all.poses_of(probe).iter().map(|pose| pose.frame).collect::<Vec<_>>();
        assert_eq!(["a", "aa", "b", "c"].map(frames), [vec![7, 9], vec![], vec![7], vec![]]);
        assert_eq!(read(all.to_values()).unwrap(), all);
        let backwards =
            FootageInfo { missing_frames: all.missing_frames.iter().rev().cloned().collect(), ..all.clone() };
        assert_eq!(backwards.to_values(), all.to_values());
    }

    #[test]
    fn parts_are_joined() {
        let one =
            FootageInfo { clipped_pixels: Some(2), missing_frames: vec![missing("b", 1, None)], ..Default::default() };
        let other = FootageInfo { primaries: Primaries::REC2020, clipped_pixels: Some(3), ..FootageInfo::default() };
        let mut joined = one.clone();
        joined.join(other.clone(), [false, true]).unwrap();
        assert_eq!((joined.primaries, joined.clipped_pixels), (Primaries::REC2020, Some(5)));
        assert_eq!(joined.missing_frames, one.missing_frames);
        assert!(joined.join(one.clone(), [true, true]).unwrap_err().to_string().contains("chromaticities"));
        joined.join(one, [true, false]).unwrap();
        assert_eq!(joined.primaries, Primaries::REC2020);
    }

    #[test]
    fn values_that_break_a_rule_are_refused_with_their_attribute_and_section() {
        let missing = |rows: &[(&[u8], u8, u8, u32, u32)]| {
            let row = |(probe, kind, face, frame, held): &(&[u8], u8, u8, u32, u32)| {
                let head = [&[probe.len() as u8, 0], *probe, &[*kind, *face]].concat();
                [&head[..], &frame.to_le_bytes(), &held.to_le_bytes()].concat()
            };
            rows.iter().flat_map(row).collect::<Vec<u8>>()
        };
        let poses = |places: &[(&str, u32)]| {
            let poses = places.iter().map(|(probe, frame)| pose(probe, *frame)).collect::<Vec<_>>();
            let rows = poses.iter().map(|pose| {
                let alone = FootageInfo { poses: vec![pose.clone()], ..FootageInfo::default() };
                alone.to_values().remove(0).1
            });
            rows.collect::<Vec<_>>().concat()
        };
        assert_eq!(read(vec![(MISSING_FRAMES, missing(&[(b"a", 1, 0, 3, BLACK)]))]).unwrap().missing_frames.len(), 1);
        let view = |numbers: [f64; 7]| numbers.into_iter().flat_map(f64::to_le_bytes).collect::<Vec<u8>>();
        let order = "rows do not ascend";
        for (name, value, words) in [
            (CHROMATICITIES, vec![0; 31], "more bytes expected"),
            (CHROMATICITIES, vec![0; 32], "do not define a colour space"),
            (CHROMATICITIES, vec![0; 33], "do not define a colour space"),
            (CLIPPED_PIXELS, vec![0; 7], "more bytes expected"),
            (CLIPPED_PIXELS, vec![0; 9], "1 bytes after the last field"),
            (MISSING_FRAMES, missing(&[(b"a", 1, 0, 3, 2)])[..12].to_vec(), "more bytes expected"),
            (MISSING_FRAMES, missing(&[(b"a", 4, 0, 3, 2)]), "kind 4 and face 0"),
            (MISSING_FRAMES, missing(&[(b"a", 1, 7, 3, 2)]), "kind 1 and face 7"),
            (MISSING_FRAMES, missing(&[(b"", 1, 0, 3, 2)]), "\"\" is not a probe name"),
            (MISSING_FRAMES, missing(&[(b"a/b", 1, 0, 3, 2)]), "\"a/b\" is not a probe name"),
            (MISSING_FRAMES, missing(&[(b"\xff", 1, 0, 3, 2)]), "not UTF-8"),
            (MISSING_FRAMES, missing(&[(b"a", 1, 0, 1 << 31, 2)]), "frame 2147483648"),
            (MISSING_FRAMES, missing(&[(b"a", 1, 0, BLACK, 2)]), "frame 4294967295"),
            (MISSING_FRAMES, missing(&[(b"a", 1, 0, 3, 1 << 31)]), "frame 2147483648"),
            (MISSING_FRAMES, missing(&[(b"b", 0, 0, 0, 0), (b"a", 1, 0, 3, 2)]), order),
            (MISSING_FRAMES, missing(&[(b"a", 1, 0, 0, 0), (b"a", 0, 0, 3, 2)]), order),
            (MISSING_FRAMES, missing(&[(b"a", 1, 1, 0, 0), (b"a", 1, 0, 3, 2)]), order),
            (MISSING_FRAMES, missing(&[(b"a", 1, 0, 4, 2), (b"a", 1, 0, 3, 2)]), order),
            (MISSING_FRAMES, missing(&[(b"a", 1, 0, 3, 2), (b"a", 1, 0, 3, 2)]), order),
            (MISSING_FRAMES, missing(&[(b"a", 1, 0, 3, 1), (b"a", 1, 0, 3, 2)]), order),
            (POSES, poses(&[("a", 0)])[..62].to_vec(), "more bytes expected"),
            (POSES, poses(&[("b", 0), ("a", 1)]), order),
            (POSES, poses(&[("a", 2), ("a", 1)]), order),
            (POSES, poses(&[("a", 1), ("a", 1)]), order),
            (POSES, poses(&[(".a", 1)]), "not a probe name"),
            (POSES, poses(&[("a", 1 << 31)]), "frame 2147483648"),
            (VIEW, view([0.0; 7])[..55].to_vec(), "more bytes expected"),
            (VIEW, view([1.0, 2.0, 3.0, 1.0, 2.0, 3.0, 50.0]), "two different points"),
            (VIEW, view([1.0, 2.0, 3.0, f64::INFINITY, 2.0, 3.0, 50.0]), "a point is inf"),
            (VIEW, view([1.0, 2.0, 3.0, 0.0, 2.0, 3.0, 180.0]), "above 0 and below 180"),
            (VIEW, view([1.0, 2.0, 3.0, 0.0, 2.0, 3.0, 0.0]), "above 0 and below 180"),
            (POSES, [&poses(&[("a", 1)])[..7], &f64::NAN.to_le_bytes(), &[0; 48]].concat(), "a position is NaN"),
        ] {
            let message = read(vec![(name, value)]).unwrap_err().to_string();
            assert!(message.starts_with(&format!("attribute {name}")), "{message}");
            assert!(message.contains(words) && message.ends_with("(formats/container.md 6.5)"), "{message}");
        }
    }
}
