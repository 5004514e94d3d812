// Converts the value of a modelling function to a code (arithmetic.md 6, 7). Mirrors src/codec/depth/domain.rs. Needs `log2_table`.

const BACKGROUND_CODE: u32 = 65535u;
const FAR_CODE: u32 = 65534u;

fn code_of(unit: Unit, r: i32) -> u32 {
    switch unit.domain {
        case DOMAIN_LINEAR: {
            return linear_code(unit, r);
        }
        case DOMAIN_INVERSE: {
            return inverse_code(unit, r);
        }
        default: {
            return log_code(r);
        }
    }
}

fn log_code(r: i32) -> u32 {
    return u32(clamp((r + 8192) >> 14u, 0, 65535));
}

fn linear_code(unit: Unit, r: i32) -> u32 {
    let value = q8(r);
    if (value >= 16777216) {
        return BACKGROUND_CODE;
    }
    let log = integer_log2(u32(max(value, 1)));
    return scaled(log - min(log, unit.base), unit.scale);
}

fn inverse_code(unit: Unit, r: i32) -> u32 {
    let value = q8(r);
    if (value <= 0) {
        return BACKGROUND_CODE;
    }
    let log = integer_log2(u32(min(value, 16777215)));
    return scaled(unit.base - min(unit.base, log), unit.scale);
}

// Converts Q14 to Q8, rounding to nearest.
fn q8(r: i32) -> i32 {
    return (r + 32) >> 6u;
}

// Returns log2 in Q24.
fn integer_log2(value: u32) -> u32 {
    let exponent = firstLeadingBit(value);
    let fraction = ((value << (31u - exponent)) << 1u) >> 9u;
    let index = fraction >> 15u;
    let rest = fraction & 0x7fffu;
    let low = log2_table[index];
    let high = log2_table[index + 1u];
    return (exponent << 24u) + low + (((high - low) * rest + 0x4000u) >> 15u);
}

// Returns (log · scale + 2³¹) >> 32, at most FAR_CODE.
fn scaled(log: u32, scale: u32) -> u32 {
    let found = product(log, scale);
    // Adding 2³¹ carries into the high word if bit 31 of the low word is set.
    return min(found.y + (found.x >> 31u), FAR_CODE);
}
