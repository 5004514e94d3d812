// The views that are marched: all active ones.

fn view_count() -> u32 {
    return scene.view_count;
}

// The view of a number below that count.
fn view_at(number: u32) -> u32 {
    return number;
}

// A view found a point empty.
fn remember_empty(view: u32) {
    empty_view = view;
}
