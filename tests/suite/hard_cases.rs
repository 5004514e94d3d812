//! Numerically hard inputs. Each case has a bound that must hold; the measured figures are printed.
//!
//! `cargo test --test suite hard_cases -- --nocapture` prints the table; `lightfold selftest --hard-cases` runs the same cases.

use std::fs;
use std::path::Path;

use codec::depth::block::{Block, BlockMut};
use codec::monitor::Silent;
use verify::{CaseReport, FamilyRow, family_rows, notes, number, run_all, table};

/// Pipelines whose blocks come from a library that computes in floating point, with results that depend on the instruction set.
const BY_PROCESSOR: [&str; 4] = ["CCB1", "CCB7", "CCB6", "MAB1"];

#[test]
fn every_hard_case_keeps_its_bound_and_the_page_of_them_is_fresh() {
    let cases = table();
    let reports: Vec<CaseReport> = run_all(&cases, &Silent).unwrap().into_iter().map(|(report, _)| report).collect();
    assert_eq!(reports.len(), cases.len());
    let rows = family_rows(&reports);
    for row in &rows {
        println!("{:?}", cells(row));
    }
    notes(&reports).iter().for_each(|note| println!("{note}"));
    let broken: Vec<String> = reports.iter().filter(|case| !case.passed()).map(CaseReport::sentence).collect();
    assert!(broken.is_empty(), "{} of {} cases:\n{}", broken.len(), cases.len(), broken.join("\n"));
    check_page(&rows);
}

/// Returns the cells of a row, as on the page.
fn cells(row: &FamilyRow<'_>) -> [String; 7] {
    let worst = row.worst;
    [
        worst.family.name().into(),
        worst.pipeline.clone(),
        row.cases.to_string(),
        worst.bound.to_string(),
        number(worst.measured),
        worst.unit.into(),
        worst.name.clone(),
    ]
}

/// Relative tolerance of figures, for differences between mathematical libraries.
const LIBRARY: f64 = 0.01;

/// True if a cell of the page matches a new one: text and whole numbers exactly, other figures within [`LIBRARY`].
fn agree(kept: &str, made: &str) -> bool {
    let parts = |cell: &str| {
        let (sign, figure) = cell.rsplit_once(' ').unwrap_or(("", cell));
        figure
            .parse::<f64>()
            .ok()
            .filter(|figure| figure.is_finite() && figure.fract() != 0.0)
            .map(|figure| (sign.to_owned(), figure))
    };
    match (parts(kept), parts(made)) {
        (Some((one, a)), Some((other, b))) => one == other && (a - b).abs() <= LIBRARY * a.abs().max(b.abs()),
        _ => kept == made,
    }
}

/// Compares tests/hard_cases.md with rows; figures only if they are alike on all machines.
fn check_page(rows: &[FamilyRow<'_>]) {
    let page = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/hard_cases.md")).unwrap();
    let kept = page.lines().filter(|line| line.starts_with("| ") && !line.starts_with("| ---")).skip(1);
    let kept: Vec<Vec<String>> =
        kept.map(|line| line.trim_matches('|').split('|').map(|cell| cell.trim().to_owned()).collect()).collect();
    let again = "the page is stale: scripts/table hard-cases --write";
    assert_eq!(kept.len(), rows.len(), "{again}");
    for (kept, row) in kept.iter().zip(rows) {
        let made = cells(row);
        let by_processor = BY_PROCESSOR.iter().any(|codec| made[1].starts_with(codec));
        let measured = row.worst.measured;
        let small = measured.abs() < 1e-6 && measured != 0.0;
        // The last bits of a figure may decide which case is the worst, so its name is compared only for whole numbers.
        let compared = match () {
            () if by_processor || small => vec![0, 1, 2, 5],
            () if measured.fract() != 0.0 => vec![0, 1, 2, 3, 4, 5],
            () => vec![0, 1, 2, 3, 4, 5, 6],
        };
        for at in compared {
            assert!(agree(&kept[at], &made[at]), "{again}\n  {kept:?}\n  {made:?}");
        }
    }
}

#[test]
fn a_page_is_stale_by_more_than_a_library() {
    assert!(agree("50.09", "50.10") && agree("<= 2.109e-4", "<= 2.110e-4") && agree("infinite, NaN", "infinite, NaN"));
    assert!(!agree("50.09", "51.10") && !agree("<= 2.109e-4", "<= 2.209e-4") && !agree("of 255", "codes"));
    assert!(
        !agree("10", "11") && !agree(">= 50", "<= 50") && !agree(">= 0.5", "<= 0.5") && !agree("1000", "1001"),
        "whole numbers are exact"
    );
}

#[test]
fn a_block_beyond_the_picture_touches_nothing_outside() {
    let picture = vec![9u16; 5 * 7];
    let block = Block::of(&picture, 5, 2, [0, 0]);
    assert_eq!(block.pixel_count(), 35);
    let mut target = vec![1u16; 5 * 7];
    BlockMut::of(&mut target, 5, 1, [0, 0]).rows_mut().for_each(|row| row.fill(2));
    assert_eq!(target, vec![2; 35]);
    BlockMut::of(&mut target, 5, 1, [4, 4]).rows_mut().for_each(|row| row.fill(3));
    assert_eq!(target.iter().filter(|&&code| code == 3).count(), 3);
}
