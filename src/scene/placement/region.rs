//! The region of viewers: a union of boxes, spheres and closed meshes (CALF 4.1, footnote 1).

use std::path::Path;

use glam::DVec3;

use super::closed_mesh::ClosedMesh;
use crate::Sphere;
use crate::mesh::AxisBox;
use codec::error::{Error, Result};

#[derive(Debug, Clone)]
pub enum Volume {
    /// Axis-aligned; may be flat.
    Box(AxisBox),
    Ball(Sphere),
    Mesh(Box<ClosedMesh>),
}

/// A union of at least one volume.
#[derive(Debug, Clone)]
pub struct Region {
    pub volumes: Vec<Volume>,
}

impl Volume {
    /// Parses `x0,y0,z0,x1,y1,z1` (two opposite corners), `sphere:x,y,z,r`, or the name of a file with a closed mesh.
    pub fn parse(text: &str) -> Result<Volume> {
        let wrong = |what: &str| {
            Error::Usage(format!(
                "region '{text}': {what} (a region is x0,y0,z0,x1,y1,z1 in metres, sphere:x,y,z,r or a file with a closed mesh)"
            ))
        };
        let numbers = |list: &str| -> Option<Vec<f64>> {
            list.split(',').map(|number| number.trim().parse().ok().filter(|value: &f64| value.is_finite())).collect()
        };
        if let Some(list) = text.strip_prefix("sphere:") {
            return match numbers(list).as_deref() {
                Some(&[x, y, z, radius]) if radius > 0.0 => {
                    Ok(Volume::Ball(Sphere { center: DVec3::new(x, y, z), radius }))
                }
                Some(&[_, _, _, _]) => Err(wrong("a sphere's radius must be above 0")),
                _ => Err(wrong("a sphere has four numbers, its centre and its radius")),
            };
        }
        match numbers(text).as_deref() {
            Some(&[x0, y0, z0, x1, y1, z1]) => {
                let (a, b) = (DVec3::new(x0, y0, z0), DVec3::new(x1, y1, z1));
                Ok(Volume::Box(AxisBox { min: a.min(b), max: a.max(b) }))
            }
            Some(found) => {
                Err(wrong(&format!("a box has six numbers, two of its corners, and these are {}", found.len())))
            }
            None if Path::new(text).exists() => Ok(Volume::Mesh(Box::new(ClosedMesh::open(Path::new(text))?))),
            None if text.contains(',') => Err(wrong("a box has six finite numbers, two of its corners")),
            None => Err(wrong("there is no such file")),
        }
    }

    pub fn bounds(&self) -> AxisBox {
        match self {
            Volume::Box(solid) => *solid,
            Volume::Ball(ball) => AxisBox { min: ball.center - ball.radius, max: ball.center + ball.radius },
            Volume::Mesh(mesh) => mesh.bounds,
        }
    }

    /// Returns true if a point is inside or on the border.
    pub fn contains(&self, point: DVec3) -> bool {
        match self {
            Volume::Box(solid) => solid.contains(point),
            Volume::Ball(ball) => point.distance_squared(ball.center) <= ball.radius * ball.radius,
            Volume::Mesh(mesh) => mesh.contains(point),
        }
    }

    /// Returns the distance from a point to the volume in metres, 0 inside.
    pub fn distance_m(&self, point: DVec3) -> f64 {
        match self {
            Volume::Box(solid) => solid.distance_m(point),
            Volume::Ball(ball) => (point.distance(ball.center) - ball.radius).max(0.0),
            Volume::Mesh(mesh) if mesh.contains(point) => 0.0,
            Volume::Mesh(mesh) => mesh.bvh.distance_m(point),
        }
    }
}

impl Region {
    /// Parses the volumes of a region. Fails if there is no volume, or if the diagonal exceeds 1e100 m.
    pub fn parse(texts: &[impl AsRef<str>]) -> Result<Region> {
        let volumes = texts.iter().map(|text| Volume::parse(text.as_ref()));
        let region = Region { volumes: volumes.collect::<Result<_>>()? };
        if region.volumes.is_empty() {
            return Err(Error::Usage("no viewing region was given: set `region`".into()));
        }
        if !region.diagonal_m().is_finite() || region.diagonal_m() > 1e100 {
            return Err(Error::Usage("the region is too large: its corners must be less than 1e100 m apart".into()));
        }
        Ok(region)
    }

    pub fn contains(&self, point: DVec3) -> bool {
        self.volumes.iter().any(|volume| volume.contains(point))
    }

    /// Returns the distance from a point to the nearest volume, in metres.
    pub fn distance_m(&self, point: DVec3) -> f64 {
        self.volumes.iter().map(|volume| volume.distance_m(point)).fold(f64::INFINITY, f64::min)
    }

    pub fn bounds(&self) -> AxisBox {
        let bounds = self.volumes.iter().map(Volume::bounds).reduce(AxisBox::join);
        bounds.unwrap_or(AxisBox { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY })
    }

    /// Returns the diagonal of the box around the region, in metres.
    pub fn diagonal_m(&self) -> f64 {
        let bounds = self.bounds();
        (bounds.max - bounds.min).length()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_and_balls_join() {
        let region = Region::parse(&["1,1,1,-1,-1,-1", "sphere:5,0,0,2"]).unwrap();
        let at = |x: f64| (region.contains(DVec3::X * x), region.distance_m(DVec3::X * x));
        assert_eq!(
            [at(0.0), at(1.0), at(2.0), at(3.0), at(8.0)].map(|found| found.0),
            [true, true, false, true, false]
        );
        assert_eq!([at(0.0), at(1.5), at(2.5), at(8.0)].map(|found| found.1), [0.0, 0.5, 0.5, 1.0]);
        assert_eq!(region.bounds().max, DVec3::new(7.0, 2.0, 2.0));
        assert_eq!(Region::parse(&["0,1,0,3,1,4"]).unwrap().diagonal_m(), 5.0);
    }

    #[test]
    fn what_is_no_region_is_named() {
        for text in ["", "1,2,3", "1,2,3,4,5,inf", "1,2,3,4,5,6,7", "sphere:1,2,3", "sphere:0,0,0,0", "nowhere.glb"] {
            let said = Region::parse(&[text]).unwrap_err().to_string();
            assert!(said.contains("sphere:x,y,z,r") && said.contains(text), "{text}: {said}");
        }
        let said = |text: &str| Region::parse(&[text]).unwrap_err().to_string();
        assert!(said("1,2,3").contains("six numbers") && said("1,2,3").contains("are 3"));
        assert!(said("1,2,x,4,5,6").contains("six finite numbers"));
        assert!(said("sphere:1,2,3").contains("four numbers") && said("sphere:1,2,3,-1").contains("above 0"));
        assert!(said("nowhere.glb").contains("no such file"));
        assert!(Region::parse(&[""; 0]).unwrap_err().to_string().contains("`region`"));
        assert!(Region::parse(&["-1e300,0,0,1e300,1,1"]).unwrap_err().to_string().contains("too large"));
    }
}
