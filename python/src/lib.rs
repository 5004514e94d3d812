//! Native part of the Python module `lightfold`: reads and writes containers, with images as numpy arrays.

mod container;
mod encode;
mod errors;
mod probe;
mod report;
mod settings;
mod stream;

#[pyo3::pymodule]
mod _lightfold {
    use pyo3::prelude::*;
    use pyo3::types::PyTuple;

    use library::Face;

    #[pymodule_export]
    use super::container::{Container, open};
    #[pymodule_export]
    use super::encode::encode;
    #[pymodule_export]
    use super::errors::Error;
    #[pymodule_export]
    use super::probe::Probe;
    #[pymodule_export]
    use super::stream::Stream;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        let faces = Face::CUBE.map(Face::name);
        module.add("FACES", PyTuple::new(module.py(), faces)?)?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
