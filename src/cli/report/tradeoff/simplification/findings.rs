//! Claims of the paper about its figures 9 to 11, 13 and 14, tested on this capture.

use crate::report::plot::number::short;
use crate::report::tradeoff::findings::{Finding, Judged, Test};
use crate::report::tradeoff::kind::{Measured, Point};
use crate::report::tradeoff::knob;
use crate::report::tradeoff::runs::{self, Run};
use crate::report::tradeoff::study::{Results, all_points};

/// Projected area, in spheres, from which the paper sees hardly any cracks (figure 10).
const WITHOUT_CRACKS: f64 = 3.0;
/// Projected area at which the paper's uniform grid is infeasible (figure 13).
const TOO_SMALL: f64 = 1.25;
/// Minimum fraction of texels that adaptive sizes save (figure 14).
const MIN_SAVING: f64 = 0.18;
/// Ratio of the paper's peak overdraw to its budget: 5.6 for a budget of 5 (table 1).
const EXCESS: f64 = 1.12;
/// Maximum duality gap of a converged search.
const CONVERGED: f64 = 0.01;

type SimplificationTest = Test<fn(&Results) -> Option<Judged>>;

const TESTS: [SimplificationTest; 9] = [
    Test {
        name: "triangles_close_cracks",
        sentence: "Scenes of few triangles have cracks, which go away as triangles are added (Seurat figure 9).",
        rule: "In most rows of points that differ in the triangles alone, the fewest triangles leave crack pixels, and the \
               most leave at most a tenth of them.",
        needs: "Needs two or more values of --triangles.",
        judge: |results| {
            let runs = runs::along(results, None, "triangles", 2);
            cracks_vanish(&runs, |_| true)
        },
    },
    Test {
        name: "area_closes_cracks",
        sentence: "Scenes of little area have cracks, of which few are left from 3 spheres on (Seurat figure 10).",
        rule: "In most rows of points that differ in the area alone, the least area leaves crack pixels, and 3 spheres or \
               more leave at most a tenth of them.",
        needs: "Needs two or more values of --area, below 3 and from 3 on.",
        judge: |results| {
            let runs = runs::along(results, None, "area", 2);
            cracks_vanish(&runs, |run| {
                let [first, last] = ends(run);
                first.0 < WITHOUT_CRACKS && last.0 >= WITHOUT_CRACKS
            })
        },
    },
    Test {
        name: "peak_budget_limits_views",
        sentence: "Without a budget of peak overdraw some views have much more of it (Seurat figure 11).",
        rule: "In most rows of points that differ in that budget alone, the largest has at least a tenth more overdraw in \
               the worst view of the capture than the least.",
        needs: "Needs two or more values of --peak-overdraw.",
        judge: peak_budget_limits_views,
    },
    Test {
        name: "peak_budget_kept_nearly",
        sentence: "The overdraw that is measured exceeds the budget of peak overdraw slightly, if at all (Seurat table 1).",
        rule: "At every point with a given budget of peak overdraw, the worst view of the capture has at most 1.12 times as \
               much, as the worst scene of the paper.",
        needs: "Needs a sweep of --peak-overdraw.",
        judge: peak_budget_kept_nearly,
    },
    Test {
        name: "area_improves_ssim",
        sentence: "SSIM falls as the area is reduced (Seurat figure 13).",
        rule: "In most rows of points that differ in the area alone, the least area has a lower SSIM than any other.",
        needs: "Needs two or more values of --area.",
        judge: area_improves_ssim,
    },
    Test {
        name: "quadtree_beats_grid",
        sentence: "Quadtrees have a higher SSIM than a uniform grid of the sixth level (Seurat figure 13).",
        rule: "Wherever both are feasible and differ in the tiling alone, the quadtree has the higher SSIM.",
        needs: "Needs --sweep tiling=quadtree,uniform.",
        judge: quadtree_beats_grid,
    },
    Test {
        name: "grid_needs_area",
        sentence: "At an area of 1.25 spheres or less the uniform grid is infeasible (Seurat figure 13).",
        rule: "No point of a uniform grid at an area of at most 1.25 is feasible.",
        needs: "Needs --sweep tiling with uniform in it and --sweep area with 1.25 or less.",
        judge: grid_needs_area,
    },
    Test {
        name: "adaptive_sizes_save_texels",
        sentence: "Adaptive texture sizes need 18% to 57% fewer texels than uniform ones for the same PSNR (Seurat figure 14).",
        rule: "At the PSNR of every atlas of uniform sizes that the adaptive ones reach, these need at least 18% fewer texels; \
               texels are interpolated between atlases.",
        needs: "Needs --sweep sizing=adaptive,uniform and two or more values of --atlas.",
        judge: adaptive_sizes_save_texels,
    },
    Test {
        name: "selection_converges",
        sentence: "The selection of tiles converges within few iterations (Seurat figure 13).",
        rule: "At every point the duality gap is at most 1%.",
        needs: "Needs a point.",
        judge: selection_converges,
    },
];

