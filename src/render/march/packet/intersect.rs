//! Ray marching of four rays at once.
//!
//! Takes active views and the directions of four rays. Returns the hits and counts of the [`March`] of single rays, bit for bit.

use glam::Vec3;

use crate::march::packet::color::seen_from_eye;
use crate::march::packet::lanes::{ALL, Lanes, Points, either, lanes_of};
use crate::march::packet::views::PacketViews;
use crate::march::primary_rays::March;
use crate::march::segments::{Next, Walk};
use crate::march::{Acceleration, Counters, Interpolated, RenderSettings, Until};

#[derive(Debug, Clone, Copy)]
pub(crate) struct Packet {
    x: Lanes,
    y: Lanes,
    z: Lanes,
    /// Largest absolute coordinate of each direction.
    reach: Lanes,
}

impl Packet {
    /// Creates a packet of up to four rays from their directions of length 1.
    pub(crate) fn new(directions: &[Vec3]) -> Packet {
        let lanes = |part: fn(Vec3) -> f32| {
            Lanes::from_array(std::array::from_fn(|lane| {
                directions.get(lane).or(directions.first()).map_or(1.0, |&direction| part(direction))
            }))
        };
        let (x, y, z) = (lanes(|d| d.x), lanes(|d| d.y), lanes(|d| d.z));
        let reach = x.abs().max(y.abs()).max(z.abs());
        Packet { x, y, z, reach }
    }

    fn at(&self, distance_m: Lanes) -> Points {
        // `Ray::at` also adds the origin. Rays of a packet start at 0, so leaving it out only affects the sign of a zero.
        Points { x: self.x * distance_m, y: self.y * distance_m, z: self.z * distance_m }
    }

    /// Returns the lanes that have a distance in metres, as bits, and the points at these distances; other lanes copy a point of
    /// them. None without a distance.
    fn points(&self, at_m: [Option<f32>; 4]) -> Option<(u32, Points)> {
        let other_m = at_m.iter().flatten().next().copied()?;
        Some((bits_of(&at_m), self.at(Lanes::from_array(at_m.map(|at_m| at_m.unwrap_or(other_m))))))
    }
}

/// Returns the lanes that have a value, as bits.
fn bits_of<T>(lanes: &[Option<T>; 4]) -> u32 {
    lanes.iter().enumerate().fold(0, |bits, (lane, has)| bits | u32::from(has.is_some()) << lane)
}

/// March of packets. The view that proved the last segment is tested first, which does not change results.
pub(crate) struct PacketMarch<'a> {
    views: &'a PacketViews<'a>,
    settings: &'a RenderSettings,
    pub(crate) packet: Packet,
    order: Vec<usize>,
    /// Face of the last points in each view.
    guesses: Vec<usize>,
}

