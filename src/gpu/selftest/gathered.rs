//! Collects the units of one dispatch into the buffers of a decoding kernel.

use crate::harness::Case;
use codec::depth::domain::LOG2_TABLE;
use kernels::layout::{BoxRow, Job, Record, SCRATCH_WORDS, Unit, list_of, words_of};

#[derive(Default)]
pub struct Gathered {
    pub units: Vec<Unit>,
    pub records: Vec<Record>,
    pub boxes: Vec<BoxRow>,
    pub jobs: Vec<Job>,
    pub stream: Vec<u32>,
    /// Tables of the transform codec.
    pub tables: Vec<u32>,
    /// Passes of the kernel's reader.
    pub passes: u32,
    /// Pictures before the dispatch; missing words are 0.
    pub before: Vec<u32>,
    /// Expected pictures after the dispatch.
    pub expected: Vec<u32>,
    pub inputs: u64,
    pub pixels: u64,
}

impl Gathered {
    /// Adds a unit whose expected picture is `shown`; returns its index.
    pub fn push_unit(&mut self, unit: Unit, shown: Vec<u32>) -> u32 {
        let (picture, stride) = (self.expected.len() as u32, shown.len() as u32 / unit.height);
        self.units.push(Unit { picture, stride, ..unit });
        self.expected.extend(shown);
        self.units.len() as u32 - 1
    }

    /// Adds a job; its work follows that of the previous jobs.
    pub fn push_job(&mut self, job: Job, work: u32) {
        self.jobs.push(Job { end: self.work() + work, ..job });
    }

    /// Adds a unit to which a record is applied.
    pub fn push(&mut self, unit: Unit, record: Record, shown: Vec<u32>) {
        let job = Job { unit: self.push_unit(unit, shown), record: self.records.len() as u32, ..Job::default() };
        self.push_job(job, record.work);
        self.records.push(record);
    }

    pub fn work(&self) -> u32 {
        self.jobs.last().map_or(0, |job| job.end)
    }

    pub fn job_words(&self) -> Vec<u32> {
        list_of([self.work(), self.jobs.len() as u32], &self.jobs)
    }

    pub fn case(mut self, label: &str) -> Case {
        self.before.resize(self.expected.len(), 0);
        let scratch = if self.passes > 0 { self.work() * SCRATCH_WORDS } else { 0 };
        Case {
            label: label.to_owned(),
            invocations: self.work(),
            passes: self.passes,
            buffers: [
                ("units", words_of(&self.units)),
                ("records", words_of(&self.records)),
                ("boxes", words_of(&self.boxes)),
                ("jobs", self.job_words()),
                ("stream", self.stream),
                ("tables", self.tables),
                ("log2_table", LOG2_TABLE.to_vec()),
                ("scratch", vec![0; scratch as usize]),
                ("pictures", self.before),
            ]
            .into(),
            expected: vec![("pictures", self.expected)],
            inputs: self.inputs,
            pixels: self.pixels,
        }
    }
}
