//! The page of a sweep of one grid, of rendering or of placing cameras: figures, all points, and how they came about.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::figures::Figure;
use super::html;
use crate::error::Result;
use crate::report::Table;
use crate::report::plot::save::escape;

/// What is on the page.
#[derive(Debug, Clone, Copy)]
pub struct GridPage<'a> {
    /// What costs, such as `What rendering costs: set`.
    pub title: &'a str,
    /// What the figures of the table are, in sentences.
    pub about: &'a str,
    /// Figures.
    pub figures: &'a [Figure],
    /// All points.
    pub table: &'a Table,
    /// How it was measured.
    pub how: html::How<'a>,
    /// Commands that anyone can repeat, and what each is for.
    pub commands: &'a [(&'a str, String)],
}

impl GridPage<'_> {
    /// Writes figures as SVG and PNG, and `index.html`, which shows them, into a folder. Returns the files.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<Vec<PathBuf>> {
        html::write(self.figures, &self.html()?, folder)
    }

    fn html(&self) -> Result<String> {
        let (headings, rows) = self.table.cells();
        let points = if rows.len() == 1 { "1 point".to_owned() } else { format!("{} points", rows.len()) };
        let mut page = html::begin(self.title, &format!("{points}. {}", self.about));
        page.push_str("<h2>Figures</h2>\n");
        self.figures.iter().try_for_each(|figure| html::figure(&mut page, figure))?;
        page.push_str("<h2>All points</h2>\n<div class=\"scroll\"><table>\n<thead>");
        let row = |page: &mut String, cells: &[String], tag: &str| {
            page.push_str("<tr>");
            for cell in cells {
                // Writing into a string does not fail.
                let _ = write!(page, "<{tag}>{}</{tag}>", escape(cell));
            }
            page.push_str("</tr>");
        };
        row(&mut page, &headings, "th");
        page.push_str("</thead>\n<tbody>\n");
        for cells in &rows {
            row(&mut page, cells, "td");
            page.push('\n');
        }
        page.push_str("</tbody></table></div>\n");
        html::how(&mut page, &self.how);
        page.push_str("<dl>\n");
        for (what, command) in self.commands {
            let _ = writeln!(page, "<dt>{}</dt><dd><code>{}</code></dd>", escape(what), escape(command));
        }
        page.push_str(
            "</dl>\n<p class=\"small\">Each point is a process of its own. Rounds of timed runs went over all points in turn; \
             times are medians of them.</p>\n",
        );
        Ok(html::end(page))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::Column;
    use crate::report::plot::Drawing;

    #[test]
    fn the_page_stands_alone_and_has_all_points() {
        let mut table = Table::new(&[Column::Left("steps"), Column::Right("PSNR dB")]);
        table.row(["<64>".to_owned(), "30.00".to_owned()]);
        table.row(["128".to_owned(), "31.00".to_owned()]);
        let figures = [Figure {
            name: "rendering".to_owned(),
            caption: "Up & to the left is better.".to_owned(),
            drawing: Drawing::new(40, 30, "a chart"),
        }];
        let how =
            html::How { input: ("Dataset", "set"), command_line: "lightfold tradeoff '<b>'", machine: "A Processor" };
        let commands = [("A point", "lightfold render --steps=64".to_owned())];
        let page = GridPage {
            title: "What <it> costs",
            about: "A.",
            figures: &figures,
            table: &table,
            how,
            commands: &commands,
        };
        let folder = tempfile::tempdir().unwrap();
        let files = page.write(folder.path()).unwrap();
        assert!(files.len() == 3 && files.iter().all(|file| file.is_file()), "{files:?}");
        let text = std::fs::read_to_string(folder.path().join(html::PAGE)).unwrap();
        for bad in ["<script", "<b>", "<it>", "<64>", "src=", "href="] {
            assert!(!text.contains(bad), "{bad}");
        }
        for said in
            ["2 points. A.", "<td>&lt;64&gt;</td><td>30.00</td>", "Up &amp; to", "A Processor", "--steps=64", "<svg "]
        {
            assert!(text.contains(said), "{said}: {text}");
        }
        assert_eq!((text.matches("<tr>").count(), text.matches("<svg ").count()), (3, 1));
    }
}
