//! Sums of structs of counts and costs, member by member.

/// Implements `+` for a struct, with all its members listed.
#[macro_export]
macro_rules! add_members {
    ($name:ident: $($member:ident),+) => {
        impl std::ops::Add for $name {
            type Output = $name;

            fn add(self, other: $name) -> $name {
                $name { $($member: self.$member + other.$member),+ }
            }
        }
    };
}

pub use crate::add_members;
