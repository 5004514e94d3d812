//! Finds and opens graphics devices, and converts their failures to errors of the crate.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use codec::error::{Error, Result};
use kernels::{Binding, BindingKind, Kernel};

/// Maximum size in bytes of a kernel's buffer on any device: byte offsets must fit 32 bits.
const MAX_BUFFER_BYTES: u64 = 1 << 30;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DeviceChoice {
    /// A hardware graphics device if there is one, otherwise the CPU.
    Auto,
    /// A graphics device, including software Vulkan; an error if there is none.
    Gpu,
    Cpu,
}

#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Pick {
    /// The fastest kind, in the order discrete, integrated, virtual, software.
    #[default]
    Best,
    /// The device at this index of [`list`].
    Index(usize),
    /// The first device whose name contains this text, ignoring case.
    Named(String),
}

impl Pick {
    /// Parses the value of an environment variable: an index, or part of a device name.
    pub fn parse(words: &str) -> Pick {
        match words.trim() {
            "" => Pick::Best,
            words => words.parse().map_or_else(|_| Pick::Named(words.to_owned()), Pick::Index),
        }
    }
}

#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct DeviceInfo {
    /// Index in [`list`].
    pub index: usize,
    pub name: String,
    /// `discrete`, `integrated`, `virtual`, `software` or `other`.
    pub kind: &'static str,
    pub driver: String,
    /// `vulkan`, `metal` or `dx12`.
    pub backend: String,
    /// Maximum size in bytes of a buffer bound to a kernel.
    pub max_binding_bytes: u64,
    #[serde(rename = "max_workgroup_invocations")]
    pub max_invocations: u32,
}

impl DeviceInfo {
    fn of(index: usize, adapter: &wgpu::Adapter) -> DeviceInfo {
        let (info, limits) = (adapter.get_info(), adapter.limits());
        let driver = [info.driver.as_str(), info.driver_info.as_str()];
        let largest = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        DeviceInfo {
            index,
            name: info.name.clone(),
            kind: match info.device_type {
                wgpu::DeviceType::DiscreteGpu => "discrete",
                wgpu::DeviceType::IntegratedGpu => "integrated",
                wgpu::DeviceType::VirtualGpu => "virtual",
                wgpu::DeviceType::Cpu => "software",
                wgpu::DeviceType::Other => "other",
            },
            driver: driver.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(" "),
            backend: info.backend.to_string(),
            max_binding_bytes: largest.min(MAX_BUFFER_BYTES) / 16 * 16,
            max_invocations: limits.max_compute_invocations_per_workgroup,
        }
    }

    pub fn is_software(&self) -> bool {
        self.kind == "software"
    }

    fn rank(&self) -> usize {
        ["discrete", "integrated", "virtual", "other"].iter().position(|kind| *kind == self.kind).unwrap_or(usize::MAX)
    }
}

fn binding_type(binding: Binding) -> wgpu::BindingType {
    let texture = |sample_type| wgpu::BindingType::Texture {
        sample_type,
        view_dimension: wgpu::TextureViewDimension::D2Array,
        multisampled: false,
    };
    match binding.kind {
        BindingKind::ReadOnlyStorage | BindingKind::Storage => wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only: !binding.is_written() },
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        BindingKind::Uint => texture(wgpu::TextureSampleType::Uint),
        BindingKind::UnfilterableFloat => texture(wgpu::TextureSampleType::Float { filterable: false }),
    }
}

fn adapters() -> Vec<wgpu::Adapter> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY))
}

pub fn list() -> Vec<DeviceInfo> {
    adapters().iter().enumerate().map(|(index, adapter)| DeviceInfo::of(index, adapter)).collect()
}

/// Opens the chosen device, or returns `None` for the CPU; with a message if `Auto` falls back to the CPU.
pub fn choose(choice: DeviceChoice, pick: &Pick) -> Result<(Option<Gpu>, Option<String>)> {
    match choice {
        DeviceChoice::Cpu => Ok((None, None)),
        DeviceChoice::Gpu => Gpu::open(pick).map(|gpu| (Some(gpu), None)),
        DeviceChoice::Auto => {
            let refused = |why: &str| Ok((None, Some(format!("{why}; using the CPU instead"))));
            let found = if *pick == Pick::Best { list() } else { Vec::new() };
            if *pick == Pick::Best && found.is_empty() {
                return refused("no graphics device was found");
            }
            if *pick == Pick::Best && found.iter().all(DeviceInfo::is_software) {
                return refused("the only graphics device is a software renderer; `device` gpu selects it");
            }
            Gpu::open(pick).map(|gpu| (Some(gpu), None)).or_else(|error| refused(&error.to_string()))
        }
    }
}

#[derive(Debug)]
pub struct Pipeline {
    pub pipeline: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
    bindings: &'static [Binding],
}

