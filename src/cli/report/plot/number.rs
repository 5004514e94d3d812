//! Number formats of charts: three significant digits and unit prefixes.

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    pub name: &'static str,
    pub size: f64,
}

const BYTES: [Unit; 5] = [
    Unit { name: "B", size: 1.0 },
    Unit { name: "kB", size: 1e3 },
    Unit { name: "MB", size: 1e6 },
    Unit { name: "GB", size: 1e9 },
    Unit { name: "TB", size: 1e12 },
];

/// Returns the unit in which `largest`, a number of bytes, has one to three digits before the decimal point.
pub fn bytes_unit(largest: f64) -> Unit {
    let fitting = BYTES.iter().rev().find(|unit| largest.is_finite() && largest >= unit.size);
    // The unit of 0 bytes is kB.
    *fitting.unwrap_or(&BYTES[if largest > 0.0 { 0 } else { 1 }])
}

pub fn bytes(count: f64) -> String {
    let unit = bytes_unit(count);
    format!("{} {}", short(count / unit.size), unit.name)
}

/// Formats with three significant digits, or more if they precede the decimal point.
fn with_three_digits(value: f64) -> String {
    let digits = [(99.95, 0), (9.995, 1), (0.9995, 2)].into_iter().find(|(least, _)| value.abs() >= *least);
    format!("{value:.*}", digits.map_or(3, |(_, digits)| digits))
}

/// Formats with three significant digits, or more if they precede the decimal point; with the suffix `k` from 10,000
/// and `M` from 10 million.
pub fn short(value: f64) -> String {
    match value.abs() {
        size if size.is_nan() => "–".to_owned(),
        size if size.is_infinite() => if value > 0.0 { "∞" } else { "−∞" }.to_owned(),
        size if size >= 1e12 || (size > 0.0 && size < 5e-4) => format!("{value:.1e}"),
        size if size >= 1e7 => format!("{}M", short(value / 1e6)),
        size if size >= 1e4 => format!("{}k", short(value / 1e3)),
        _ => trimmed(&with_three_digits(value)),
    }
}

/// Like [`short`], but keeps trailing zeros, so that numbers of similar magnitude have the same number of digits.
pub fn even(value: f64) -> String {
    if (5e-4..99.95).contains(&value.abs()) { with_three_digits(value) } else { short(value) }
}

/// Formats a tick label with as many digits as needed to distinguish it from the next tick. `step` is 1, 2 or 5 times a
/// power of ten.
pub fn tick(value: f64, step: f64) -> String {
    let value = if value.abs() < step * 1e-6 { 0.0 } else { value };
    let size = value.abs();
    let of = |unit: f64, prefix: &str| {
        let digits = (-(step / unit).log10() - 1e-9).ceil().clamp(0.0, 9.0) as usize;
        format!("{}{prefix}", trimmed(&format!("{:.digits$}", value / unit)))
    };
    let usable = value.is_finite() && step.is_finite() && step > 0.0;
    match size {
        _ if !usable || size >= 1e12 || (size > 0.0 && size < 1e-6) => short(value),
        _ if size >= 1e7 => of(1e6, "M"),
        _ if size >= 1e4 => of(1e3, "k"),
        _ => of(1.0, ""),
    }
}

/// Removes trailing zeros after the decimal point and the sign of zero.
fn trimmed(number: &str) -> String {
    let shorter = if number.contains('.') { number.trim_end_matches('0').trim_end_matches('.') } else { number };
    let zero = shorter.strip_prefix('-').filter(|rest| rest.bytes().all(|byte| byte == b'0' || byte == b'.'));
    zero.unwrap_or(shorter).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let cases = [
            (0.0, "0"),
            (-0.0, "0"),
            (0.1 + 0.2, "0.3"),
            (1.0 / 3.0, "0.333"),
            (2.5, "2.5"),
            (9.996, "10"),
            (12.345, "12.3"),
            (99.96, "100"),
            (1234.5, "1234"),
            (12345.0, "12.3k"),
            (5.4e7, "54M"),
            (0.00001, "1.0e-5"),
            (f64::INFINITY, "∞"),
            (f64::NAN, "–"),
        ];
        for (value, expected) in cases {
            assert_eq!(short(value), expected, "{value}");
        }
    }

    #[test]
    fn even_numbers_keep_their_zeros() {
        let cases = [(3.0, "3.00"), (0.08, "0.080"), (12.0, "12.0"), (123.0, "123"), (0.0, "0"), (20_000.0, "20k")];
        for (value, expected) in cases {
            assert_eq!(even(value), expected, "{value}");
        }
    }

    #[test]
    fn ticks_have_the_digits_of_their_step() {
        assert_eq!(tick(0.30000000000000004, 0.1), "0.3");
        assert_eq!(tick(1005.0, 5.0), "1005");
        assert_eq!(tick(10050.0, 50.0), "10.05k");
        assert_eq!(tick(-1e-17, 0.1), "0");
    }

    #[test]
    fn units_fit() {
        assert_eq!([bytes(0.0), bytes(999.0), bytes(2_412_345.0)], ["0 kB", "999 B", "2.41 MB"]);
    }
}
