//! Opens datasets and image sequences: finds their files and determines how they are read.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::shape::{Content, Shape, Shapes};
use super::{Arrangement, ProbeInfo, SequenceLayout, Source, SourceGroup, SourceOptions};
use crate::dataset::manifest::{
    DepthInfo, FaceFiles, Manifest, MaterialChannels, Pose, check_intrinsics, intrinsics_of, is_probe_name,
    manifest_path,
};
use crate::dataset::missing::FrameFiles;
use crate::dataset::normals::NormalFiles;
use crate::dataset::pixels::{DepthRules, FARTHEST_M};
use crate::dataset::timed::TimedFiles;
use crate::image_files::{exr, png};
use codec::error::{Error, Result};
use codec::image::equirect::FaceMap;
use codec::image::{DepthKind, Face, FaceLayout, FolderNames, FrameRange, Primaries, Projection, StreamKind};

const DEFAULT_FPS: f64 = 24.0;

impl Source {
    /// Returns the face maps whose filters are used to resample colour or alpha of these groups from panoramas.
    pub fn filtered_maps<'a>(&'a self, groups: &[&SourceGroup]) -> Vec<&'a FaceMap> {
        self.maps_of(groups, |kind| matches!(kind, StreamKind::Color | StreamKind::Alpha))
    }

    /// Returns the face maps of the groups of some kinds, those of one size once.
    fn maps_of(&self, groups: &[&SourceGroup], is_kind: impl Fn(StreamKind) -> bool) -> Vec<&FaceMap> {
        let mut maps = Vec::new();
        for shape in self.shapes.all() {
            let is_of = |group: &&&SourceGroup| is_kind(group.kind) && self.shape(group).file_size == shape.file_size;
            let faces: BTreeSet<Face> = groups.iter().filter(is_of).flat_map(|group| group.faces.clone()).collect();
            maps.extend(shape.maps.iter().filter(|map| faces.contains(&map.face)));
        }
        maps
    }

    /// Size in bytes of the tables for resampling panoramas of these groups. Each is built once and kept.
    pub fn table_bytes(&self, groups: &[&SourceGroup]) -> u64 {
        let nearest = self.maps_of(groups, |kind| matches!(kind, StreamKind::Depth | StreamKind::Material));
        let filters = self.filtered_maps(groups).into_iter().map(FaceMap::filter_bytes);
        filters.chain(nearest.into_iter().map(FaceMap::nearest_bytes)).sum()
    }

    /// Opens a dataset, given its manifest or the folder that contains `lightfield.json`.
    pub fn open(path: &Path, options: &SourceOptions) -> Result<Source> {
        Source::of_manifest(Manifest::read(path)?, &manifest_path(path), options)
    }

    /// Opens the dataset of a validated manifest; `file` is its existing or future path.
    pub fn of_manifest(manifest: Manifest, file: &Path, options: &SourceOptions) -> Result<Source> {
        let folder = file.parent().unwrap_or(Path::new(""));
        let content = match (manifest.projection, manifest.face_files()) {
            (Projection::Equirect, _) => Content::Equirect,
            (Projection::Perspective, _) | (_, FaceFiles::Six) => Content::Face,
            (_, FaceFiles::Cameras) => Content::Camera,
            (_, FaceFiles::Cross) => Content::Faces(FaceLayout::Cross),
            (_, FaceFiles::Strip) => Content::Faces(FaceLayout::Strip),
        };
        let depth = manifest.depth.clone().unwrap_or_default();
        let kind = options.depth_kind.unwrap_or(depth.kind.metric(manifest.projection));
        let disparity = depth.disparity().filter(|_| options.depth_kind.is_none());
        let stated = manifest.depth.as_ref().and_then(DepthInfo::stated_scale);
        let scale = options.depth_scale.or(stated);
        if disparity.is_some() && options.depth_scale.is_some() {
            return Err(Error::Usage("`depth_scale`: the manifest says that depth files store disparity".into()));
        }
        let space = options.color_space.or(manifest.color.as_ref().and_then(|color| color.space));
        let names = manifest.material.clone().map_or_else(MaterialChannels::default, |material| material.channels);
        let shape = |size: [u32; 2]| {
            Shape::new(content, size.into(), manifest.picture_in(size).into(), options.face_size)
                .map_err(|error| error.in_file(file))
        };
        let mut source =
            Source::new(content, shape(manifest.size)?, kind, options).map_err(|error| error.in_file(file))?;
        source.stereo = manifest.stereo;
        source.name.clone_from(&manifest.name);
        source.fps = manifest.fps;
        source.rules.scale = scale.filter(|_| disparity.is_none()).unwrap_or(1.0);
        source.rules.disparity = disparity;
        source.scale_stated = scale.is_some() || disparity.is_some();
        source.rules.background = options.background.unwrap_or(depth.background.value());
        source.color_space = space;
        source.rules.farthest_m = depth.far.map_or(FARTHEST_M, |far| far.max(FARTHEST_M));
        source.missing = options.missing.or(manifest.missing).unwrap_or_default();
        source.depth_channel = options.depth_channel.clone().or(depth.channel).into();
        let layer = manifest.color.as_ref().and_then(|color| color.layer.clone());
        source.color_channel = options.color_channel.clone().or(layer).into();
        let channel = manifest.alpha.as_ref().and_then(|alpha| alpha.channel.clone());
        source.alpha_channel = options.alpha_channel.clone().or(channel).into();
        if options.material_channel.is_none() {
            source.material_channels = [names.reflection, names.refraction, names.ior];
        }
        if manifest.projection == Projection::Perspective {
            source.projection = Projection::Perspective;
        }
        let wanted =
            options.frames.map_or(Some(manifest.frame_range()), |frames| manifest.frame_range().intersect(frames));
        for (at, probe) in manifest.probes.iter().enumerate() {
            let size = manifest.size_of(probe);
            let of_probe = |error: Error| error.context(format!("probe \"{}\"", probe.name));
            source.shapes.set(at, size.into(), || shape(size).map_err(of_probe))?;
            let own = manifest.frames_of(probe);
            let frames = wanted.and_then(|wanted| wanted.intersect(own)).unwrap_or(own);
            let Pose { position, orientation, .. } = probe.first_pose(frames);
            source.probes.push(ProbeInfo {
                name: probe.name.clone(),
                position,
                orientation,
                poses: probe.poses_in(frames),
                frames,
                intrinsics: probe.intrinsics_for(manifest.picture_size_of(probe)),
            });
        }
        if manifest.projection == Projection::Perspective
            && kind == DepthKind::Planar
            && manifest.files.depth.is_some()
            && let Some(unknown) = source.probes.iter().find(|probe| probe.intrinsics.is_none())
        {
            if source.probes.iter().any(|probe| probe.intrinsics.is_some()) {
                let message = format!(
                    "probe \"{}\" has neither \"fov_y_deg\" nor \"intrinsics\", but others have: planar depth becomes \
                     distance for all probes or for none",
                    unknown.name
                );
                return Err(Error::invalid(message).in_file(file));
            }
            source.depth_stored = DepthKind::Planar;
        }
        let faces = manifest.faces();
        let together: Vec<&[Face]> =
            if manifest.has_one_face_per_file() { faces.chunks(1).collect() } else { vec![faces.as_slice()] };
        let (mut folders, mut times) = (FolderNames::default(), BTreeMap::new());
        for kind in StreamKind::ALL {
            for probe in 0..source.probes.len() {
                let frames = source.probes[probe].frames;
                if wanted.is_none_or(|wanted| wanted.intersect(frames).is_none()) {
                    continue;
                }
                for faces in &together {
                    let name = source.probes[probe].name.clone();
                    let files = if let Some(pattern) = manifest.timed_pattern(kind, &name, faces[0]) {
                        let files = TimedFiles::list(&folder.join(pattern), &mut folders)?;
                        // Frames are the files of the first kind, in order.
                        let times = times.entry((probe, faces[0])).or_insert_with(|| files.times());
                        let whole = manifest.frames_of(&manifest.probes[probe]);
                        files.frames(times, whole, frames).map_err(|error| error.in_file(file))?
                    } else {
                        let Some(pattern) = manifest.pattern(kind, &name, faces[0])? else { continue };
                        FrameFiles::known(pattern.below(folder), frames, source.missing, &mut folders)?
                    };
                    source.add(kind, probe, faces, files);
                }
            }
        }
        let first_faces: Vec<Face> = together.iter().map(|faces| faces[0]).collect();
        let frames: Vec<FrameRange> = source.probes.iter().map(|probe| probe.frames).collect();
        source.normals = NormalFiles::of(&manifest, folder, &first_faces, &frames)?;
        if source.groups.is_empty() {
            return Err(Error::invalid("no probe has any of the requested frames").in_file(file));
        }
        source.check_channels(options).map_err(|error| error.in_file(file))?;
        source.apply_pixel_aspect(&manifest)?;
        source.manifest = Some(manifest);
        source.find_primaries();
        Ok(source)
    }

    /// Divides focal lengths from `fov_y_deg` by the pixel aspect that the first file of each probe states.
    ///
    /// # Errors
    /// Fails for cube maps and panoramas, whose pixels are square.
    fn apply_pixel_aspect(&mut self, manifest: &Manifest) -> Result<()> {
        for group in &self.groups {
            let file = self.file(group, group.frames.first)?.filter(|file| !png::has_codes(file));
            let Some(file) = file.filter(|_| group.faces.first() == manifest.faces().first()) else { continue };
            // Reading reports errors of the file.
            let header = exr::read_header(&file, &self.limits).ok();
            let Some(aspect) = header.and_then(|header| header.pixel_aspect) else { continue };
            if manifest.projection != Projection::Perspective {
                let message = format!(
                    "its pixelAspectRatio is {aspect}, but pixels of {} are square: render it so, or set the attribute to 1",
                    manifest.projection.name()
                );
                return Err(Error::unsupported(message).in_file(&file));
            }
            let of_manifest = &manifest.probes[group.probe];
            if let Some(fov_y_deg) = of_manifest.fov_y_deg {
                let [fx, fy, cx, cy] = intrinsics_of(fov_y_deg, manifest.picture_size_of(of_manifest));
                self.probes[group.probe].intrinsics = Some([fx / aspect, fy, cx, cy]);
            }
        }
        Ok(())
    }

    /// Fails if a channel is given for a kind of which there are no images.
    fn check_channels(&self, options: &SourceOptions) -> Result<()> {
        let given = [
            (StreamKind::Color, &options.color_channel),
            (StreamKind::Depth, &options.depth_channel),
            (StreamKind::Material, &options.material_channel),
            (StreamKind::Alpha, &options.alpha_channel),
        ];
        let is_missing = |kind| !self.groups.iter().any(|group| group.kind == kind);
        match given.into_iter().find(|(kind, channel)| channel.is_some() && is_missing(*kind)) {
            Some((kind, _)) => {
                let kind = kind.name();
                Err(Error::Usage(format!("`{kind}_channel`: \"files\" in the manifest has no {kind}")))
            }
            None => Ok(()),
        }
    }

    /// Opens a single sequence: `spec` is a pattern, a folder or a file ([`codec::image::Sequence::find`]). The size is that of
    /// its first image.
    pub fn from_sequence(
        kind: StreamKind,
        spec: &str,
        layout: &SequenceLayout,
        options: &SourceOptions,
    ) -> Result<Source> {
        if !is_probe_name(&layout.probe) {
            let message = format!("\"{}\" is not a probe name: use letters, digits, '.', '_' and '-'", layout.probe);
            return Err(Error::Usage(message));
        }
        if let Some(intrinsics) = layout.intrinsics {
            check_intrinsics(intrinsics).map_err(|error| Error::Usage(error.to_string()))?;
        }
        let files = FrameFiles::find(spec, options.frames, options.missing.unwrap_or_default())?;
        let none = || Error::invalid("none of its frames exists").in_file(spec);
        let first = files.files().next().ok_or_else(none)?;
        let size = if png::has_codes(&first) {
            png::read_size(&first, &options.limits)
        } else {
            exr::read_size(&first, &options.limits)
        }?;
        let (content, faces) = match layout.arrangement {
            Arrangement::Single(face) => (Content::Face, vec![face]),
            Arrangement::Cross => (Content::Faces(FaceLayout::Cross), Face::CUBE.to_vec()),
            Arrangement::Strip => (Content::Faces(FaceLayout::Strip), Face::CUBE.to_vec()),
            Arrangement::Equirect => (Content::Equirect, Face::CUBE.to_vec()),
        };
        if content == Content::Face && faces != [Face::View] && size.0 != size.1 {
            let message = format!("the faces of a cube are square, this image is {}x{}", size.0, size.1);
            return Err(Error::invalid(message).in_file(&first));
        }
        let depth_kind = options.depth_kind.unwrap_or_default();
        let mut source = Shape::new(content, size, size, options.face_size)
            .and_then(|shape| Source::new(content, shape, depth_kind, options))
            .map_err(|error| error.in_file(&first))?;
        source.name = sequence_name(spec);
        let view = faces == [Face::View];
        if view {
            source.projection = Projection::Perspective;
            if layout.intrinsics.is_none() {
                source.depth_stored = depth_kind;
            }
        }
        source.probes.push(ProbeInfo {
            name: layout.probe.clone(),
            position: [0.0; 3],
            orientation: [0.0, 0.0, 0.0, 1.0],
            poses: Vec::new(),
            frames: files.frames(),
            intrinsics: if view { layout.intrinsics } else { None },
        });
        source.add(kind, 0, &faces, files);
        source.find_primaries();
        Ok(source)
    }

    /// Creates a source without probes, initialised from the options only.
    fn new(content: Content, shape: Shape, depth_kind: DepthKind, options: &SourceOptions) -> Result<Source> {
        if let Some(scale) = options.depth_scale
            && (!scale.is_finite() || scale == 0.0)
        {
            return Err(Error::Usage(format!(
                "the depth scale is {scale}: metres per unit other than 0 were expected"
            )));
        }
        if options.background.is_some_and(f32::is_nan) {
            return Err(Error::Usage("the background must be a number or inf".into()));
        }
        if content == Content::Equirect && depth_kind == DepthKind::Planar {
            return Err(Error::Usage("equirectangular images have no planar depth: use distance".into()));
        }
        let material_channels = match &options.material_channel {
            Some(text) => three_channels(text)?,
            None => MaterialChannels::default().names().map(str::to_owned),
        };
        Ok(Source {
            name: String::new(),
            fps: DEFAULT_FPS,
            projection: Projection::Cubemap,
            probes: Vec::new(),
            groups: Vec::new(),
            sequences: BTreeMap::new(),
            normals: NormalFiles::default(),
            manifest: None,
            content,
            stereo: None,
            shapes: Shapes::new(shape),
            rules: DepthRules {
                background: options.background.unwrap_or(f32::INFINITY),
                scale: options.depth_scale.unwrap_or(1.0),
                invalid: options.invalid_depth,
                ..DepthRules::default()
            },
            scale_stated: options.depth_scale.is_some(),
            depth_stored: DepthKind::Distance,
            depth_in_files: depth_kind,
            color_space: options.color_space,
            primaries: Primaries::REC709,
            color_channel: options.color_channel.clone().into(),
            depth_channel: options.depth_channel.clone().into(),
            material_channels,
            alpha_channel: options.alpha_channel.clone().into(),
            invalid_color: options.invalid_color,
            missing: options.missing.unwrap_or_default(),
            limits: options.limits,
        })
    }

    /// Sets the primaries: those of the stated colour space, or else of the first colour file. If that file cannot be read, the
    /// error is reported when its pixels are read.
    fn find_primaries(&mut self) {
        let first = self.groups.iter().find(|group| group.kind == StreamKind::Color);
        let files = first.and_then(|group| self.sequences.get(&(group.kind, group.probe, *group.faces.first()?)));
        let file = files.and_then(|files| files.files().next()).filter(|file| !png::has_codes(file));
        self.primaries = match self.color_space {
            Some(space) => space.primaries(),
            None => file.and_then(|file| exr::read_primaries(&file).ok()).unwrap_or(Primaries::REC709),
        };
    }

    fn add(&mut self, kind: StreamKind, probe: usize, faces: &[Face], files: FrameFiles) {
        let (width, height) = self.shapes.of(probe).delivered_size;
        let frames = files.frames();
        self.groups.push(SourceGroup { kind, probe, faces: faces.to_vec(), frames, width, height });
        self.sequences.insert((kind, probe, faces[0]), files);
    }
}

fn three_channels(text: &str) -> Result<[String; 3]> {
    match text.split(',').map(|name| name.trim().to_owned()).collect::<Vec<_>>().try_into() {
        Ok(names) => Ok(names),
        Err(_) => Err(Error::Usage(format!("a material has three channels with commas between them, not \"{text}\""))),
    }
}

/// Returns the name of a single sequence: its file name up to the frame number, or its folder.
fn sequence_name(spec: &str) -> String {
    let path = Path::new(spec);
    let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let name = if path.is_dir() { name } else { name.split(['%', '#', '@', '$', '<', '.']).next().unwrap_or_default() };
    let name = name.trim_end_matches(['.', '_', '-', ' ']);
    if name.is_empty() { "sequence".into() } else { name.into() }
}
