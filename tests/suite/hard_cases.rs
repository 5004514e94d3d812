//! Inputs that are numerically hard, each with the bound that must hold and, printed, what was measured.
//!
//! `cargo test --test suite hard_cases -- --nocapture` prints the table; `lightfold selftest --hard-cases` is the same.

use lightfold::depth::block::{Block, BlockMut};
use lightfold::hard_cases::{CaseReport, family_rows, number, run_all, table};
use lightfold::monitor::Silent;

#[test]
fn every_hard_case_keeps_its_bound() {
    let cases = table();
    let reports: Vec<CaseReport> = run_all(&cases, &Silent).unwrap().into_iter().map(|(report, _)| report).collect();
    assert_eq!(reports.len(), cases.len());
    for row in family_rows(&reports) {
        let worst = row.worst;
        let (family, measured) = (worst.family.name(), number(worst.measured));
        println!("{family:<13} {:<60} {:>4} {} {measured} {}", worst.pipeline, row.cases, worst.bound, worst.unit);
    }
    let broken: Vec<String> = reports.iter().filter(|case| !case.passed()).map(CaseReport::sentence).collect();
    assert!(broken.is_empty(), "{} of {} cases:\n{}", broken.len(), cases.len(), broken.join("\n"));
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
