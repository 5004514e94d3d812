//! How results look: tables for people, CSV for spreadsheets, charts; and sweeps of knobs. No command has a layout of its own.

pub mod anatomy;
pub mod contact_sheet;
pub mod csv;
pub mod error_picture;
pub mod machine;
pub mod placement;
pub mod plot;
pub mod table;
pub mod timing;
pub mod tradeoff;

pub use table::{Column, Table};
