//! Inputs of the planning kernels: all ways to reach a frame, tables of many lengths, and more items than a workgroup has
//! invocations.

use crate::harness::Case;
use crate::selftest::gathered::Gathered;
use codec::color::cells::builder::CellBuilder;
use codec::color::{CellChunk, CellFormat};
use codec::depth::record_table;
use codec::math::random::Random;
use kernels::layout::{
    Chunk, Dispatch, Item, Job, MAX_GROUPS, NONE, Record, State, Unit, WORKGROUP, list_of, words_of,
};
use kernels::prepare::{self, Prepared};

#[derive(Default)]
pub(super) struct Planned {
    all: Gathered,
    chunks: Vec<Chunk>,
    items: Vec<Item>,
    before: Vec<State>,
    after: Vec<State>,
}

impl Planned {
    fn push(&mut self, item: Item, states: [State; 2], job: Job, work: u32) {
        self.all.push_job(job, work);
        self.items.push(item);
        self.before.push(states[0]);
        self.after.push(states[1]);
    }

    fn case(self, label: &str) -> Case {
        let (count, total) = (self.items.len() as u32, self.all.work());
        let across = |groups: u32| groups.clamp(1, MAX_GROUPS);
        let groups = total.div_ceil(WORKGROUP);
        let (x, part_x) = (across(groups), across(total));
        let (y, part_y) = (groups.div_ceil(x), total.div_ceil(part_x));
        let dispatch = words_of(&[Dispatch { x, y, z: 1, part_x, part_y, part_z: 1 }]);
        let jobs = self.all.job_words();
        Case {
            label: label.to_owned(),
            // One workgroup plans all items.
            invocations: 1,
            passes: 0,
            buffers: [
                ("units", words_of(&self.all.units)),
                ("chunks", words_of(&self.chunks)),
                ("records", words_of(&self.all.records)),
                ("items", list_of([count, 0], &self.items)),
                ("stream", self.all.stream),
                ("states", words_of(&self.before)),
                ("jobs", vec![0; jobs.len()]),
                ("dispatch", vec![0; dispatch.len()]),
            ]
            .into(),
            expected: vec![("states", words_of(&self.after)), ("jobs", jobs), ("dispatch", dispatch)],
            inputs: u64::from(count),
            pixels: u64::from(total),
        }
    }

    pub(super) fn push_records(&mut self, random: &mut Random) {
        let frames: Vec<u32> = ascending(random);
        let last = frames.last().copied().unwrap_or(0);
        let far = if random.one_in(8) { 1 << 31 } else { last + 9 };
        // If frames are coded independently, every frame has a record.
        let whole = random.one_in(6);
        let window = if whole { 0 } else { random.pick(&[1, 2, 3, 4, 17, 255]).unwrap_or(1) };
        let frames = if whole { (0..=last).collect() } else { frames };
        let number = self.all.units.len() as u32;
        let (key, frame) = (1 + number, random.below(if whole { last + 1 } else { far }));
        let at = match random.below(4) {
            0 => None,
            1 => Some(random.below(if whole { last + 1 } else { far })),
            _ => Some(frame.saturating_sub(random.below(8))),
        };
        let before = at.map_or(State { key: random.below(2) * 77_777, frame: 3, weight: 0 }, |frame| State {
            key,
            frame,
            weight: 0,
        });
        let steps: Vec<usize> = match (whole, at) {
            (true, Some(at)) if at == frame => vec![],
            (true, _) => vec![frame as usize],
            (false, at) => record_table::steps(&frames, |&frame| frame, at, frame, window as u8).take(2).collect(),
        };
        let first = self.all.records.len() as u32;
        let works: Vec<u32> = frames.iter().map(|_| random.below(2000)).collect();
        let rows = frames.iter().zip(&works).map(|(&frame, &work)| Record { frame, work, ..Record::default() });
        self.all.records.extend(rows);
        let shown = if steps.len() > 1 { frames[steps[0]] } else { frame };
        self.all.units.push(Unit { window, ..Unit::default() });
        let chunk = self.chunks.len() as u32;
        self.chunks.push(Chunk { first_record: first, record_count: frames.len() as u32, ..Chunk::default() });
        let record = steps.first().map_or(NONE, |&step| first + step as u32);
        let work = steps.first().map_or(0, |&step| works[step]);
        let item = Item { unit: number, chunk, next: NONE, frame, key };
        let job = Job { unit: number, record, next: NONE, ..Job::default() };
        self.push(item, [before, State { key, frame: shown, weight: 0 }], job, work);
    }

