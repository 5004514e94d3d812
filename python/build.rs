//! Links the C++ library that the block encoder needs.

fn main() {
    build::link_cxx();
}
