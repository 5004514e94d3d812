//! Description of the machine that figures were measured on, and the memory use of this process. Values that the
//! operating system does not provide are omitted.

use codec::error::counted;
use std::fs;

/// Returns the peak resident memory of this process in bytes. `None` if the system does not provide it.
pub fn peak_memory_bytes() -> Option<u64> {
    kibibytes(&fs::read_to_string("/proc/self/status").ok()?, "VmHWM:")
}

/// Returns the current resident memory of this process in bytes. `None` if the system does not provide it.
pub fn memory_bytes() -> Option<u64> {
    kibibytes(&fs::read_to_string("/proc/self/status").ok()?, "VmRSS:")
}

/// Returns a one-line description of the machine: processor, threads, memory, operating system. It does not change
/// between runs.
pub fn describe() -> String {
    let read = |path: &str| fs::read_to_string(path).unwrap_or_default();
    let memory = kibibytes(&read("/proc/meminfo"), "MemTotal:")
        .map_or_else(String::new, |bytes| format!(", {:.1} GiB of memory", bytes as f64 / (1u64 << 30) as f64));
    let release = read("/proc/sys/kernel/osrelease");
    let system = [std::env::consts::OS, release.trim()].join(" ");
    format!("{}{memory}, {} ({})", processor(), system.trim(), std::env::consts::ARCH)
}

pub fn processor() -> String {
    let model = field(&fs::read_to_string("/proc/cpuinfo").unwrap_or_default(), "model name")
        .or_else(|| std::env::var("PROCESSOR_IDENTIFIER").ok())
        .unwrap_or_else(|| std::env::consts::ARCH.to_owned());
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    format!("{model}, {}", counted(threads as u64, "thread"))
}

fn field(text: &str, name: &str) -> Option<String> {
    let line = text.lines().find(|line| line.starts_with(name))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}

/// Parses a line such as `VmHWM:  1234 kB` and returns its value in bytes.
fn kibibytes(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find(|line| line.starts_with(name))?;
    line.split_whitespace().nth(1)?.parse::<u64>().ok()?.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_proc_are_read() {
        let text = "VmPeak:\t 9000 kB\nVmHWM:\t    1234 kB\nmodel name\t: A Processor: X\n";
        assert_eq!(kibibytes(text, "VmHWM:"), Some(1234 * 1024));
        assert_eq!(kibibytes(text, "VmRSS:"), None);
        assert_eq!(kibibytes("VmHWM: much", "VmHWM:"), None);
        assert_eq!(field(text, "model name").as_deref(), Some("A Processor: X"));
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_peak_is_at_least_what_was_touched() {
        let touched = vec![1u8; 32 << 20];
        let peak = peak_memory_bytes().unwrap();
        assert!(peak >= touched.iter().map(|&byte| u64::from(byte)).sum(), "{peak}");
    }

    #[test]
    fn a_machine_is_its_processor_threads_memory_and_system() {
        let line = describe();
        let parts: Vec<&str> = line.rsplitn(if cfg!(target_os = "linux") { 4 } else { 3 }, ", ").collect();
        let (system, processor) = (parts[0], parts[parts.len() - 1]);
        assert!(system.starts_with(std::env::consts::OS), "{line}");
        assert!(system.ends_with(&format!("({})", std::env::consts::ARCH)), "{line}");
        assert!(!processor.trim().is_empty(), "{line}");
        let threads = parts[parts.len() - 2].split_once(' ').unwrap();
        let count = std::thread::available_parallelism().map_or(1, usize::from);
        assert_eq!(threads, (count.to_string().as_str(), if count == 1 { "thread" } else { "threads" }), "{line}");
        if cfg!(target_os = "linux") {
            let memory = parts[1].strip_suffix(" GiB of memory").and_then(|size| size.parse::<f64>().ok());
            assert!(memory.is_some_and(|size| size > 0.1), "{line}");
        }
    }
}
