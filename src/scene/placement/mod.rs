//! Camera placement (CALF 4): chooses few positions in a region that together see a scene well, in the order of their gain. The
//! result does not depend on the number of threads.
//!
//! 1. [`region`]: where viewers, and therefore cameras, may be; distance `Z(x)` of surfaces from them.
//! 2. [`surface`]: points on surfaces, uniform by area; [`sampled_scene`]: visibility, and free space.
//! 3. [`candidates`]: positions to test, and the free space for their refinement.
//! 4. [`objective`]: equations 2, 3, 4, 6 and 7; [`greedy`]: equation 5; [`search`]: algorithm 1.
//! 5. [`coverage`]: coverage measured independently of the objective.
//!
//! Default lengths are fractions of the region's diagonal, and low-discrepancy sequences ([`sequence`]) replace random numbers,
//! so that results do not depend on the size of a scene. Positions are in metres.

pub mod candidates;
pub mod closed_mesh;
pub mod coverage;
pub mod greedy;
pub mod objective;
pub mod region;
pub mod report;
pub mod sampled_scene;
pub mod search;
pub mod sequence;
pub mod surface;

pub use candidates::CandidateKind;
pub use coverage::Figures;
pub use objective::{Lighting, Problem, State, VisibleSet};
pub use region::Region;
pub use sampled_scene::SampledScene;
pub use search::{Placed, Placement, Search, Settings, Stop};
