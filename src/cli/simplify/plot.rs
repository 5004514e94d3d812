//! Charts and pictures of `simplify --plot DIR`.

use std::path::{Path, PathBuf};

use crate::report::plot::save;
use crate::report::simplification::{charts, pictures};
use codec::error::Result;
use footage::files::OutputFolder;
use footage::image_files::png;
use simplify::capture::Capture;
use simplify::pipeline::Simplified;
use simplify::samples::Background;

/// Writes all charts and pictures, and returns their paths.
pub fn write(
    folder: &Path,
    simplified: &Simplified,
    capture: &mut Capture,
    background: Background,
) -> Result<Vec<PathBuf>> {
    let Simplified { scene, selection, stages, .. } = simplified;
    let out = OutputFolder::create(folder)?;
    let mut files = Vec::new();
    for figure in charts(&selection.convergence, stages) {
        files.extend(save(&figure.drawing, out.work_path(), figure.name).map_err(|error| out.present(error))?);
    }
    for view in pictures(scene, capture, background)? {
        let path = out.work_path().join(format!("{}.png", view.name));
        png::write_color8(&path, &view.picture).map_err(|error| out.present(error))?;
        files.push(path);
    }
    out.commit()?;
    Ok(files.iter().filter_map(|path| Some(folder.join(path.file_name()?))).collect())
}
