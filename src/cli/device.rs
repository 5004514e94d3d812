//! Options for graphics devices, the list of devices, and fallback to the CPU.

use serde::Serialize;

use crate::options::Choices;
use crate::report::Table;
use crate::{ExitStatus, GlobalArgs, output};
use codec::error::{Error, Result};
use gpu::device::{self, DeviceChoice, DeviceInfo, Gpu, Pick};

/// Number or part of the name of a graphics device, used without `--gpu-index`.
const VARIABLE: &str = "LIGHTFOLD_GPU";

#[derive(Debug, Clone, clap::Args)]
pub struct GpuArgs {
    #[command(flatten)]
    pub index: GpuIndex,
    /// List graphics devices and exit
    #[arg(long)]
    pub list_devices: bool,
}

#[derive(Debug, Clone, clap::Args)]
pub struct GpuIndex {
    /// Index of the graphics device; or set LIGHTFOLD_GPU to an index or a part of its name
    #[arg(long, value_name = "N")]
    pub gpu_index: Option<usize>,
}

pub const DEVICES: &Choices<DeviceChoice> = &[
    ("auto", DeviceChoice::Auto, "Hardware graphics device if there is one, else CPU"),
    ("gpu", DeviceChoice::Gpu, "Graphics device; an error if there is none"),
    ("cpu", DeviceChoice::Cpu, "CPU"),
];

impl GpuIndex {
    /// True if a graphics device is requested.
    pub fn is_on_device(&self, choice: Option<DeviceChoice>) -> bool {
        self.gpu_index.is_some() || choice.is_some_and(|device| device != DeviceChoice::Cpu)
    }

    /// Returns the device selected by the option or the environment.
    pub fn pick(&self) -> Pick {
        let variable = || std::env::var(VARIABLE).map_or(Pick::Best, |words| Pick::parse(&words));
        self.gpu_index.map_or_else(variable, Pick::Index)
    }

    /// Opens the graphics device, or returns `None` for the CPU. Notes why `auto` found none. Naming a device selects
    /// it.
    pub fn open(&self, choice: Option<DeviceChoice>, global: &GlobalArgs) -> Result<Option<Gpu>> {
        let usual = if self.gpu_index.is_some() { DeviceChoice::Gpu } else { DeviceChoice::Cpu };
        let (gpu, why) = device::choose(choice.unwrap_or(usual), &self.pick())?;
        why.iter().for_each(|why| global.note(why));
        Ok(gpu)
    }
}

/// Runs on a graphics device. Runs on the CPU if there is no device or, with `auto`, if the device fails.
pub fn or_on_cpu<'g, T>(
    (gpu, choice): (Option<&'g Gpu>, Option<DeviceChoice>),
    global: &GlobalArgs,
    on_gpu: impl FnOnce(&'g Gpu) -> Result<T>,
    on_cpu: impl FnOnce() -> Result<T>,
) -> Result<(T, String)> {
    let Some(gpu) = gpu else { return Ok((on_cpu()?, "cpu".to_owned())) };
    match on_gpu(gpu) {
        Ok(done) => Ok((done, gpu.info.name.clone())),
        Err(error @ Error::Unsupported { .. }) if choice == Some(DeviceChoice::Auto) => {
            global.note(format_args!("{error}; using the CPU instead"));
            Ok((on_cpu()?, "cpu".to_owned()))
        }
        Err(error) => Err(error),
    }
}

pub fn list(as_json: bool) -> Result<ExitStatus> {
    #[derive(Serialize)]
    struct Document {
        devices: Vec<DeviceInfo>,
    }
    let report = Document { devices: device::list() };
    output::print_either(as_json, &report, || {
        let mut table = Table::new(">#|Device|Kind|Backend|Driver|>Buffer MiB|>Workgroup");
        for info in &report.devices {
            table.row([
                info.index.to_string(),
                info.name.clone(),
                info.kind.to_owned(),
                info.backend.clone(),
                info.driver.clone(),
                (info.max_binding_bytes >> 20).to_string(),
                info.max_invocations.to_string(),
            ]);
        }
        if report.devices.is_empty() { "no graphics device was found\n".to_owned() } else { table.to_string() }
    })?;
    Ok(ExitStatus::Passed)
}
