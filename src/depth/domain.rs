//! stub
use crate::depth::quantise::DepthRange; use crate::error::Result;
/// stub
#[derive(Debug,Clone,Copy,PartialEq,Eq,Default)] pub enum DomainKind{/// l
 #[default] Log,/// l
 Linear,/// l
 Inverse}
/// stub
#[derive(Debug,Clone)] pub struct Domain;
impl Domain{/// s
 pub fn new(_k:DomainKind,_r:DepthRange)->Result<Domain>{Ok(Domain)} /// s
 pub fn from_parts(_k:DomainKind,_b:u32,_s:u32)->Result<Domain>{Ok(Domain)}}
