//! Text form of table sets, as in formats/color-tables.txt and formats/depth-tables.txt (entropy.md 4).

use std::fmt::Write;

use crate::entropy::text_reader::{Fault, TextReader};
use crate::entropy::{Model, TableSet};
use crate::error::{Error, Result};

pub fn read<M: Model>(text: &[u8]) -> Result<Vec<TableSet<M>>> {
    let mut reader = TextReader::new(text);
    for (context, family) in M::FAMILIES.iter().flat_map(|family| (0..family.contexts).map(move |at| (at, family))) {
        let cluster = reader.cluster(*family);
        check(&reader)?;
        if usize::from(cluster) != M::cluster_of(family.first_context + context) {
            let problem = format!("the distribution that {} gives this context was expected", M::FILE);
            return Err(at_line(reader.line(), &problem));
        }
    }
    let mut sets = Vec::new();
    while sets.is_empty() || !reader.is_at_end() {
        let distributions: Vec<_> = M::ALPHABETS.iter().map(|&alphabet| reader.distribution(alphabet.into())).collect();
        check(&reader)?;
        sets.push(TableSet::new(&distributions));
    }
    Ok(sets)
}

fn at_line(line: usize, message: &str) -> Error {
    Error::invalid(format!("line {line}: {message}"))
}

fn check(reader: &TextReader<'_>) -> Result<()> {
    let Some((fault, line)) = reader.fault() else { return Ok(()) };
    Err(match fault {
        Fault::Character => at_line(line, "a decimal number was expected, or a comment behind #"),
        Fault::End => at_line(line, "the text ends where a number was expected"),
        Fault::TooLarge { most } => at_line(line, &format!("a number of at most {most} was expected")),
        Fault::NoFrequency => at_line(line, "a frequency of at least 1 was expected for each symbol"),
        Fault::Sum(sum) => {
            at_line(line, &format!("the frequencies of a distribution sum to {sum}, 4096 were expected"))
        }
    })
}

/// Writes table sets as [`read`] reads them.
pub fn write<M: Model>(sets: &[TableSet<M>]) -> String {
    let mut text = format!(
        "# {}: decimal numbers.\n# Clusters of contexts, counted from the first of their family; a line for each family.\n",
        M::TITLE
    );
    let line = |text: &mut String, numbers: &mut dyn Iterator<Item = u32>| {
        let words: Vec<String> = numbers.map(|number| number.to_string()).collect();
        text.push_str(&words.join(" "));
        text.push('\n');
    };
    for family in M::FAMILIES {
        let contexts = family.first_context..family.first_context + family.contexts;
        line(&mut text, &mut contexts.map(|context| (M::cluster_of(context) - family.first_cluster) as u32));
    }
    for (number, set) in sets.iter().enumerate() {
        // Writing to a string does not fail.
        let _ = writeln!(text, "# Set {number}: the frequencies of each cluster, which sum to 4096.");
        for family in M::FAMILIES {
            for distribution in &set.distributions()[family.first_cluster..][..family.clusters] {
                line(&mut text, &mut (0..family.alphabet).map(|symbol| distribution.frequency(symbol)));
            }
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::transform::contexts::Transform;
    use crate::depth::predictive::contexts::Predictive;
    use crate::entropy::Tables;

    const COLOR: &str = include_str!(concat!(env!("LIGHTFOLD_FORMATS"), "/color-tables.txt"));
    const DEPTH: &str = include_str!(concat!(env!("LIGHTFOLD_FORMATS"), "/depth-tables.txt"));

    #[test]
    fn the_built_in_sets_come_back_as_the_file_of_the_format() {
        check::<Transform>(COLOR);
        check::<Predictive>(DEPTH);
    }

    fn check<M: Model>(built_in: &str) {
        let sets = read::<M>(built_in.as_bytes()).unwrap();
        assert_eq!(sets, Tables::default().sets());
        assert_eq!(write(&sets), built_in);
        let own = write(&sets[2..3]);
        assert_eq!(read(own.as_bytes()).unwrap(), sets[2..3]);
        let without_comments = own.lines().filter(|line| !line.starts_with('#')).collect::<Vec<_>>().join("  # x\r\n");
        assert_eq!(read(without_comments.as_bytes()).unwrap(), sets[2..3]);
    }

    #[test]
    fn what_is_wrong_is_said_with_its_line() {
        let lines: Vec<&str> = COLOR.lines().collect();
        let says = |line: usize, new: &str| {
            let mut changed = lines.clone();
            changed[line - 1] = new;
            read::<Transform>(changed.join("\n").as_bytes()).unwrap_err().to_string()
        };
        assert_eq!(says(17, "1882 x 678 407"), "line 17: a decimal number was expected, or a comment behind #");
        assert_eq!(says(17, "1882 -1 678 407"), "line 17: a decimal number was expected, or a comment behind #");
        assert_eq!(
            says(17, "1882 1129 678 408"),
            "line 17: the frequencies of a distribution sum to 4097, 4096 were expected"
        );
        assert_eq!(says(17, "4096 0 0 0"), "line 17: a frequency of at least 1 was expected for each symbol");
        assert_eq!(says(17, "99999999999 1 1 1"), "line 17: a number of at most 4096 was expected");
        assert_eq!(says(3, "8"), "line 3: a number of at most 7 was expected");
        assert!(says(3, "1").starts_with("line 3: the distribution that formats/color-tables.txt gives"));
        let cut = lines[..15].join("\n");
        assert_eq!(
            read::<Transform>(cut.as_bytes()).unwrap_err().to_string(),
            "line 15: the text ends where a number was expected"
        );
        for text in [lines[..300].join("\n").as_bytes(), b"", &[0xff], DEPTH.as_bytes()] {
            assert!(read::<Transform>(text).is_err());
        }
    }
}
