// Which views are asked: all that take part.

fn asked_count() -> u32 {
    return scene.view_count;
}

// The view of a number below that count.
fn asked_view(number: u32) -> u32 {
    return number;
}

// A view has said that a point is open.
fn remember_open(view: u32) {
    open_view = view;
}
