//! Derives one pattern for many sequences: finds which parts of their names are faces and which are probes.

use std::collections::{BTreeMap, BTreeSet};

use crate::dataset::manifest::is_probe_name;
use codec::error::{Error, Result};
use codec::image::Face;

/// Name of the probe if there is only one.
const ONLY_PROBE: &str = "00";

/// Words for faces, in the order of [`Face::CUBE`]. Words of the first two sets are unambiguous; those of the last name cameras,
/// whose front looks along −Z.
const FACE_WORDS: [[&[&str]; 6]; 3] = [
    [&["px"], &["nx"], &["py"], &["ny"], &["pz"], &["nz"]],
    [&["posx", "xpos"], &["negx", "xneg"], &["posy", "ypos"], &["negy", "yneg"], &["posz", "zpos"], &["negz", "zneg"]],
    [&["right", "rt"], &["left", "lf"], &["top", "up"], &["bottom", "down", "dn"], &["back", "bk"], &["front", "fr"]],
];

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Named {
    /// The pattern, with `{probe}` and `{face}`.
    pub text: String,
    /// Index of the sequence of each probe and face; [`Face::View`] if the names contain no faces.
    pub members: BTreeMap<(String, Face), usize>,
    /// Words for the faces in the names.
    pub faces: BTreeMap<Face, String>,
    /// True if these words name cameras, such as front and back.
    pub are_cameras: bool,
    /// Indices of sequences whose names have another form.
    pub left_out: Vec<usize>,
}

impl Named {
    pub fn probes(&self) -> BTreeSet<String> {
        self.members.keys().map(|(probe, _)| probe.clone()).collect()
    }
}

/// Finds the common pattern of sequences. Each text is the pattern of one sequence, without `{probe}` and `{face}`.
pub fn name(texts: &[&str]) -> Result<Named> {
    let split: Vec<Vec<String>> = texts.iter().map(|text| tokens(text)).collect();
    let mut forms: BTreeMap<Vec<String>, Vec<usize>> = BTreeMap::new();
    for (at, tokens) in split.iter().enumerate() {
        forms.entry(form(tokens)).or_default().push(at);
    }
    let most =
        forms.values().max_by_key(|members| (members.len(), usize::MAX - members[0])).cloned().unwrap_or_default();
    let left_out = (0..texts.len()).filter(|at| !most.contains(at)).collect();
    let mut rows: Vec<Vec<String>> = most.iter().map(|at| split[*at].clone()).collect();
    let faces = take_faces(&mut rows);
    let probes = take_probes(&mut rows)?;
    let mut members = BTreeMap::new();
    for ((at, face), probe) in most.iter().zip(&faces).zip(probes) {
        if members.insert((probe, face.as_ref().map_or(Face::View, |(face, _)| *face)), *at).is_some() {
            return Err(Error::invalid(format!("two sequences have the same probe and face, as {}", texts[*at])));
        }
    }
    let faces: BTreeMap<Face, String> = faces.into_iter().flatten().collect();
    let are_cameras = faces.values().any(|word| face_of(word, &FACE_WORDS[2]).is_some());
    let text = rows.first().map(|row| row.concat()).unwrap_or_default();
    Ok(Named { text, members, faces, are_cameras, left_out })
}

/// Splits a text into runs of letters and digits, and single other characters.
fn tokens(text: &str) -> Vec<String> {
    let mut tokens: Vec<String> = Vec::new();
    let mut was_word = false;
    for c in text.chars() {
        let is_word = c.is_ascii_alphanumeric();
        match tokens.last_mut() {
            Some(last) if is_word && was_word => last.push(c),
            _ => tokens.push(c.into()),
        }
        was_word = is_word;
    }
    tokens
}

/// Returns the tokens with every word replaced by the same one, except the width of the frame number and the file extension.
fn form(tokens: &[String]) -> Vec<String> {
    let last = tokens.len().saturating_sub(1);
    let varies = |at: usize| {
        let is_word = tokens[at].starts_with(|c: char| c.is_ascii_alphanumeric());
        is_word && at < last && (at == 0 || tokens[at - 1] != "%")
    };
    (0..tokens.len()).map(|at| if varies(at) { "w".into() } else { tokens[at].clone() }).collect()
}

fn face_of(token: &str, words: &[&[&str]; 6]) -> Option<Face> {
    let lower = token.to_ascii_lowercase();
    words.iter().position(|names| names.contains(&lower.as_str())).map(|at| Face::CUBE[at])
}

