//! Checks the consistency of a manifest without opening its files.

use std::collections::{BTreeMap, BTreeSet};

use super::{
    Background, FileDepth, MANIFEST_VERSION, MAX_SIDE, Manifest, Probe, Unit, check_intrinsics, file_pattern,
    pose_fault,
};
use crate::dataset::timed::TIME;
use codec::error::{Error, Result};
use codec::image::layout::eye_size;
use codec::image::{Face, Projection, StreamKind};

impl Manifest {
    pub fn validate(&self) -> Result<()> {
        let wrong = |message: String| Err(Error::invalid(message));
        if self.lightfield != MANIFEST_VERSION {
            return wrong(format!(
                "\"lightfield\" is {}, this program reads version {MANIFEST_VERSION}",
                self.lightfield
            ));
        }
        if self.name.is_empty() || self.name.contains(char::is_control) {
            return wrong("\"name\" must be a word or more, without control characters".into());
        }
        if !(self.fps.is_finite() && self.fps > 0.0) {
            return wrong(format!("\"fps\" is {}, it must be above 0", self.fps));
        }
        check_frames(self.frames).map_err(|error| error.context("\"frames\""))?;
        self.validate_size(self.size)?;
        if self.projection != Projection::Cubemap && self.faces.is_some() {
            return wrong("\"faces\" is only for projection \"cubemap\"".into());
        }
        if let Some(names) = &self.faces_present {
            self.validate_faces(names)?;
        }
        if let Some(names) = &self.face_names {
            self.validate_face_names(names)?;
        }
        if let Some(fault) = self.view.and_then(|view| view.fault()) {
            return wrong(format!("\"view\": {fault}"));
        }
        self.validate_depth()?;
        self.validate_files()?;
        self.validate_probes()
    }

    /// Checks the size of the image files of the dataset or of a probe.
    fn validate_size(&self, size: [u32; 2]) -> Result<()> {
        let wrong = |message: String| Err(Error::invalid(message));
        let [width, height] = size;
        if width == 0 || height == 0 || width > MAX_SIDE || height > MAX_SIDE {
            return wrong(format!("\"size\" is {width}x{height}, each side must be 1 to {MAX_SIDE} pixels"));
        }
        if self.stereo.is_some_and(|layout| eye_size(layout, size).is_none()) {
            return wrong(format!("\"size\" is {width}x{height}, which \"stereo\" cannot split into halves"));
        }
        let [width, height] = self.picture_in(size);
        if self.has_face_files() && width != height {
            return wrong(format!("\"size\" gives pictures of {width}x{height}, but the faces of a cube are square"));
        }
        Ok(())
    }

    fn validate_faces(&self, names: &[String]) -> Result<()> {
        if self.projection == Projection::Perspective {
            return Err(Error::invalid("\"faces_present\" is not for projection \"perspective\""));
        }
        let known = |name: &&String| Face::CUBE.iter().any(|face| face.name() == name.as_str());
        if let Some(name) = names.iter().find(|name| !known(name)) {
            let message = format!("\"faces_present\" names \"{name}\", the faces are px, nx, py, ny, pz, nz");
            return Err(Error::invalid(message));
        }
        if names.is_empty() || names.iter().collect::<BTreeSet<_>>().len() != names.len() {
            return Err(Error::invalid("\"faces_present\" must name at least one face, and each once"));
        }
        Ok(())
    }

    fn validate_face_names(&self, names: &BTreeMap<String, String>) -> Result<()> {
        let wrong = |message: String| Err(Error::invalid(format!("\"face_names\" {message}")));
        if !self.has_face_files() {
            return wrong("is for cube maps of six files".into());
        }
        for (face, name) in names {
            if !Face::CUBE.iter().any(|known| known.name() == face) {
                return wrong(format!("names \"{face}\", the faces are px, nx, py, ny, pz, nz"));
            }
            if name.is_empty() || name.contains(|c: char| c.is_control() || "{}%#@$<>".contains(c)) {
                return wrong(format!("calls {face} \"{name}\": use a word or more, without any of {{}}%#@$<>"));
            }
        }
        let all: BTreeSet<&str> = Face::CUBE.iter().map(|face| self.face_name(*face)).collect();
        if all.len() < Face::CUBE.len() {
            return wrong("gives two faces the same name".into());
        }
        Ok(())
    }

