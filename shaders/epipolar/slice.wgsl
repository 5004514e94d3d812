// Finds the line that each pixel shows (Epipolar 3.3.2), as src/epipolar/slice.rs does. A workgroup processes some columns of
// one scanline of one view: it finds the minimum depth of each column, then the first run with that depth. Needs `moved`.

@group(0) @binding(0) var<storage, read> block: SliceBlock;
// First line of each scanline, then the end of the last scanline.
@group(0) @binding(1) var<storage, read> starts: array<u32>;
// First run of each scanline, then the end of the last scanline.
@group(0) @binding(2) var<storage, read> run_starts: array<u32>;
@group(0) @binding(3) var<storage, read> runs: array<SliceRun>;
// Planar distance of each line, as bits of a float.
@group(0) @binding(4) var<storage, read> depths: array<u32>;
@group(0) @binding(5) var<storage, read> places: array<SlicePlace>;
@group(0) @binding(6) var<storage, read_write> winners: array<vec2u>;
// Number of pixels covered by runs and the spans between them, per scanline of a view; added to the previous value.
@group(0) @binding(7) var<storage, read_write> fragments: array<atomic<u32>>;

// High and low half of the minimum key, per column.
var<workgroup> nearest: array<atomic<u32>, SLICE_COLUMNS>;
var<workgroup> words: array<atomic<u32>, SLICE_COLUMNS>;
var<workgroup> fragment_count: atomic<u32>;

fn place_of(run: SliceRun, view: u32) -> SlicePlace {
    return places[(run.flags & 0xffffu) * block.views + view];
}

// Returns the column of the run's first line in a view.
fn column_of(run: SliceRun, place: SlicePlace) -> i32 {
    return run.column + moved(run.disparity, place.place);
}

fn length_of(run: SliceRun) -> i32 {
    return i32(run.flags >> RUN_LENGTH_BITS);
}

fn joins_next(run: SliceRun) -> bool {
    return (run.flags & RUN_JOINS) != 0u;
}

fn is_own(run: SliceRun, place: SlicePlace) -> bool {
    return (run.flags & RUN_FIRST) != 0u && place.place == 0;
}

// Pixels covered by a run or a span: a range of columns, relative to the first column of the workgroup.
struct Cover {
    begin: u32,
    end: u32,
}

fn cover(begin: i32, end: i32, tile: vec2i) -> Cover {
    let first = clamp(begin, tile.x, tile.y);
    let last = clamp(end, first, tile.y);
    return Cover(u32(first - tile.x), u32(last - tile.x));
}

// Returns the pixels covered by the lines of a run.
fn cover_of_run(run: SliceRun, place: SlicePlace, tile: vec2i) -> Cover {
    let column = column_of(run, place) >> COLUMN_BITS;
    return cover(column, column + length_of(run), tile);
}

// Returns the index of the line at the workgroup's first column, extrapolated if the run does not reach that column.
fn line_at_tile(start: u32, run: SliceRun, place: SlicePlace, tile: vec2i) -> i32 {
    return i32(start + run.first) + tile.x - (column_of(run, place) >> COLUMN_BITS);
}

fn depth_of_line(line: i32, run: SliceRun, place: SlicePlace) -> u32 {
    // In its own view, a line of the first layer always wins, even if another line lies in front of it between pixel centres.
    return select(depths[line] + place.bias, 0u, is_own(run, place));
}

// Returns the pixels covered by the span between a run and the next one, which it joins.
fn cover_of_span(at: u32, run: SliceRun, place: SlicePlace, tile: vec2i) -> Cover {
    let columns = vec2i(column_of(run, place), column_of(runs[at + 1u], place)) >> vec2u(COLUMN_BITS);
    return cover(columns.x + length_of(run), columns.y, tile);
}

fn depth_of_span(start: u32, run: SliceRun, place: SlicePlace) -> u32 {
    let next = start + run.first + u32(length_of(run));
    return max(depths[next - 1u], depths[next]) + place.bias;
}

fn put_word(column: u32, depth: u32, word: u32) {
    if (atomicLoad(&nearest[column]) == depth) {
        atomicMin(&words[column], word);
    }
}

