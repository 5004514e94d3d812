//! How results look: tables for people, CSV for spreadsheets. No command has a layout of its own.

pub mod csv;
pub mod table;

pub use table::{Column, Table};
