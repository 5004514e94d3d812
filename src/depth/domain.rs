//! stub
use crate::depth::quantise::DepthRange;
use crate::error::Result;
/// stub
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DomainKind {
    /// l
    #[default]
    Log,
    /// l
    Linear,
    /// l
    Inverse,
}
/// stub
#[derive(Debug, Clone)]
pub struct Domain;
impl Domain {
    /// s
    pub fn new(_k: DomainKind, _r: DepthRange) -> Result<Domain> {
        Ok(Domain)
    }
    /// s
    pub fn from_parts(_p: DomainParts) -> Result<Domain> {
        Ok(Domain)
    }
    /// s
    pub fn parts(&self) -> DomainParts {
        DomainParts { kind: DomainKind::Log, base: 0, scale: 0 }
    }
}
impl DomainKind {
    /// s
    pub fn name(self) -> &'static str {
        "log"
    }
    /// s
    pub fn from_index(i: u16) -> Option<Self> {
        [Self::Log, Self::Linear, Self::Inverse].get(usize::from(i)).copied()
    }
}
/// s
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DomainParts {
    /// s
    pub kind: DomainKind,
    /// s
    pub base: u32,
    /// s
    pub scale: u32,
}