pub fn judge(results: &Results) -> Vec<Finding> {
    TESTS.iter().map(|test| test.finding((test.judge)(results))).collect()
}

/// Returns the first and last point of a run, which has at least one.
fn ends<'a>(run: &Run<'a>) -> [(f64, &'a Measured); 2] {
    [run.points[0], run.points[run.points.len() - 1]]
}

fn cracks_vanish(runs: &[Run<'_>], is_told: impl Fn(&Run<'_>) -> bool) -> Option<Judged> {
    let rows: Vec<[u64; 2]> = (runs.iter().filter(|run| is_told(run)))
        .map(|run| ends(run).map(|(_, point)| point.count("crack_pixels")))
        .collect();
    let total = |end: usize| rows.iter().map(|row| row[end]).sum::<u64>();
    Judged::majority(
        &rows,
        |[first, last]| *first > 0 && 10 * last <= *first,
        |kept| {
            format!(
                "{} crack pixels at the least value and {} at the largest, in {} rows of points. {kept} of them keep the rule.",
                total(0),
                total(1),
                rows.len()
            )
        },
    )
}

fn peak_budget_limits_views(results: &Results) -> Option<Judged> {
    let runs = runs::along(results, None, "peak-overdraw", 2);
    let peaks = runs.iter().filter_map(|run| {
        let [first, last] = ends(run).map(|(_, point)| point.number("peak_overdraw_measured"));
        Some([first?, last?])
    });
    let rows: Vec<[f64; 2]> = peaks.collect();
    let greatest = |end: usize| short(rows.iter().map(|row| row[end]).fold(0.0, f64::max));
    Judged::majority(
        &rows,
        |[first, last]| *last >= 1.1 * first,
        |kept| {
            format!(
                "The worst view has an overdraw of {} at the least budget and of {} at the largest. {kept} of {} rows of points \
                 keep the rule.",
                greatest(0),
                greatest(1),
                rows.len()
            )
        },
    )
}

fn peak_budget_kept_nearly(results: &Results) -> Option<Judged> {
    let excess = |of: &Measured| {
        Some(of.number("peak_overdraw_measured")? / of.point.value("peak-overdraw").and_then(knob::number)?)
    };
    let most = results.measured.iter().filter_map(excess).reduce(f64::max)?;
    Some(Judged::new(most <= EXCESS, format!("At most {} times the budget was measured.", short(most))))
}

fn area_improves_ssim(results: &Results) -> Option<Judged> {
    let runs = runs::along(results, None, "area", 2);
    let series = runs.iter().map(|run| run.points.iter().filter_map(|(_, point)| point.number("ssim")).collect());
    let rows: Vec<Vec<f64>> = series.filter(|row: &Vec<f64>| row.len() > 1).collect();
    let most_below = |row: &Vec<f64>| row[1..].iter().copied().fold(f64::INFINITY, f64::min) - row[0];
    Judged::majority(
        &rows,
        |row| most_below(row) > 0.0,
        |kept| {
            let first = rows.iter().map(|row| row[0]).sum::<f64>() / rows.len() as f64;
            let best = rows.iter().map(|row| row.iter().copied().fold(0.0, f64::max)).sum::<f64>() / rows.len() as f64;
            format!(
                "SSIM is {first:.4} at the least area and at best {best:.4}, in the mean of {} rows of points. {kept} of them keep \
                 the rule.",
                rows.len()
            )
        },
    )
}

fn quadtree_beats_grid(results: &Results) -> Option<Judged> {
    let of = |tiling: &str, point: &Point| {
        let settings = point.without("tiling").into_iter().chain([("tiling", tiling.to_owned())]).collect();
        results.of(&Point::new(results.sweep, None, settings))?.number("ssim")
    };
    let grids = results.measured.iter().filter(|of| of.point.value("tiling") == Some("uniform"));
    let pairs = grids.filter_map(|grid| Some([of("quadtree", &grid.point)?, grid.number("ssim")?]));
    let rows: Vec<[f64; 2]> = pairs.collect();
    let least = rows.iter().map(|[tree, grid]| tree - grid).reduce(f64::min)?;
    let rests_on = format!("The quadtree's SSIM is higher by at least {least:.4}, at {} pairs of points.", rows.len());
    let rests_on = if least < 0.0 { format!("The quadtree's SSIM is lower by up to {:.4}.", -least) } else { rests_on };
    Some(Judged::new(least > 0.0, rests_on))
}

fn grid_needs_area(results: &Results) -> Option<Judged> {
    let is_small = |point: &Point| {
        let area = point.value("area").and_then(knob::number);
        point.value("tiling") == Some("uniform") && area.is_some_and(|area| area <= TOO_SMALL)
    };
    let points: Vec<Point> = all_points(&results.studies).into_iter().filter(is_small).collect();
    let feasible = points.iter().filter(|point| results.of(point).is_some()).count();
    let rests_on = format!("{feasible} of {} such points are feasible.", points.len());
    (!points.is_empty()).then(|| Judged::new(feasible == 0, rests_on))
}

fn adaptive_sizes_save_texels(results: &Results) -> Option<Judged> {
    let runs = runs::along(results, None, "atlas", 1);
    let curve = |run: &Run<'_>| -> Vec<[f64; 2]> {
        let spots = run.points.iter().filter_map(|(_, of)| Some([of.number("psnr_db")?, of.number("atlas_texels")?]));
        spots.filter(|[psnr_db, _]| psnr_db.is_finite()).collect()
    };
    let with =
        |run: &Run<'_>, sizing: &str| run.others.iter().any(|(name, value)| *name == "sizing" && value == sizing);
    let others = |run: &Run<'_>| run.others.iter().filter(|(name, _)| *name != "sizing").cloned().collect::<Vec<_>>();
    let mut ratios = Vec::new();
    for uniform in runs.iter().filter(|run| with(run, "uniform")) {
        let adaptive = runs.iter().filter(|run| with(run, "adaptive") && others(run) == others(uniform));
        let adaptive: Vec<[f64; 2]> = adaptive.flat_map(curve).collect();
        // An atlas that holds all textures at full resolution has the same texels with both sizings.
        let is_full = |spot: &[f64; 2]| adaptive.contains(spot);
        for spot in curve(uniform).into_iter().filter(|spot| !is_full(spot)) {
            ratios.extend(texels_at(&adaptive, spot[0]).map(|texels| texels / spot[1]));
        }
    }
    let most = ratios.iter().copied().reduce(f64::max)?;
    let least = ratios.iter().copied().fold(most, f64::min);
    let rests_on = format!(
        "Adaptive sizes need {} to {} times the texels, at the PSNR of {} atlases of uniform sizes.",
        short(least),
        short(most),
        ratios.len()
    );
    Some(Judged::new(most <= 1.0 - MIN_SAVING, rests_on))
}

/// Returns the texels at which a curve of (PSNR, texels) reaches a PSNR, by interpolating the logarithm of the texels.
/// `None` outside the curve.
fn texels_at(curve: &[[f64; 2]], psnr_db: f64) -> Option<f64> {
    curve.windows(2).find_map(|pair| {
        let [[low, few], [high, many]] = [pair[0], pair[1]];
        let part = (psnr_db - low) / (high - low);
        (0.0..=1.0).contains(&part).then(|| (few.ln() + part * (many / few).ln()).exp())
    })
}

fn selection_converges(results: &Results) -> Option<Judged> {
    let most = results.measured.iter().filter_map(|of| of.number("gap")).reduce(f64::max)?;
    Some(Judged::new(most <= CONVERGED, format!("The largest gap is {} %.", short(100.0 * most))))
}

#[cfg(test)]
mod tests;
