//! Settings that decoded pixels depend on.

use super::Source;

impl Source {
    /// Names and values of all settings that affect pixels. Sources with equal values read equal pixels from equal files.
    pub fn reading_rules(&self) -> Vec<(&'static str, String)> {
        let range = self.manifest().and_then(|manifest| manifest.depth.as_ref());
        vec![
            ("what an image shows", format!("{:?}", self.content)),
            ("the size of the images", format!("{}x{}", self.file_size.0, self.file_size.1)),
            ("the size of the faces", format!("{}x{}", self.delivered_size.0, self.delivered_size.1)),
            ("the background", format!("{:?}", self.rules.background)),
            ("the depth scale", format!("{:?}", self.rules.scale)),
            ("`invalid_depth`", format!("{:?}", self.rules.invalid)),
            ("`invalid_color`", format!("{:?}", self.invalid_color)),
            ("the kind of depth", format!("{:?} as {:?}", self.depth_kind, self.depth_stored)),
            ("near and far in the manifest", format!("{:?}", range.map(|depth| (depth.near, depth.far)))),
            ("whether a depth scale is stated", self.scale_stated.to_string()),
            ("the color space", format!("{:?}", self.color_space)),
            ("the color channels", format!("{:?}", self.color_channel)),
            ("the depth channel", format!("{:?}", self.depth_channel)),
            ("the material channels", format!("{:?}", self.material_channels)),
        ]
    }
}
