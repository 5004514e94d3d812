//! Where cameras are to stand, so that few of them see a scene well (CALF 4).
//!
//! Enters: a scene over frames, a region in which viewers move, and what "well" means. Leaves: positions in the order in
//! which they are worth capturing, with what each of them adds. The same input gives the same bits on any number of threads.
//!
//! 1. [`region`]: where viewers, and so cameras, may be; how far surfaces are from them: `Z(x)`.
//! 2. [`surface`]: points on surfaces, by area; [`site`]: what is seen from where, and where there is room for a camera.
//! 3. [`candidates`]: positions that are tried, and better ones beside the best of them.
//! 4. [`objective`]: equations 2, 3, 4, 6 and 7; [`greedy`]: equation 5, twice; [`search`]: algorithm 1.
//! 5. [`coverage`]: what cameras come to, in words that do not depend on the objective.

pub mod candidates;
pub mod closed_mesh;
pub mod coverage;
pub mod greedy;
pub mod objective;
pub mod region;
pub mod search;
pub mod sequence;
pub mod site;
pub mod surface;

pub use candidates::CandidateKind;
pub use coverage::Figures;
pub use objective::{Lighting, Problem, State, View};
pub use region::Region;
pub use search::{Placed, Placement, Search, Settings, Stop};
pub use site::Site;
