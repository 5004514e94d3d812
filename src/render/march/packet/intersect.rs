//! Ray marching of four rays at once.
//!
//! Takes active views and the directions of four rays. Returns the hits and counts of
//! [`crate::march::layers::Primary::first_hits`], bit for bit.

use glam::Vec3;

use crate::march::packet::lanes::{ALL, Lanes, Points, either, lanes_of};
use crate::march::packet::views::PacketViews;
use crate::march::segments::{Next, Walk};
use crate::march::{Acceleration, Counters, FirstHits, RenderSettings, Steps};

#[derive(Debug, Clone, Copy)]
pub(crate) struct Packet {
    x: Lanes,
    y: Lanes,
    z: Lanes,
    /// Largest absolute coordinate of each direction.
    reach: Lanes,
    /// Rays in use, as bits.
    pub(crate) rays: u32,
}

impl Packet {
    /// Creates a packet of one to four rays from their directions of length 1.
    pub(crate) fn new(directions: &[Vec3]) -> Packet {
        let lanes = |part: fn(Vec3) -> f32| {
            Lanes::from_array(std::array::from_fn(|lane| {
                directions.get(lane).or(directions.first()).map_or(1.0, |&direction| part(direction))
            }))
        };
        let (x, y, z) = (lanes(|d| d.x), lanes(|d| d.y), lanes(|d| d.z));
        let reach = x.abs().max(y.abs()).max(z.abs());
        Packet { x, y, z, reach, rays: ALL >> (4 - directions.len().min(4)) }
    }

    pub(crate) fn at(&self, distance_m: Lanes) -> Points {
        // `Ray::at` also adds the origin. Rays of a packet start at 0, so leaving it out only affects the sign of a zero.
        Points { x: self.x * distance_m, y: self.y * distance_m, z: self.z * distance_m }
    }
}

/// Returns the lanes that have a value, as bits.
pub(crate) fn bits_of<T>(lanes: &[Option<T>; 4]) -> u32 {
    lanes.iter().enumerate().fold(0, |bits, (lane, has)| bits | u32::from(has.is_some()) << lane)
}

/// Views that are marched, and the condition that ends marching.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Marching {
    /// All views, until a surface.
    All,
    /// One view, until a point that it does not see past.
    One(usize),
}

/// State of marching packets. The view that proved the last segment is tested first, which does not change results.
pub(crate) struct PacketMarch<'a> {
    views: &'a PacketViews<'a>,
    order: Vec<usize>,
    /// Face of the last points in each view.
    guesses: Vec<usize>,
}

