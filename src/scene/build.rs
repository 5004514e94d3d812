//! Sets the hash of sources and the place of footage for tests; links the C++ library.

fn main() {
    build::hash_sources(&[]);
    build::find_data("../..");
    build::link_cxx();
}
