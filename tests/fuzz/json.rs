//! Mutations of JSON: missing, duplicate and renamed keys, extreme numbers, unusual strings, exchanged values.

use serde_json::{Map, Value};

use crate::mutate::{self, pick};
use crate::samples::Random;

/// Prefix of the name of a duplicate key; it is removed from the text.
const TWIN: &str = "\u{1}twin of ";

const NUMBERS: [&str; 18] = [
    "0",
    "-0.0",
    "1",
    "-1",
    "0.5",
    "1e-320",
    "1e308",
    "1e400",
    "-1e400",
    "65535",
    "65536",
    "65537",
    "2147483648",
    "4294967295",
    "4294967296",
    "18446744073709551615",
    "18446744073709551616",
    "0.1e-7",
];

const STRINGS: [&str; 22] = [
    "",
    " ",
    ".",
    "..",
    "/",
    "/etc/%04d",
    "../../x.%04d",
    "a\nb",
    "a\u{1b}[2Jb",
    "\u{0}",
    "%",
    "%%",
    "%04d",
    "%99d",
    "%04d%04d",
    "####",
    "{probe}{face}%04d",
    "{probe}/{face}/####.exr",
    "inf",
    "nan",
    "\u{202e}\u{feff}é",
    "x.\u{7f}.%d",
];

/// Returns the text of a mutated value.
pub fn mutate(value: &Value, random: &mut Random) -> Vec<u8> {
    let mut value = value.clone();
    for _ in 0..=random.below(3) {
        let paths = paths(&value);
        let path = pick(&paths, random).clone();
        let other = at(&mut value, &paths[mutate::place(paths.len(), random)]).map(|other| other.clone());
        if let Some(target) = at(&mut value, &path) {
            change(target, other.unwrap_or(Value::Null), random);
        }
    }
    let mut text = value.to_string().replace("\\u0001twin of ", "");
    if random.below(4) == 0 {
        // Numbers that `Value` cannot represent are inserted as text.
        let digits: Vec<usize> = text.match_indices(|c: char| c.is_ascii_digit()).map(|(at, _)| at).collect();
        if !digits.is_empty() {
            let start = *pick(&digits, random);
            let end = text[start..].find(|c: char| !c.is_ascii_digit() && c != '.').map_or(text.len(), |n| start + n);
            text.replace_range(start..end, NUMBERS[mutate::place(NUMBERS.len(), random)]);
        }
    }
    if random.below(64) == 0 {
        let depth = 1 + random.below(3000) as usize;
        text = text.replacen(':', &format!(":{}", "[".repeat(depth)), 1);
    }
    let mut text = text.into_bytes();
    if random.below(8) == 0 {
        mutate::bytes(&mut text, b"{}[]\",:\\u0000e-+.null", random);
    }
    text
}

fn paths(value: &Value) -> Vec<Vec<String>> {
    let mut all = vec![vec![]];
    let children: Vec<(String, &Value)> = match value {
        Value::Object(map) => map.iter().map(|(key, value)| (key.clone(), value)).collect(),
        Value::Array(list) => list.iter().enumerate().map(|(at, value)| (at.to_string(), value)).collect(),
        _ => vec![],
    };
    for (key, child) in children {
        all.extend(paths(child).into_iter().map(|mut path| {
            path.insert(0, key.clone());
            path
        }));
    }
    all
}

fn at<'a>(value: &'a mut Value, path: &[String]) -> Option<&'a mut Value> {
    path.iter().try_fold(value, |value, key| match value {
        Value::Object(map) => map.get_mut(key),
        Value::Array(list) => list.get_mut(key.parse::<usize>().ok()?),
        _ => None,
    })
}

fn change(target: &mut Value, other: Value, random: &mut Random) {
    match random.below(12) {
        0 => *target = other,
        1 => *target = scalar(random),
        2 => *target = Value::Array(vec![target.clone(); random.below(9) as usize]),
        3 => *target = Value::Object(Map::from_iter([(pick(&STRINGS, random).to_string(), target.clone())])),
        _ => match target {
            Value::Object(map) if !map.is_empty() => {
                let keys: Vec<String> = map.keys().cloned().collect();
                let key = pick(&keys, random).clone();
                match random.below(4) {
                    0 => drop(map.remove(&key)),
                    1 => drop(map.insert(format!("{TWIN}{key}"), other)),
                    2 => {
                        let value = map.remove(&key).unwrap_or(Value::Null);
                        map.insert(pick(&STRINGS, random).to_string(), value);
                    }
                    _ => drop(map.insert(key, other)),
                }
            }
            Value::Array(list) if !list.is_empty() => {
                let place = mutate::place(list.len(), random);
                match random.below(3) {
                    0 => drop(list.remove(place)),
                    1 => list.insert(place, other),
                    _ => list.extend(list.clone()),
                }
            }
            Value::String(text) => match random.below(3) {
                0 => *text = pick(&STRINGS, random).to_string(),
                1 => text.push_str(STRINGS[mutate::place(STRINGS.len(), random)]),
                _ => *text = text.repeat(random.below(40) as usize),
            },
            _ => *target = scalar(random),
        },
    }
}

fn scalar(random: &mut Random) -> Value {
    match random.below(5) {
        0 => Value::Null,
        1 => Value::Bool(random.below(2) == 0),
        2 => Value::String(pick(&STRINGS, random).to_string()),
        _ => serde_json::from_str(NUMBERS[mutate::place(NUMBERS.len(), random)]).unwrap_or(Value::Null),
    }
}