impl<'a> PacketMarch<'a> {
    pub(crate) fn new(views: &'a PacketViews<'a>) -> PacketMarch<'a> {
        let count = views.views.len();
        PacketMarch { views, order: (0..count).collect(), guesses: vec![0; count] }
    }

    pub(crate) fn guesses(&mut self) -> &mut [usize] {
        &mut self.guesses
    }

    fn proved_last(&mut self, rank: usize) {
        self.order[..=rank].rotate_right(1);
    }

    /// Returns the tested lanes whose points end marching: with all views, points that
    /// [`crate::march::active_views::ActiveViews::is_surface`] accepts; with one view, points that the view does not see past.
    fn stops(&mut self, marching: Marching, tested: u32, points: &Points) -> u32 {
        if let Marching::One(at) = marching {
            return tested & !self.views.views[at].test(points, &mut self.guesses[at]).empty;
        }
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
        left & occupied
    }

    /// Packet form of [`crate::march::layers::Primary::first_hits`].
    pub(crate) fn first_hits(
        &mut self,
        packet: &Packet,
        settings: &RenderSettings,
        counters: &mut Counters,
    ) -> [FirstHits; 4] {
        let steps = &settings.steps;
        let mut from: [Option<usize>; 4] = std::array::from_fn(|lane| (packet.rays >> lane & 1 != 0).then_some(0));
        let mut nearest_m = [None; 4];
        if let Some(nearest) = self.views.nearest.filter(|_| settings.refinements.thin) {
            from = self.first_steps(packet, settings, (Marching::One(nearest), from), counters);
            let occupied = self.occupied(nearest, packet, steps, from);
            let known = std::array::from_fn(|lane| from[lane].filter(|_| occupied >> lane & 1 != 0));
            nearest_m = self.refine(packet, steps, (Marching::One(nearest), known), counters);
        }
        let all_m = self.hits(packet, settings, from, counters);
        std::array::from_fn(|lane| FirstHits { nearest_m: nearest_m[lane], all_m: all_m[lane] })
    }

    /// Packet form of [`crate::march::intersect::intersect_from`], with a first step for each ray.
    pub(crate) fn hits(
        &mut self,
        packet: &Packet,
        settings: &RenderSettings,
        from: [Option<usize>; 4],
        counters: &mut Counters,
    ) -> [Option<f32>; 4] {
        if from == [None; 4] {
            return [None; 4];
        }
        let steps = self.first_steps(packet, settings, (Marching::All, from), counters);
        self.refine(packet, &settings.steps, (Marching::All, steps), counters)
    }

    /// Returns the lanes whose points at these steps are on or behind a surface of all views.
    pub(crate) fn surfaces(
        &mut self,
        packet: &Packet,
        steps: &Steps,
        at: [Option<usize>; 4],
        counters: &mut Counters,
    ) -> u32 {
        let Some(other) = at.iter().flatten().next().copied() else { return 0 };
        let tested = bits_of(&at);
        counters.march_steps += u64::from(tested.count_ones());
        let points = packet.at(Lanes::from_array(at.map(|at| steps.distances_m[at.unwrap_or(other)])));
        self.stops(Marching::All, tested, &points)
    }

    /// Returns the lanes whose points at these steps are on or behind a surface of one view.
    fn occupied(&mut self, view: usize, packet: &Packet, steps: &Steps, at: [Option<usize>; 4]) -> u32 {
        let Some(other) = at.iter().flatten().next().copied() else { return 0 };
        let points = packet.at(Lanes::from_array(at.map(|at| steps.distances_m[at.unwrap_or(other)])));
        bits_of(&at) & self.views.views[view].test(&points, &mut self.guesses[view]).occupied
    }

    /// Packet form of [`crate::march::intersect::first_step`], with a first step for each ray.
    fn first_steps(
        &mut self,
        packet: &Packet,
        settings: &RenderSettings,
        (marching, from): (Marching, [Option<usize>; 4]),
        counters: &mut Counters,
    ) -> [Option<usize>; 4] {
        match settings.acceleration {
            Acceleration::None => self.every_point(packet, &settings.steps.distances_m, (marching, from), counters),
            Acceleration::Pyramid => self.segments(packet, &settings.steps.distances_m, (marching, from), counters),
        }
    }

    fn every_point(
        &mut self,
        packet: &Packet,
        distances_m: &[f32],
        (marching, from): (Marching, [Option<usize>; 4]),
        counters: &mut Counters,
    ) -> [Option<usize>; 4] {
        let (mut hits, mut live) = ([None; 4], bits_of(&from));
        for (at, &distance_m) in distances_m.iter().enumerate() {
            let begun = lanes_of(live).filter(|&lane| from[lane].is_some_and(|from| from <= at));
            let begun = begun.fold(0u32, |bits, lane| bits | 1 << lane);
            counters.march_steps += u64::from(begun.count_ones());
            let met = if begun == 0 { 0 } else { self.stops(marching, begun, &packet.at(Lanes::splat(distance_m))) };
            lanes_of(met).for_each(|lane| hits[lane] = Some(at));
            live &= !met;
            if live == 0 {
                break;
            }
        }
        hits
    }

    fn segments(
        &mut self,
        packet: &Packet,
        distances_m: &[f32],
        (marching, first): (Marching, [Option<usize>; 4]),
        counters: &mut Counters,
    ) -> [Option<usize>; 4] {
        let mut walks = first.map(|first| Walk::new(first.unwrap_or(0), distances_m.len()));
        let (mut hits, mut live) = ([None; 4], bits_of(&first));
        let (mut from_m, mut to_m, mut last) = ([0.0; 4], [0.0; 4], [0; 4]);
        let ranks = if let Marching::One(_) = marching { 1 } else { self.order.len() };
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
            for rank in 0..ranks {
                let at = if let Marching::One(at) = marching { at } else { self.order[rank] };
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
                    if marching == Marching::All {
                        self.proved_last(rank);
                    }
                    break;
                }
            }
            let ends = |lane: usize| marching != Marching::All || occupied >> lane & 1 != 0;
            for lane in lanes_of(live) {
                if left >> lane & 1 != 0 {
                    walks[lane].failed(last[lane], (past >> lane & 1 == 0).then(|| ends(lane)));
                } else {
                    walks[lane].passed();
                }
            }
        }
    }

    fn refine(
        &mut self,
        packet: &Packet,
        steps: &Steps,
        (marching, hits): (Marching, [Option<usize>; 4]),
        counters: &mut Counters,
    ) -> [Option<f32>; 4] {
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
            let met = match marching {
                Marching::All => self.stops(marching, tested, &packet.at(middle_m)),
                Marching::One(at) => {
                    tested & self.views.views[at].test(&packet.at(middle_m), &mut self.guesses[at]).occupied
                }
            };
            let met = glam::BVec4A::new(met & 1 != 0, met & 2 != 0, met & 4 != 0, met & 8 != 0);
            surface_m = either(met, middle_m, surface_m);
            empty_m = either(met, empty_m, middle_m);
        }
        let surface_m = surface_m.to_array();
        std::array::from_fn(|lane| hits[lane].map(|_| surface_m[lane]))
    }
}
