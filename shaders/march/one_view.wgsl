// The views that are marched: all active ones, or the environment map of a proxy alone. In place of all_views.wgsl with
// secondary rays.

const ALL_VIEWS = 0xffffffffu;

// The single view, or ALL_VIEWS.
var<private> alone: u32 = ALL_VIEWS;

fn view_count() -> u32 {
    return select(1u, scene.view_count, alone == ALL_VIEWS);
}

fn view_at(number: u32) -> u32 {
    return select(alone, number, alone == ALL_VIEWS);
}

fn remember_empty(view: u32) {
    empty_view = select(empty_view, view, alone == ALL_VIEWS);
}
