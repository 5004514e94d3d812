//! Options that several commands share.

mod camera;
mod choice;
mod color;
mod depth;
mod effort;
mod material;
mod number;
mod output;
mod selection;
mod sequence;
mod side;
mod stream;

pub use camera::{CameraArgs, parse_aspect, parse_point};
pub use choice::{Choices, one_of, word_of};
pub use color::ColorArgs;
pub use depth::{
    BoundArgs, DepthArgs, DepthReadingArgs, DepthStepArgs, DepthUnitArgs, DomainArgs, ModelArgs, parse_share,
};
pub use effort::{EFFORTS, EffortArgs};
pub use material::MaterialArgs;
pub use number::{parse_not_negative, parse_number_where, parse_positive};
pub use output::{EncodeOutputArgs, MemoryArgs, OutputArgs, StoreArgs, Target, Unfinished, check_report, check_stdout};
pub use selection::{FrameArgs, SelectionArgs, parse_face, parse_kind};
pub use sequence::{COLOR_SPACES, ImageArgs, SequenceInputArgs};
pub use side::SideArgs;
pub use stream::StreamArgs;
