//! Links the C++ library.

fn main() {
    build::link_cxx();
}