#[derive(Debug)]
pub struct Gpu {
    pub info: DeviceInfo,
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    lost: Arc<OnceLock<String>>,
    pipelines: Mutex<HashMap<&'static str, Arc<Pipeline>>>,
    scratch: Mutex<Option<wgpu::Buffer>>,
}

impl Gpu {
    pub fn open(pick: &Pick) -> Result<Gpu> {
        let mut found: Vec<_> = adapters().into_iter().enumerate().collect();
        found.sort_by_key(|(index, adapter)| DeviceInfo::of(*index, adapter).rank());
        let count = found.len();
        let wanted = |index: usize, adapter: &wgpu::Adapter| match pick {
            Pick::Best => true,
            Pick::Index(at) => index == *at,
            Pick::Named(words) => adapter.get_info().name.to_lowercase().contains(&words.to_lowercase()),
        };
        let Some((index, adapter)) = found.into_iter().find(|(index, adapter)| wanted(*index, adapter)) else {
            return Err(Error::unsupported(match pick {
                Pick::Best => "no graphics device was found: install a Vulkan driver, or use `device` cpu".to_owned(),
                Pick::Index(at) => format!("there is no graphics device {at}, only {count}; see `list_devices`"),
                Pick::Named(words) => format!("no graphics device is named '{words}'; see `list_devices`"),
            }));
        };
        let info = DeviceInfo::of(index, &adapter);
        let limits = adapter.limits();
        // Default limits of WebGPU, except for buffer sizes.
        let required_limits = wgpu::Limits {
            max_storage_buffer_binding_size: limits.max_storage_buffer_binding_size,
            max_buffer_size: limits.max_buffer_size,
            ..wgpu::Limits::default()
        };
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("lightfold"),
            required_limits,
            memory_hints: wgpu::MemoryHints::MemoryUsage,
            ..wgpu::DeviceDescriptor::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|error| Error::unsupported(format!("{} cannot be opened: {error}", info.name)))?;
        let lost = Arc::new(OnceLock::new());
        let reason = Arc::clone(&lost);
        device.set_device_lost_callback(move |_, words| {
            let _ = reason.set(words);
        });
        // By default an uncaptured error ends the process.
        let reason = Arc::clone(&lost);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            let _ = reason.set(error.to_string());
        }));
        Ok(Gpu { info, device, queue, lost, pipelines: Mutex::new(HashMap::new()), scratch: Mutex::new(None) })
    }

    /// Runs work on the device. If the device reports an error, returns an error that begins with `what`.
    pub fn guard<T>(&self, what: &str, work: impl FnOnce() -> T) -> Result<T> {
        let filters = [wgpu::ErrorFilter::Internal, wgpu::ErrorFilter::OutOfMemory, wgpu::ErrorFilter::Validation];
        let mut scopes: Vec<_> = filters.into_iter().map(|filter| self.device.push_error_scope(filter)).collect();
        let done = work();
        let mut refused = None;
        while let Some(scope) = scopes.pop() {
            refused = refused.or(pollster::block_on(scope.pop()));
        }
        if refused.is_some() {
            // Polling detects a lost device.
            let _ = self.device.poll(wgpu::PollType::Poll);
        }
        self.check_lost()?;
        match refused {
            None => Ok(done),
            Some(wgpu::Error::OutOfMemory { .. }) => Err(self.failed(what, "it is out of memory")),
            Some(error) => Err(self.failed(what, &error.to_string())),
        }
    }

    pub fn failed(&self, what: &str, why: &str) -> Error {
        Error::unsupported(format!("{}: {what}: {why}; use the CPU instead", self.info.name))
    }

    fn check_lost(&self) -> Result<()> {
        match self.lost.get() {
            None => Ok(()),
            Some(words) => Err(self.failed("the device was lost", words.trim())),
        }
    }

    pub fn wait(&self) -> Result<()> {
        let polled = self.device.poll(wgpu::PollType::wait_indefinitely());
        self.check_lost()?;
        polled.map(|_| ()).map_err(|error| self.failed("waiting", &error.to_string()))
    }

    /// Creates a zeroed storage buffer of `words` words.
    pub fn buffer(&self, label: &str, words: usize, more: wgpu::BufferUsages) -> Result<wgpu::Buffer> {
        let size = (words.max(4) * 4) as u64;
        if size > self.info.max_binding_bytes {
            let most = self.info.max_binding_bytes;
            return Err(self.failed(label, &format!("{size} bytes are needed at once, {most} are allowed")));
        }
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC | more;
        let descriptor = wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false };
        self.guard(label, || self.device.create_buffer(&descriptor))
    }

    /// Returns scratch memory of at least `words` words, shared by all decoders. It is zeroed when created, and every
    /// submission must leave it as it found it.
    pub fn scratch(&self, words: usize) -> Result<wgpu::Buffer> {
        let mut held = self.scratch.lock().unwrap_or_else(PoisonError::into_inner);
        match &*held {
            Some(scratch) if scratch.size() >= 4 * words as u64 => Ok(scratch.clone()),
            _ => Ok(held.insert(self.buffer("scratch", words, wgpu::BufferUsages::empty())?).clone()),
        }
    }

    pub fn filled(&self, label: &str, words: &[u32]) -> Result<wgpu::Buffer> {
        let buffer = self.buffer(label, words.len(), wgpu::BufferUsages::empty())?;
        self.write(label, &buffer, words)?;
        Ok(buffer)
    }

    pub fn write(&self, label: &str, buffer: &wgpu::Buffer, words: &[u32]) -> Result<()> {
        self.guard(label, || self.queue.write_buffer(buffer, 0, bytemuck::cast_slice(words)))
    }

    pub fn submit(&self, what: &str, record: impl FnOnce(&mut wgpu::CommandEncoder)) -> Result<()> {
        self.guard(what, || {
            let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            record(&mut encoder);
            self.queue.submit([encoder.finish()]);
        })
    }

    pub fn compute(&self, what: &str, record: impl FnOnce(&mut wgpu::ComputePass<'_>)) -> Result<()> {
        self.submit(what, |encoder| record(&mut encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default())))
    }

    /// Reads the first words of a buffer, after all submitted work.
    pub fn read(&self, buffer: &wgpu::Buffer, words: usize) -> Result<Vec<u32>> {
        if words == 0 {
            return Ok(Vec::new());
        }
        let (what, size) = ("reading back", (words * 4) as u64);
        let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let descriptor = wgpu::BufferDescriptor { label: Some(what), size, usage, mapped_at_creation: false };
        let target = self.guard(what, || self.device.create_buffer(&descriptor))?;
        self.submit(what, |encoder| encoder.copy_buffer_to_buffer(buffer, 0, &target, 0, size))?;
        self.guard(what, || target.map_async(wgpu::MapMode::Read, .., |_| {}))?;
        self.wait()?;
        let view = target.get_mapped_range(..).map_err(|error| self.failed(what, &error.to_string()))?;
        Ok(bytemuck::pod_collect_to_vec(&view))
    }

    /// Returns the pipeline of a kernel, which is compiled on first use.
    pub fn pipeline(&self, kernel: &'static Kernel) -> Result<Arc<Pipeline>> {
        let mut known = self.pipelines.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(found) = known.get(kernel.name) {
            return Ok(Arc::clone(found));
        }
        let made = Arc::new(self.guard(kernel.name, || self.compile(kernel))?);
        known.insert(kernel.name, Arc::clone(&made));
        Ok(made)
    }

    fn compile(&self, kernel: &'static Kernel) -> Pipeline {
        let label = Some(kernel.name);
        let source = wgpu::ShaderSource::Wgsl(kernel.source().into());
        let module = self.device.create_shader_module(wgpu::ShaderModuleDescriptor { label, source });
        let (layout, pipeline_layout) = self.layouts(kernel.name, kernel.bindings, wgpu::ShaderStages::COMPUTE);
        let pipeline = self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label,
            layout: Some(&pipeline_layout),
            module: &module,
            entry_point: Some(kernel.entry),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        Pipeline { pipeline, layout, bindings: kernel.bindings }
    }

    /// Creates the layouts of a bind group and of a pipeline with these bindings.
    pub(super) fn layouts(
        &self,
        label: &'static str,
        bindings: &[Binding],
        visibility: wgpu::ShaderStages,
    ) -> (wgpu::BindGroupLayout, wgpu::PipelineLayout) {
        let entry = |(at, binding): (usize, &Binding)| wgpu::BindGroupLayoutEntry {
            binding: at as u32,
            visibility,
            ty: binding_type(*binding),
            count: None,
        };
        let (label, entries) = (Some(label), bindings.iter().enumerate().map(entry).collect::<Vec<_>>());
        let layout =
            self.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label, entries: &entries });
        let descriptor =
            wgpu::PipelineLayoutDescriptor { label, bind_group_layouts: &[Some(&layout)], immediate_size: 0 };
        let of_pipeline = self.device.create_pipeline_layout(&descriptor);
        (layout, of_pipeline)
    }

    /// Creates a bind group; `resource` returns the resource of a binding by its name.
    pub fn bind<'r>(
        &self,
        pipeline: &Pipeline,
        resource: impl Fn(&str) -> Option<wgpu::BindingResource<'r>>,
    ) -> wgpu::BindGroup {
        self.bind_to(&pipeline.layout, pipeline.bindings, resource)
    }

    pub(super) fn bind_to<'r>(
        &self,
        layout: &wgpu::BindGroupLayout,
        bindings: &[Binding],
        resource: impl Fn(&str) -> Option<wgpu::BindingResource<'r>>,
    ) -> wgpu::BindGroup {
        let entry =
            |(binding, row): (u32, &Binding)| Some(wgpu::BindGroupEntry { binding, resource: resource(row.name)? });
        let entries: Vec<_> = (0..).zip(bindings).filter_map(entry).collect();
        self.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
    }
}