    pub(super) fn push_cell(&mut self, random: &mut Random) {
        let mut builder = CellBuilder::default();
        for _ in 0..=random.below(5) {
            builder.push_keyframe::<u8>(&[random.word() as u8; 3]);
            (0..random.below(6)).for_each(|_| builder.push_weight(random.word() as u8, 1));
        }
        // More frames than weights: the last frames show a keyframe.
        let frames = builder.frame_count() + random.below(3);
        let Ok(payload) = builder.finish() else { return };
        let Ok(chunk) = CellChunk::<u8>::parse(payload, CellFormat::of_samples(1, 1), frames) else { return };
        let Prepared { stream, records, weights, .. } = prepare::of_cells(&chunk);
        let (bytes, first) = (4 * self.all.stream.len() as u32, self.all.records.len() as u32);
        let works: Vec<u32> = records.iter().map(|_| random.below(2000)).collect();
        let rows = records.iter().zip(&works).map(|(row, &work)| Record { at: row.at + bytes, work, ..*row });
        self.all.records.extend(rows);
        let next_chunk = Chunk { first_record: self.all.records.len() as u32, record_count: 1, ..Chunk::default() };
        self.all.records.push(Record::default());
        self.all.stream.extend(stream);
        let number = self.all.units.len() as u32;
        self.all.units.push(Unit::default());
        let (slot, key) = (self.chunks.len() as u32, 1 + number);
        let [weights_at, weight_count] = weights;
        let record_count = records.len() as u32;
        self.chunks.push(Chunk { first_record: first, record_count, weights_at: weights_at + bytes, weight_count });
        self.chunks.push(next_chunk);
        let frame = random.below(frames);
        let blend = chunk.blend(frame);
        let (keyframe, weight) = (blend.keyframe as u32, u32::from(blend.weight));
        let after = State { key, frame: keyframe, weight };
        let before = random
            .pick(&[after, State::default(), State { weight: weight ^ 1, ..after }, State { key: 0, ..after }])
            .unwrap_or_default();
        let item = Item { unit: number, chunk: slot, next: slot + 1, frame, key };
        let job = Job { unit: number, record: NONE, next: NONE, ..Job::default() };
        if before == after {
            return self.push(item, [before, after], job, 0);
        }
        let next = match (weight, chunk.is_last(blend.keyframe)) {
            (0, _) => first + keyframe,
            (_, false) => first + keyframe + 1,
            (_, true) => next_chunk.first_record,
        };
        let job = Job { record: first + keyframe, next, weight, ..job };
        self.push(item, [before, after], job, works[blend.keyframe]);
    }
}

/// Returns the frames of a table: ascending from 0.
fn ascending(random: &mut Random) -> Vec<u32> {
    let mut frames = vec![0];
    for _ in 0..random.below(40) {
        let gap = if random.one_in(3) { 1 + random.below(300) } else { 1 + random.below(4) };
        frames.push(frames[frames.len() - 1] + gap);
    }
    frames
}

pub(super) fn cases(seed: u64, push: fn(&mut Planned, &mut Random)) -> Vec<Case> {
    let random = &mut Random::new(seed);
    let case = |count: usize| {
        let mut planned = Planned::default();
        (0..count).for_each(|_| push(&mut planned, random));
        planned.case(&format!("{count} items"))
    };
    [1, 255, 256, 257, 3000].map(case).into()
}
