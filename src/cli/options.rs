//! Options shared by several commands.

mod account;
mod camera;
mod channels;
mod coding;
mod color;
mod dataset;
mod depth;
mod display;
mod output;
mod preset;
mod selection;
mod sequence;
mod shard;
mod side;
mod value;

pub use account::{AccountArgs, WithAccount};
pub use camera::{CameraArgs, parse_aspect, parse_point, read_cameras};
pub use channels::ChannelArgs;
pub use coding::CodingArgs;
pub use color::ColorArgs;
pub use dataset::DatasetArgs;
pub use depth::{
    BoundArgs, DepthArgs, DepthReadingArgs, DepthStepArgs, DepthUnitArgs, DomainArgs, ModelArgs, parse_share,
};
pub use display::DisplayArgs;
pub use output::{
    EncodeOutputArgs, MemoryArgs, OutputArgs, StoreArgs, StreamArgs, Target, Unfinished, check_report, check_stdout,
};
pub use preset::{EFFORTS, EffortArgs, PresetArgs};
pub use selection::{FrameArgs, MissingArgs, SelectionArgs, parse_face, parse_kind};
pub use sequence::{COLOR_SPACES, ImageArgs, LIGHT_SPACES, SequenceInputArgs};
pub use shard::{ShardArgs, parse_shard};
pub use side::SideArgs;
pub use value::{Choices, one_of, parse_not_negative, parse_number_where, parse_positive, word_of};