impl<'a> PacketMarch<'a> {
    pub(crate) fn new(views: &'a PacketViews<'a>, settings: &'a RenderSettings) -> PacketMarch<'a> {
        let count = views.views.len();
        PacketMarch { views, settings, packet: Packet::new(&[]), order: (0..count).collect(), guesses: vec![0; count] }
    }

    fn proved_last(&mut self, rank: usize) {
        self.order[..=rank].rotate_right(1);
    }

    /// Returns the tested lanes whose points end marching.
    fn stops(&mut self, until: Until, tested: u32, points: &Points) -> u32 {
        let (mut left, mut occupied) = (tested, 0);
        for rank in 0..self.order.len() {
            let at = self.order[rank];
            let occupancies = self.views.views[at].test(points, &mut self.guesses[at]);
            occupied |= occupancies.occupied;
            if left & occupancies.empty != 0 {
                left &= !occupancies.empty;
                if left == 0 {
                    self.proved_last(rank);
                    return 0;
                }
            }
        }
        if until == Until::Unknown { left } else { left & occupied }
    }

    fn every_point(&mut self, until: Until, from: [Option<usize>; 4], counters: &mut Counters) -> [Option<usize>; 4] {
        let (mut hits, mut live) = ([None; 4], bits_of(&from));
        for (at, &distance_m) in self.settings.steps.distances_m.iter().enumerate() {
            let begun = lanes_of(live).filter(|&lane| from[lane].is_some_and(|from| from <= at));
            let begun = begun.fold(0u32, |bits, lane| bits | 1 << lane);
            counters.march_steps += u64::from(begun.count_ones());
            let points = self.packet.at(Lanes::splat(distance_m));
            let met = if begun == 0 { 0 } else { self.stops(until, begun, &points) };
            lanes_of(met).for_each(|lane| hits[lane] = Some(at));
            live &= !met;
            if live == 0 {
                break;
            }
        }
        hits
    }

    fn segments(&mut self, until: Until, first: [Option<usize>; 4], counters: &mut Counters) -> [Option<usize>; 4] {
        let (packet, distances_m) = (self.packet, &self.settings.steps.distances_m[..]);
        let mut walks = first.map(|first| Walk::new(first.unwrap_or(0), distances_m.len()));
        let (mut hits, mut live) = ([None; 4], bits_of(&first));
        let (mut from_m, mut to_m, mut last) = ([0.0; 4], [0.0; 4], [0; 4]);
        loop {
            let mut single = 0;
            for lane in lanes_of(live) {
                match walks[lane].next(distances_m.len()) {
                    Next::Test(from, to) => {
                        single |= u32::from(from == to) << lane;
                        (from_m[lane], to_m[lane], last[lane]) = (distances_m[from], distances_m[to], to);
                        continue;
                    }
                    Next::Hit(at) => hits[lane] = Some(at),
                    Next::End => {}
                }
                live &= !(1 << lane);
            }
            if live == 0 {
                return hits;
            }
            counters.march_steps += u64::from(live.count_ones());
            // Lanes without a ray and finished lanes copy the segment of an active lane.
            if let Some(other) = lanes_of(live).next() {
                lanes_of(ALL & !live).for_each(|lane| (from_m[lane], to_m[lane]) = (from_m[other], to_m[other]));
            }
            let to_m = Lanes::from_array(to_m);
            let (from, to) = (packet.at(Lanes::from_array(from_m)), packet.at(to_m));
            let (mut left, mut occupied, mut past) = (live, 0, 0);
            for rank in 0..self.order.len() {
                let at = self.order[rank];
                let (view, guess) = (&self.views.views[at], &mut self.guesses[at]);
                let occupancies = view.test(&to, guess);
                occupied |= occupancies.occupied;
                past |= occupancies.empty;
                // A segment is not empty if its last point is not.
                let mut empty = left & single & occupancies.empty;
                let tested = left & !single & occupancies.empty;
                if tested != 0 {
                    empty |= view.prove(tested, [&from, &to], *guess, packet.reach * to_m);
                }
                left &= !empty;
                if left == 0 {
                    self.proved_last(rank);
                    break;
                }
            }
            let ends = |lane: usize| until == Until::Unknown || occupied >> lane & 1 != 0;
            for lane in lanes_of(live) {
                if left >> lane & 1 != 0 {
                    walks[lane].failed(last[lane], (past >> lane & 1 == 0).then(|| ends(lane)));
                } else {
                    walks[lane].passed();
                }
            }
        }
    }
}

impl March<4> for PacketMarch<'_> {
    fn first_steps(&mut self, until: Until, from: [Option<usize>; 4], counters: &mut Counters) -> [Option<usize>; 4] {
        match self.settings.acceleration {
            _ if from == [None; 4] => from,
            Acceleration::None => self.every_point(until, from, counters),
            Acceleration::Pyramid => self.segments(until, from, counters),
        }
    }

    fn on_surface(&mut self, steps: [Option<usize>; 4]) -> [Option<usize>; 4] {
        let at_m = steps.map(|step| step.map(|step| self.settings.steps.distances_m[step]));
        let Some((tested, points)) = self.packet.points(at_m) else { return steps };
        let met = self.stops(Until::Surface, tested, &points);
        std::array::from_fn(|lane| steps[lane].filter(|_| met >> lane & 1 != 0))
    }

    fn refine(&mut self, hits: [Option<usize>; 4], counters: &mut Counters) -> [Option<f32>; 4] {
        let steps = &self.settings.steps;
        let tested = bits_of(&hits);
        // Lanes without a hit copy that of another lane.
        let Some(other) = hits.iter().flatten().next().copied() else { return [None; 4] };
        let (mut empty_m, mut surface_m) = (Lanes::ZERO, Lanes::ZERO);
        for (lane, hit) in hits.iter().enumerate() {
            [empty_m[lane], surface_m[lane]] = steps.before(hit.unwrap_or(other));
        }
        for _ in 0..steps.refine() {
            let middle_m = 0.5 * (empty_m + surface_m);
            counters.refine_steps += u64::from(tested.count_ones());
            let met = self.stops(Until::Surface, tested, &self.packet.at(middle_m));
            let met = glam::BVec4A::new(met & 1 != 0, met & 2 != 0, met & 4 != 0, met & 8 != 0);
            surface_m = either(met, middle_m, surface_m);
            empty_m = either(met, empty_m, middle_m);
        }
        let surface_m = surface_m.to_array();
        std::array::from_fn(|lane| hits[lane].map(|_| surface_m[lane]))
    }

    fn seen(&mut self, at_m: [Option<f32>; 4]) -> [Option<Interpolated>; 4] {
        let Some((asked, points)) = self.packet.points(at_m) else { return [None; 4] };
        seen_from_eye(self.views, &mut self.guesses, (asked, &points), self.settings)
    }
}
