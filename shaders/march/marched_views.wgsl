// The views that are marched: all active ones, or one alone: the nearest, or the environment map of a proxy.

const ALL_VIEWS = 0xffffffffu;

// The single view, or ALL_VIEWS.
var<private> alone: u32 = ALL_VIEWS;
// Whether the texels around a point decide whether a view sees past it, in place of the one that contains it: of primary rays.
var<private> is_around: bool = false;
// Whether marching also ends where no view sees past a point, though none knows a surface there.
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
