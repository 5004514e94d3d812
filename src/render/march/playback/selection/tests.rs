use super::*;

fn candidates(positions: &[[f64; 3]]) -> Vec<Candidate> {
    let at = |(view, position): (usize, &[f64; 3])| Candidate { view, position: DVec3::from_array(*position) };
    positions.iter().enumerate().map(at).collect()
}

fn select(settings: SelectionSettings, positions: &[[f64; 3]], eye: [f64; 3]) -> Selection {
    ViewSelector::new(settings).select(&candidates(positions), DVec3::from_array(eye))
}

const LINE: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 0.0]];

#[test]
fn the_nearest_come_first_and_ties_by_their_number() {
    let settings = SelectionSettings::default();
    let selection = select(settings, &LINE, [1.9, 0.0, 0.0]);
    assert_eq!(selection.views(), [2, 1, 3, 0]);
    assert!((selection.active[0].distance_m - 0.1).abs() < 1e-12);
    assert!(selection.culled.is_empty());
    assert_eq!(select(settings, &LINE, [1.5, 0.0, 0.0]).views(), [1, 2, 0, 3]);
    // For views in one place, the index decides.
    assert_eq!(select(settings, &[[5.0; 3]; 3], [5.0; 3]).views(), [0, 1, 2]);
    assert!(select(settings, &[], [0.0; 3]).active.is_empty());
}

#[test]
fn by_angle_those_come_first_that_look_at_the_reference_point_from_where_the_eye_is() {
    let ring = [[2.0, 0.0, 0.0], [0.0, 0.0, 2.0], [-2.0, 0.0, 0.0], [0.0, 0.0, -2.0], [0.0, 0.0, 0.0]];
    let settings =
        SelectionSettings { priority: ViewPriority::Angle, pivot: Some(DVec3::ZERO), ..SelectionSettings::default() };
    let selection = select(settings, &ring, [9.0, 0.0, 1.0]);
    // The view at the reference point counts as 90 degrees, which is less than the angles of the views on the far side.
    assert_eq!(selection.views(), [0, 1, 4, 3, 2]);
    assert!((selection.active[0].angle_deg - (1f64 / 9.0).atan().to_degrees()).abs() < 1e-9);
    assert_eq!(selection.active[2].angle_deg, 90.0);
    // If the eye is at the reference point, distance decides.
    let far = [[3.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 2.0]];
    assert_eq!(select(settings, &far, [0.0; 3]).views(), [1, 2, 0]);
    // The default reference point is the mean position of the views.
    let free = SelectionSettings { pivot: None, ..settings };
    let moved = ring.map(|[x, y, z]| [x + 7.0, y, z - 3.0]);
    assert_eq!(select(free, &moved, [16.0, 0.0, -2.0]).views(), [0, 1, 4, 3, 2]);
}

#[test]
fn views_that_the_eye_sees_close_together_are_redundant_to_the_first() {
    let settings = |cull_angle_deg| SelectionSettings { cull_angle_deg: Some(cull_angle_deg), ..Default::default() };
    // Angles at the eye: 0, 0, 5.7, 90 and 180 degrees.
    let views = [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [1.0, 0.1, 0.0], [0.0, 0.0, 1.5], [-3.0, 0.0, 0.0]];
    let selection = select(settings(5.0), &views, [0.0; 3]);
    assert_eq!(selection.views(), [0, 2, 3, 4]);
    assert_eq!(selection.culled, [(1, Why::Angle(0))]);
    let selection = select(settings(10.0), &views, [0.0; 3]);
    assert_eq!((selection.views(), selection.culled.len()), (vec![0, 3, 4], 2));
    // Only other views at the eye are redundant to a view at the eye.
    let selection = select(settings(170.0), &[[0.0; 3], [0.0; 3], [1.0, 0.0, 0.0]], [0.0; 3]);
    assert_eq!(selection.views(), [0, 2]);
    assert_eq!(selection.culled, [(1, Why::Angle(0))]);
    // A threshold of 0 makes no view redundant, not even one at the same position.
    assert_eq!(select(settings(0.0), &[[1.0; 3]; 2], [0.0; 3]).views(), [0, 1]);
}

#[test]
fn there_are_no_more_than_asked_for_and_those_are_the_first() {
    let settings = SelectionSettings { most: Some(2), cull_angle_deg: Some(1.0), ..Default::default() };
    let views = [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 4.0]];
    let selection = select(settings, &views, [0.0; 3]);
    assert_eq!(selection.views(), [0, 2]);
    assert_eq!(selection.culled, [(1, Why::Angle(0)), (3, Why::Limit)]);
    assert_eq!(select(SelectionSettings { most: Some(0), ..settings }, &views, [0.0; 3]).views(), [0]);
}

#[test]
fn a_view_keeps_its_slot_for_as_long_as_it_stays() {
    let mut selector = ViewSelector::new(SelectionSettings { most: Some(2), ..Default::default() });
    let all = candidates(&LINE);
    let mut slots = |x: f64| -> Vec<(usize, usize)> {
        let selection = selector.select(&all, DVec3::new(x, 0.0, 0.0));
        selection.active.iter().map(|active| (active.view, active.slot)).collect()
    };
    assert_eq!(slots(0.4), [(0, 0), (1, 1)]);
    // The order changes, but the slots stay.
    assert_eq!(slots(0.6), [(1, 1), (0, 0)]);
    // A new view takes the slot of the view that leaves.
    assert_eq!(slots(1.4), [(1, 1), (2, 0)]);
    assert_eq!(slots(2.4), [(2, 0), (3, 1)]);
    assert_eq!(slots(0.4), [(0, 0), (1, 1)]);
    // No slot is assigned twice, and slots stay below the maximum number of views.
    for step in 0..400u32 {
        let given = slots(f64::from(step * 7919 % 400) / 100.0 - 0.5);
        let mut numbers: Vec<usize> = given.iter().map(|(_, slot)| *slot).collect();
        numbers.sort_unstable();
        assert_eq!(numbers, [0, 1], "{given:?}");
    }
}

#[test]
fn slow_frames_leave_out_views_of_low_priority() {
    let mut selector = ViewSelector::new(SelectionSettings { target_ms: Some(10.0), ..Default::default() });
    let all = candidates(&LINE);
    assert_eq!(selector.select(&all, DVec3::ZERO).views(), [0, 1, 2, 3]);
    for _ in 0..3 {
        selector.measured(20.0, 4);
    }
    let selection = selector.select(&all, DVec3::ZERO);
    assert_eq!(selection.views(), [0, 1]);
    assert_eq!(selection.culled, [(2, Why::Performance), (3, Why::Performance)]);
    // Slots of views that do not have the frame become free.
    let selection = selector.select(&all[2..], DVec3::ZERO);
    assert_eq!(selection.active.iter().map(|active| (active.view, active.slot)).collect::<Vec<_>>(), [(2, 0), (3, 1)]);
}