/// Replaces words for faces by `{face}`; returns the face and the word of each row.
fn take_faces(rows: &mut [Vec<String>]) -> Vec<Option<(Face, String)>> {
    let width = rows.first().map_or(0, Vec::len);
    for (set, words) in FACE_WORDS.iter().enumerate() {
        for column in 0..width {
            let found: Option<Vec<Face>> = rows.iter().map(|row| face_of(&row[column], words)).collect();
            let Some(found) = found else { continue };
            let distinct: BTreeSet<&Face> = found.iter().collect();
            // Left and right without other faces are eyes.
            if set == 2 && (distinct.len() < 2 || distinct.iter().all(|face| [Face::Px, Face::Nx].contains(face))) {
                continue;
            }
            let words: Vec<String> = rows.iter().map(|row| row[column].clone()).collect();
            let same: Vec<usize> =
                (0..width).filter(|other| rows.iter().zip(&words).all(|(row, word)| row[*other] == *word)).collect();
            for row in rows.iter_mut() {
                same.iter().for_each(|at| row[*at] = "{face}".into());
            }
            return found.into_iter().zip(words).map(Some).collect();
        }
    }
    vec![None; rows.len()]
}

/// Replaces the parts that differ by `{probe}`; returns the probe of each row.
fn take_probes(rows: &mut [Vec<String>]) -> Result<Vec<String>> {
    let width = rows.first().map_or(0, Vec::len);
    let differs: Vec<usize> =
        (0..width).filter(|column| rows.iter().any(|row| row[*column] != rows[0][*column])).collect();
    let (Some(&first), Some(&last)) = (differs.first(), differs.last()) else {
        return Ok(vec![ONLY_PROBE.into(); rows.len()]);
    };
    let is_repeated = rows.iter().all(|row| differs.iter().all(|at| row[*at] == row[first]));
    let probes: Vec<String> = match is_repeated {
        true => rows.iter().map(|row| row[first].clone()).collect(),
        false => rows.iter().map(|row| row[first..=last].concat()).collect(),
    };
    if let Some(wrong) = probes.iter().find(|probe| !is_probe_name(probe)) {
        return Err(Error::invalid(format!(
            "their names differ in more than a probe and a face, such as \"{wrong}\": use one folder or file name for \
            each probe"
        )));
    }
    for row in rows.iter_mut() {
        if is_repeated {
            differs.iter().for_each(|at| row[*at] = "{probe}".into());
        } else {
            row.splice(first..=last, ["{probe}".to_owned()]);
        }
    }
    Ok(probes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pattern(texts: &[&str]) -> String {
        name(texts).unwrap().text
    }

    #[test]
    fn faces_and_probes_are_found_in_folders_and_files() {
        let mut texts = Vec::new();
        for (probe, face) in ["a1", "b2"].into_iter().flat_map(|probe| ["px", "nz"].map(|face| (probe, face))) {
            texts.push(format!("cam_{probe}/{face}/{probe}_{face}_color.%04d.exr"));
        }
        let texts: Vec<&str> = texts.iter().map(String::as_str).collect();
        let named = name(&texts).unwrap();
        assert_eq!(named.text, "cam_{probe}/{face}/{probe}_{face}_color.%04d.exr");
        assert_eq!(named.members[&("b2".to_owned(), Face::Nz)], 3);
        assert_eq!(named.faces[&Face::Px], "px");
        assert_eq!(named.left_out, Vec::<usize>::new());
    }

    #[test]
    fn words_for_faces() {
        let named = name(&["Left.%d.exr", "Right.%d.exr", "Top.%d.exr"]).unwrap();
        assert_eq!((named.text.as_str(), named.faces[&Face::Nx].as_str()), ("{face}.%d.exr", "Left"));
        // Left and right without other faces are two eyes.
        let named = name(&["left.%d.exr", "right.%d.exr"]).unwrap();
        assert_eq!((named.text.as_str(), named.faces.len(), named.probes().len()), ("{probe}.%d.exr", 0, 2));
        assert_eq!(name(&["px_%03d.exr"]).unwrap().faces.len(), 1);
        assert_eq!(pattern(&["color.%04d.exr"]), "color.%04d.exr");
        assert_eq!(pattern(&["r1_c1/z.%d.png", "r1_c2/z.%d.png", "r2_c1/z.%d.png"]), "{probe}/z.%d.png");
    }

    #[test]
    fn other_forms_are_left_out_and_what_cannot_be_named_is_refused() {
        let named = name(&["a/z.%d.exr", "b/z.%d.exr", "b/old-z.%d.exr"]).unwrap();
        assert_eq!((named.text.as_str(), named.left_out), ("{probe}/z.%d.exr", vec![2]));
        let said = name(&["a/x.%d.exr", "b/y.%d.exr"]).unwrap_err().to_string();
        assert!(said.contains("\"a/x\""), "{said}");
    }
}