    fn validate_depth(&self) -> Result<()> {
        let Some(depth) = &self.depth else { return Ok(()) };
        let wrong = |message: String| Err(Error::invalid(message));
        match &depth.background {
            Background::Word(word) if word != "inf" => {
                return wrong(format!("depth \"background\" is \"{word}\", it must be a number or \"inf\""));
            }
            Background::Value(value) if !(*value as f32).is_finite() => {
                return wrong(format!("depth \"background\" is {value}, which is not a 32-bit float"));
            }
            _ => {}
        }
        if let Some([width, height]) = depth.size.filter(|size| size.iter().any(|side| !(1..=MAX_SIDE).contains(side)))
        {
            return wrong(format!("depth \"size\" is {width}x{height}, each side must be 1 to {MAX_SIDE} pixels"));
        }
        let metric = |value: Option<f64>| value.is_none_or(|value| value.is_finite() && value > 0.0);
        if depth.scale.is_some_and(|scale| !scale.is_finite() || scale == 0.0) {
            return wrong("depth \"scale\" is metres per unit, it must not be 0".into());
        }
        if depth.scale.is_some() && depth.unit.is_some_and(|unit| unit != Unit::M) {
            return wrong("depth has both a \"scale\" and a \"unit\" other than m: leave one out".into());
        }
        if !metric(depth.near) || !metric(depth.far) {
            return wrong("depth \"near\" and \"far\" must be above 0 metres".into());
        }
        if let (Some(near), Some(far)) = (depth.near, depth.far)
            && near > far
        {
            return wrong(format!("depth \"near\" is {near}, it must be below \"far\", {far}"));
        }
        if depth.kind == FileDepth::Disparity {
            if depth.unit.is_some() {
                return wrong(
                    "depth of \"kind\" \"disparity\" has a \"scale\", or \"near\" and \"far\", but no \"unit\"".into(),
                );
            }
            if depth.disparity().is_none() {
                return wrong(
                    "depth of \"kind\" \"disparity\" needs a \"scale\" (baseline in metres times focal length in \
                     pixels), or \"near\" and \"far\" in metres for the largest value and 0"
                        .into(),
                );
            }
        }
        if depth.kind == FileDepth::Planar && self.projection == Projection::Equirect {
            return wrong(
                "depth \"kind\" is \"planar\", but equirectangular images have no plane: use \"distance\"".into(),
            );
        }
        Ok(())
    }

    fn validate_files(&self) -> Result<()> {
        let streams = StreamKind::ALL.map(|kind| (kind.name(), self.files.get(kind), self.channels(kind)));
        let normal = ("normal", self.files.normal.as_deref(), Vec::new());
        for (name, text, channels) in streams.iter().chain([&normal]) {
            let Some(text) = text else { continue };
            let wrong = |what: String| Err(Error::invalid(format!("files \"{name}\": {what}")));
            let has = |mark: &str| text.contains(mark) || channels.iter().any(|channel| channel.contains(mark));
            let shared = self.probes.iter().enumerate().any(|(at, probe)| {
                self.probes[..at].iter().any(|other| self.stereo.is_none() || other.eye == probe.eye)
            });
            if shared && !has("{probe}") {
                return wrong(format!("\"{text}\" has no {{probe}}, so all probes would share files"));
            }
            if self.has_face_files() && self.faces().len() > 1 && !has("{face}") {
                return wrong(format!("\"{text}\" has no {{face}}, so all faces would share files"));
            }
            if !self.has_face_files() && text.contains("{face}") {
                return wrong(format!("\"{text}\" has {{face}}, but one image holds them all"));
            }
            let is_timed = text.contains(TIME);
            let file = text.rsplit('/').next().unwrap_or_default();
            if is_timed && (text.matches(TIME).count() > 1 || !file.contains(TIME)) {
                return wrong(format!("\"{text}\" must have {TIME} once, in the file name"));
            }
            if is_timed && *name == "normal" {
                return wrong(format!("\"{text}\" has {TIME}: number normal maps by frame"));
            }
            let pattern = file_pattern(text, "0", "px").map_err(|error| Error::invalid(error.to_string()))?;
            if is_timed && pattern.has_field() {
                return wrong(format!("\"{text}\" has both {TIME} and a place for the frame number"));
            }
            if !pattern.has_field() && !is_timed && self.frames[0] != self.frames[1] {
                return wrong(format!("\"{text}\" has no place for the frame number, such as %04d"));
            }
        }
        match streams.iter().any(|(_, text, _)| text.is_some()) {
            true => Ok(()),
            false => Err(Error::invalid("\"files\" names no color, depth, material or alpha")),
        }
    }