// Returns the two words of a winner from the winning run and a bit that is set if the span after the run won: the line, and the
// neighbouring line with its weight.
fn winner(first_run: u32, word: u32, column: i32, view: u32) -> vec2u {
    let at = first_run + (word >> 1u);
    let run = runs[at];
    let place = place_of(run, view);
    let own = select(0u, WINNER_OWN, is_own(run, place));
    let run_column = column_of(run, place);
    // The winning line of the run, and its column. In a span this is the last line of the run.
    let last = length_of(run) - 1;
    let of_run = select(column - (run_column >> COLUMN_BITS), last, (word & 1u) != 0u);
    let line = run.first + u32(of_run);
    let line_column = run_column + (of_run << COLUMN_BITS);
    let right_of_line = (column << COLUMN_BITS) + (1 << (COLUMN_BITS - 1u)) - line_column;
    // A line left of the pixel centre is blended with the next line, a line right of it with the previous one.
    var side = 0u;
    var parted = 0;
    if (right_of_line > 0) {
        if (of_run < last) {
            side = WINNER_AFTER;
            parted = 1 << COLUMN_BITS;
        } else if (joins_next(run)) {
            side = WINNER_AFTER;
            parted = column_of(runs[at + 1u], place) - line_column;
        }
    } else if (right_of_line < 0) {
        if (of_run > 0) {
            side = WINNER_BEFORE;
            parted = -(1 << COLUMN_BITS);
        } else if (at > first_run) {
            let before = runs[max(at, 1u) - 1u];
            if (joins_next(before)) {
                side = WINNER_BEFORE;
                parted = column_of(before, place) + ((length_of(before) - 1) << COLUMN_BITS) - line_column;
            }
        }
    }
    // Lines that have converged or swapped order are not blended.
    if (side == 0u || sign(parted) != sign(right_of_line)) {
        return vec2u(line, own);
    }
    let shift = select(0u, COLUMN_BITS, abs(parted) >= (1 << 22u));
    let columns = abs(vec2i(right_of_line, parted)) >> vec2u(shift);
    let weight = min((255 * columns.x + columns.y / 2) / columns.y, 255);
    return vec2u(line, u32(weight) | side | own);
}

@compute @workgroup_size(SLICE_WORKGROUP)
fn find_winners(
    @builtin(local_invocation_index) local: u32,
    @builtin(workgroup_id) id: vec3u,
    @builtin(num_workgroups) groups: vec3u,
) {
    let group = id.x + id.y * groups.x;
    let tiles = (block.width + SLICE_COLUMNS - 1u) / SLICE_COLUMNS;
    let scanline = group / tiles;
    if (scanline >= block.rows * block.views) {
        return;
    }
    let view = scanline % block.views;
    let row = scanline / block.views;
    let left = (group % tiles) * SLICE_COLUMNS;
    let tile = vec2i(i32(left), i32(min(left + SLICE_COLUMNS, block.width)));
    let start = starts[row];
    let first_run = run_starts[row];
    let end = run_starts[row + 1u];
    for (var column = local; column < SLICE_COLUMNS; column += SLICE_WORKGROUP) {
        atomicStore(&nearest[column], NONE);
        atomicStore(&words[column], NONE);
    }
    workgroupBarrier();
    var count = 0u;
    for (var at = first_run + local; at < end; at += SLICE_WORKGROUP) {
        let run = runs[at];
        let place = place_of(run, view);
        let of_run = cover_of_run(run, place, tile);
        let line = line_at_tile(start, run, place, tile);
        for (var column = of_run.begin; column < of_run.end; column++) {
            atomicMin(&nearest[column], depth_of_line(line + i32(column), run, place));
        }
        count += of_run.end - of_run.begin;
        if (joins_next(run)) {
            let of_span = cover_of_span(at, run, place, tile);
            let depth = depth_of_span(start, run, place);
            for (var column = of_span.begin; column < of_span.end; column++) {
                atomicMin(&nearest[column], depth);
            }
            count += of_span.end - of_span.begin;
        }
    }
    atomicAdd(&fragment_count, count);
    workgroupBarrier();
    for (var at = first_run + local; at < end; at += SLICE_WORKGROUP) {
        let run = runs[at];
        let place = place_of(run, view);
        let word = (at - first_run) << 1u;
        let of_run = cover_of_run(run, place, tile);
        let line = line_at_tile(start, run, place, tile);
        for (var column = of_run.begin; column < of_run.end; column++) {
            put_word(column, depth_of_line(line + i32(column), run, place), word);
        }
        if (joins_next(run)) {
            let of_span = cover_of_span(at, run, place, tile);
            let depth = depth_of_span(start, run, place);
            for (var column = of_span.begin; column < of_span.end; column++) {
                put_word(column, depth, word | 1u);
            }
        }
    }
    workgroupBarrier();
    for (var column = left + local; column < u32(tile.y); column += SLICE_WORKGROUP) {
        let word = atomicLoad(&words[column - left]);
        var found = vec2u(NONE, 0u);
        if (word != NONE) {
            found = winner(first_run, word, i32(column), view);
        }
        winners[scanline * block.width + column] = found;
    }
    if (local == 0u) {
        atomicAdd(&fragments[scanline], atomicLoad(&fragment_count));
    }
}
