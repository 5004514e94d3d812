//! Numbers as charts show them: three digits that count, and prefixes in place of zeros.

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// What stands behind the number.
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

/// The unit in which the largest of some bytes has one to three digits before the point.
pub fn bytes_unit(largest: f64) -> Unit {
    let fitting = BYTES.iter().rev().find(|unit| largest.is_finite() && largest >= unit.size);
    // Nothing at all is counted in kB, as little is.
    *fitting.unwrap_or(&BYTES[if largest > 0.0 { 0 } else { 1 }])
}

pub fn bytes(count: f64) -> String {
    let unit = bytes_unit(count);
    format!("{} {}", short(count / unit.size), unit.name)
}

/// A number with three digits that count, or more where they stand before the point; `k` from 10,000 and `M` from 10
/// million on.
pub fn short(value: f64) -> String {
    let size = value.abs();
    if value.is_nan() {
        "–".to_owned()
    } else if value.is_infinite() {
        if value > 0.0 { "∞" } else { "−∞" }.to_owned()
    } else if size >= 1e12 || (size > 0.0 && size < 5e-4) {
        format!("{value:.1e}")
    } else if size >= 1e7 {
        format!("{}M", short(value / 1e6))
    } else if size >= 1e4 {
        format!("{}k", short(value / 1e3))
    } else {
        let digits = if size >= 99.95 {
            0
        } else if size >= 9.995 {
            1
        } else if size >= 0.9995 {
            2
        } else {
            3
        };
        trimmed(&format!("{value:.digits$}"))
    }
}

/// The same with zeros at its end kept, so that numbers of a size have as many digits.
pub fn even(value: f64) -> String {
    let size = value.abs();
    match size {
        small if (5e-4..0.9995).contains(&small) => format!("{value:.3}"),
        ones if (0.9995..9.995).contains(&ones) => format!("{value:.2}"),
        tens if (9.995..99.95).contains(&tens) => format!("{value:.1}"),
        _ => short(value),
    }
}

/// A tick's number, with the digits that tell it from the next one, a step of 1, 2 or 5 times a power of ten away.
pub fn tick(value: f64, step: f64) -> String {
    let value = if value.abs() < step * 1e-6 { 0.0 } else { value };
    let size = value.abs();
    let of = |value: f64, step: f64| {
        let digits = (-step.log10() - 1e-9).ceil().clamp(0.0, 9.0) as usize;
        trimmed(&format!("{value:.digits$}"))
    };
    let usable = value.is_finite() && step.is_finite() && step > 0.0;
    if !usable || size >= 1e12 || (size > 0.0 && size < 1e-6) {
        short(value)
    } else if size >= 1e7 {
        format!("{}M", of(value / 1e6, step / 1e6))
    } else if size >= 1e4 {
        format!("{}k", of(value / 1e3, step / 1e3))
    } else {
        of(value, step)
    }
}

/// Without zeros behind the point that say nothing, and without a sign before nothing.
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