    fn validate_probes(&self) -> Result<()> {
        if self.probes.is_empty() {
            return Err(Error::invalid("\"probes\" is empty"));
        }
        let mut names = BTreeSet::new();
        for probe in &self.probes {
            let wrong = |what: String| Err(Error::invalid(format!("probe \"{}\": {what}", probe.name)));
            let position = probe.position.unwrap_or_default();
            if let Some(fault) = pose_fault(&probe.name, position, probe.orientation, probe.fov_y_deg) {
                return wrong(fault.into());
            }
            if !names.insert(&probe.name) {
                return wrong("there are two probes of this name".into());
            }
            if let Some(frames) = probe.frames {
                check_frames(frames).map_err(|error| error.context(format!("probe \"{}\": \"frames\"", probe.name)))?;
            }
            if let Some(Err(error)) = probe.size.map(|size| self.validate_size(size)) {
                return wrong(error.to_string());
            }
            if let Err(error) = self.validate_poses(probe) {
                return wrong(error.to_string());
            }
            match (self.stereo, probe.eye) {
                (None, Some(_)) => return wrong("\"eye\" is only for datasets with \"stereo\"".into()),
                (Some(_), None) => return wrong("it needs an \"eye\", left or right, as there is \"stereo\"".into()),
                _ => {}
            }
            let has_lens = probe.fov_y_deg.is_some() || probe.intrinsics.is_some();
            if has_lens && self.projection != Projection::Perspective {
                return wrong("\"fov_y_deg\" and \"intrinsics\" are only for projection \"perspective\"".into());
            }
            if probe.fov_y_deg.is_some() && probe.intrinsics.is_some() {
                return wrong("it has both \"fov_y_deg\" and \"intrinsics\": leave one out".into());
            }
            if let Some(intrinsics) = probe.intrinsics
                && let Err(error) = check_intrinsics(intrinsics)
            {
                return wrong(error.to_string());
            }
        }
        Ok(())
    }

    fn validate_poses(&self, probe: &Probe) -> Result<()> {
        if probe.poses.is_empty() {
            return match probe.position {
                Some(_) => Ok(()),
                None => Err(Error::invalid("it has neither a \"position\" nor \"poses\"")),
            };
        }
        if probe.orientation.is_some() {
            return Err(Error::invalid("it has \"poses\", which hold its orientations: leave \"orientation\" out"));
        }
        let mut frames = BTreeSet::new();
        for pose in &probe.poses {
            if let Some(fault) = pose_fault(&probe.name, pose.position, Some(pose.orientation), None) {
                return Err(Error::invalid(format!("\"poses\", frame {}: {fault}", pose.frame)));
            }
            if !frames.insert(pose.frame) {
                return Err(Error::invalid(format!("\"poses\" has frame {} twice", pose.frame)));
            }
        }
        let own = self.frames_of(probe);
        let mut inside = frames.range(own.first..=own.last);
        // Poses are sorted and distinct: the first frame that differs from the expected one follows the gap.
        if let Some(missing) = own.iter().find(|expected| inside.next() != Some(expected)) {
            return Err(Error::invalid(format!("\"poses\" lacks frame {missing}, of the frames {own}")));
        }
        let first = probe.first_pose(own).position;
        match probe.position {
            Some(position) if position != first => {
                Err(Error::invalid("\"position\" is not that of the first of its \"poses\": leave it out"))
            }
            _ => Ok(()),
        }
    }
}

fn check_frames([first, last]: [u32; 2]) -> Result<()> {
    if first <= last {
        return Ok(());
    }
    Err(Error::invalid(format!("first frame {first} comes after last frame {last}")))
}
