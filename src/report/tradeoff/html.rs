//! What pages of sweeps have in common: a head with a style, figures as SVG in the page, and how it was measured. A page
//! needs no other file, no network and no script.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::figures::Figure;
use crate::error::{Error, Result};
use crate::files::write_whole;
use crate::report::plot::save::{self, escape};

/// A page's own name.
pub const PAGE: &str = "index.html";

/// Look of the page: readable on a screen in the light, and on paper.
const STYLE: &str = "\
body{font:16px/1.5 'DejaVu Sans',Verdana,sans-serif;color:#222;background:#fff;max-width:1320px;margin:0 auto;padding:24px}\
h1{font-size:26px;margin:0 0 4px}h2{font-size:20px;margin:40px 0 8px;border-bottom:1px solid #ddd;padding-bottom:4px}\
p{margin:6px 0}.faint{color:#606060}figure{margin:24px 0 36px;break-inside:avoid}\
figure svg{max-width:100%;height:auto;border:1px solid #e2e2e2}figcaption{font-size:14px;max-width:1000px;color:#444}\
.scroll{overflow-x:auto}table{border-collapse:collapse;font-size:13px;font-variant-numeric:tabular-nums}\
th,td{padding:3px 8px;text-align:right;border-bottom:1px solid #e2e2e2;white-space:nowrap;vertical-align:top}\
th{background:#f5f5f5;border-bottom:2px solid #bbb;white-space:normal;vertical-align:bottom}\
td small{display:block;font-size:10px;color:#606060}h4{font-size:14px;margin:16px 0 4px}tr.best td{background:#fdf3d7}\
ol.findings{padding-left:24px}ol.findings li{margin:12px 0;max-width:1100px}\
.verdict{display:inline-block;padding:0 8px;border-radius:3px;font-size:13px;font-weight:bold;color:#fff;margin-right:6px}\
.found{background:#1b7a4b}.not-found{background:#b3261e}.not-measured{background:#6b6b6b}\
.small{font-size:14px;color:#444}code{font:13px 'DejaVu Sans Mono',Consolas,monospace;background:#f5f5f5;padding:1px 4px;\
overflow-wrap:anywhere}dl{display:grid;grid-template-columns:max-content 1fr;gap:4px 16px;font-size:14px}dt{color:#606060}\
dd{margin:0;overflow-wrap:anywhere}\
@media print{body{max-width:none;padding:0;font-size:12px}h2{break-after:avoid}.scroll{overflow:visible}table{font-size:8px}\
th,td{padding:1px 3px}}";

/// Writes every figure as SVG and PNG, and the page's text, into a folder. Returns the files.
///
/// # Errors
/// When a file cannot be written.
pub fn write(figures: &[Figure], text: &str, folder: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for figure in figures {
        files.extend(save::save(&figure.drawing, folder, &figure.name)?);
    }
    let path = folder.join(PAGE);
    write_whole(&path, |partial| std::fs::write(partial, text).map_err(|error| Error::io(&path, error)))?;
    files.push(path);
    Ok(files)
}

/// The beginning of a page, with its title and a line below it.
pub fn begin(title: &str, subtitle: &str) -> String {
    let (title, subtitle) = (escape(title), escape(subtitle));
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{title}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n\
         <p class=\"faint\">{subtitle}</p>\n"
    )
}

/// The page with its end.
pub fn end(mut page: String) -> String {
    page.push_str("</body>\n</html>\n");
    page
}

/// Adds a figure with its caption.
///
/// # Errors
/// When the font cannot be read.
pub fn figure(page: &mut String, figure: &Figure) -> Result<()> {
    let svg = save::to_svg(&figure.drawing)?;
    // Writing into a string does not fail.
    let _ = write!(
        page,
        "<figure id=\"{}\">\n{svg}<figcaption>{}</figcaption>\n</figure>\n",
        escape(&figure.name),
        escape(&figure.caption)
    );
    Ok(())
}

/// How a sweep was measured.
#[derive(Debug, Clone, Copy)]
pub struct How<'a> {
    /// A word for what was measured, and how the user named it.
    pub input: (&'a str, &'a str),
    /// The command that did.
    pub command_line: &'a str,
    /// Processor and devices.
    pub machine: &'a str,
}

/// Adds a section that says how it was measured.
pub fn how(page: &mut String, how: &How<'_>) {
    let _ = write!(
        page,
        "<h2>How this was measured</h2>\n<dl>\n<dt>{}</dt><dd>{}</dd>\n<dt>Command</dt><dd><code>{}</code></dd>\n\
         <dt>Machine</dt><dd>{}</dd>\n<dt>Version</dt><dd>lightfold {}</dd>\n</dl>\n",
        escape(how.input.0),
        escape(how.input.1),
        escape(how.command_line),
        escape(how.machine),
        env!("CARGO_PKG_VERSION")
    );
}
