//! Coding sweeps: measures, commands, figures and findings of the papers, recommendations.

pub mod bench;
pub mod commands;
pub mod figures;
pub mod findings;
pub mod json;
pub mod recommend;
pub mod runs;
pub mod table;

pub use table::CODING;
