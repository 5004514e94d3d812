// Selects the views that are marched: all active views, or a single one (the nearest, or the environment map of a proxy).

const ALL_VIEWS = 0xffffffffu;

// Index of the single view, or ALL_VIEWS.
var<private> alone: u32 = ALL_VIEWS;
// True for primary rays: a point's occupancy is decided by the texels around it rather than the one that contains it.
var<private> is_around: bool = false;
// True if marching also ends at a point that is empty in no view but occupied in none either.
var<private> until_unknown: bool = false;

fn view_count() -> u32 {
    return select(1u, scene.view_count, alone == ALL_VIEWS);
}

fn view_at(number: u32) -> u32 {
    return select(alone, number, alone == ALL_VIEWS);
}

fn remember_empty(view: u32) {
    empty_view = select(empty_view, view, alone == ALL_VIEWS);
}
