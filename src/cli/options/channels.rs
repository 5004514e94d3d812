//! Channels of EXR files.

use clap::Args;

use crate::refuse;
use codec::error::Result;
use codec::image::StreamKind;
use footage::dataset::SourceOptions;

#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Channels")]
pub struct ChannelArgs {
    /// Depth channel or layer of EXR files [default: from the manifest, else common names]
    #[arg(long, value_name = "NAME")]
    pub depth_channel: Option<String>,
    /// Colour layer of EXR files, or three channels R,G,B [default: from the manifest, else common names]
    #[arg(long, value_name = "NAME")]
    pub color_channel: Option<String>,
    /// Three material channels of EXR files: reflect,refract,ior [default: from the manifest]
    #[arg(long, value_name = "A,B,C")]
    pub material_channel: Option<String>,
    /// Alpha channel of EXR files [default: from the manifest, else that of the colour layer]
    #[arg(long, value_name = "NAME")]
    pub alpha_channel: Option<String>,
}

impl ChannelArgs {
    pub fn apply(&self, source: &mut SourceOptions) {
        source.depth_channel.clone_from(&self.depth_channel);
        source.color_channel.clone_from(&self.color_channel);
        source.material_channel.clone_from(&self.material_channel);
        source.alpha_channel.clone_from(&self.alpha_channel);
    }

    pub fn is_usual(&self) -> bool {
        let all = [&self.depth_channel, &self.color_channel, &self.material_channel, &self.alpha_channel];
        all.into_iter().all(Option::is_none)
    }

    /// Fails if a channel of another kind than that of the sequence is given.
    pub fn check(&self, kind: StreamKind) -> Result<()> {
        let given = [
            (StreamKind::Depth, &self.depth_channel),
            (StreamKind::Color, &self.color_channel),
            (StreamKind::Material, &self.material_channel),
            (StreamKind::Alpha, &self.alpha_channel),
        ];
        match given.into_iter().find(|(other, name)| *other != kind && name.is_some()) {
            Some((other, _)) => {
                refuse(format!("--{}-channel does not apply to a sequence of {}", other.name(), kind.name()))
            }
            None => Ok(()),
        }
    }
}
