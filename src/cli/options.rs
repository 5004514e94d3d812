//! Options shared by several commands.

mod camera;
mod channels;
mod choice;
mod coding;
mod color;
mod dataset;
mod depth;
mod effort;
mod material;
mod number;
mod output;
mod preset;
mod progress_form;
mod selection;
mod sequence;
mod shard;
mod side;
mod stream;

pub use camera::{CameraArgs, parse_aspect, parse_point, read_cameras};
pub use channels::ChannelArgs;
pub use choice::{Choices, one_of, word_of};
pub use coding::CodingArgs;
pub use color::ColorArgs;
pub use dataset::DatasetArgs;
pub use depth::{
    BoundArgs, DepthArgs, DepthReadingArgs, DepthStepArgs, DepthUnitArgs, DomainArgs, ModelArgs, parse_share,
};
pub use effort::{EFFORTS, EffortArgs};
pub use material::MaterialArgs;
pub use number::{parse_not_negative, parse_number_where, parse_positive};
pub use output::{EncodeOutputArgs, MemoryArgs, OutputArgs, StoreArgs, Target, Unfinished, check_report, check_stdout};
pub use preset::PresetArgs;
pub use progress_form::{PROGRESS_FORMS, ProgressForm};
pub use selection::{FrameArgs, MissingArgs, SelectionArgs, parse_face, parse_kind};
pub use sequence::{COLOR_SPACES, ImageArgs, LIGHT_SPACES, SequenceInputArgs};
pub use shard::{ShardArgs, parse_shard};
pub use side::SideArgs;
pub use stream::StreamArgs;
