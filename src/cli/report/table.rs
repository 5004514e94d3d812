//! Plain-text tables: text left-aligned, numbers right-aligned, two spaces between columns, no lines and no colours.

use std::fmt;

use comfy_table::{CellAlignment, ContentArrangement, presets};

/// Table under construction. Its `Display` prints one line for the headings and one per row.
#[derive(Debug, Clone)]
pub struct Table {
    table: comfy_table::Table,
}

impl Table {
    /// Creates a table without rows. Headings are separated by `|`; those of right-aligned columns begin with `>`.
    pub fn new(headings: &str) -> Table {
        let mut table = comfy_table::Table::new();
        table.load_style(presets::NOTHING).set_content_arrangement(ContentArrangement::Disabled);
        table.set_header(headings.split('|').map(|heading| heading.trim_start_matches('>')));
        for (cells, heading) in table.column_iter_mut().zip(headings.split('|')) {
            let side = if heading.starts_with('>') { CellAlignment::Right } else { CellAlignment::Left };
            cells.set_padding((0, 2)).set_cell_alignment(side);
        }
        Table { table }
    }

    /// Wraps the widest columns at word boundaries so that no line exceeds `columns` characters. Continuation lines of
    /// a cell are placed below its first line.
    pub fn wrapped(mut self, columns: u16) -> Table {
        self.table.set_content_arrangement(ContentArrangement::Dynamic).set_width(columns);
        self
    }

    /// Adds a row. It must have one cell per column.
    pub fn row(&mut self, cells: impl IntoIterator<Item = String>) {
        self.table.add_row(cells.into_iter().collect::<Vec<_>>());
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.table.lines().try_for_each(|line| writeln!(f, "{}", line.trim_end()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_right_and_lines_have_no_blanks_at_their_ends() {
        let mut table = Table::new("What|>Size|Note");
        table.row(["a".to_owned(), "7 B".to_owned(), String::new()]);
        table.row(["longer".to_owned(), "1.25 MB".to_owned(), "x y".to_owned()]);
        assert_eq!(table.to_string(), "What       Size  Note\na           7 B\nlonger  1.25 MB  x y\n");
    }

    #[test]
    fn long_sentences_are_wrapped_under_themselves() {
        let mut table = Table::new("What|Why").wrapped(24);
        table.row(["short".to_owned(), "one two three four five".to_owned()]);
        assert_eq!(table.to_string(), "What   Why\nshort  one two three\n       four five\n");
    }
}
