// Which views are asked: all that take part, or one alone, such as that from the centre of a ball of glass. In place of
// asked_all.wgsl where mirrors and glass send rays on.

const ALL_VIEWS = 0xffffffffu;

// The view that is asked alone, or ALL_VIEWS.
var<private> alone: u32 = ALL_VIEWS;

fn asked_count() -> u32 {
    return select(1u, scene.view_count, alone == ALL_VIEWS);
}

fn asked_view(number: u32) -> u32 {
    return select(alone, number, alone == ALL_VIEWS);
}

fn remember_open(view: u32) {
    open_view = select(open_view, view, alone == ALL_VIEWS);
}
