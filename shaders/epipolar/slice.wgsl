// The lines that pixels show (Epipolar 3.3.2), as src/epipolar/slice.rs. A workgroup finds the winners of some columns of a scanline of
// a view: the least depth of each first, then the least line of those that have it. Needs `moved`.

@group(0) @binding(0) var<storage, read> block: SliceBlock;
// The first line of each scanline, and the end of the last.
@group(0) @binding(1) var<storage, read> starts: array<u32>;
@group(0) @binding(2) var<storage, read> lines: array<SliceLine>;
@group(0) @binding(3) var<storage, read> places: array<SlicePlace>;
@group(0) @binding(4) var<storage, read_write> winners: array<vec2u>;
// Pixels that lines and spans cover, added by scanline of a view.
@group(0) @binding(5) var<storage, read_write> fragments: array<atomic<u32>>;

// By column: the high and the low half of a key.
var<workgroup> depths: array<atomic<u32>, SLICE_COLUMNS>;
var<workgroup> words: array<atomic<u32>, SLICE_COLUMNS>;
var<workgroup> fragment_count: atomic<u32>;

fn place_of(line: SliceLine, view: u32) -> SlicePlace {
    return places[(line.flags & 0xffffu) * block.views + view];
}

fn column_of(line: SliceLine, place: SlicePlace) -> i32 {
    return line.column + moved(line.disparity, place.place);
}

fn is_own(line: SliceLine, place: SlicePlace) -> bool {
    return (line.flags & LINE_FIRST) != 0u && place.place == 0;
}

// Pixels of a line or of a span: columns within those of the workgroup, from their first.
struct Cover {
    begin: u32,
    end: u32,
    depth: u32,
}

fn cover(begin: i32, end: i32, depth: u32, tile: vec2i) -> Cover {
    let first = clamp(begin, tile.x, tile.y);
    let last = clamp(end, first, tile.y);
    return Cover(u32(first - tile.x), u32(last - tile.x), depth);
}

// What a line covers.
fn cover_of_line(line: SliceLine, place: SlicePlace, tile: vec2i) -> Cover {
    let column = column_of(line, place) >> COLUMN_BITS;
    // Its own view shows the first layer as it was, whatever lies before it between the middles of pixels.
    let depth = select(line.depth + place.bias, 0u, is_own(line, place));
    return cover(column, column + 1, depth, tile);
}

// What lies between a line and the next one, which it joins.
fn cover_of_span(at: u32, line: SliceLine, place: SlicePlace, tile: vec2i) -> Cover {
    let next = lines[at + 1u];
    let columns = vec2i(column_of(line, place), column_of(next, place)) >> vec2u(COLUMN_BITS);
    return cover(columns.x + 1, columns.y, max(line.depth, next.depth) + place.bias, tile);
}

fn put_depths(covered: Cover) {
    for (var column = covered.begin; column < covered.end; column++) {
        atomicMin(&depths[column], covered.depth);
    }
}

fn put_words(covered: Cover, word: u32) {
    for (var column = covered.begin; column < covered.end; column++) {
        if (atomicLoad(&depths[column]) == covered.depth) {
            atomicMin(&words[column], word);
        }
    }
}

// The two words of a winner: its line, whether a span of it won, and the line beside it that it is blended with.
fn winner(start: u32, word: u32, column: i32, view: u32) -> vec2u {
    let at = start + (word >> 1u);
    let line = lines[at];
    let place = place_of(line, view);
    let own = select(0u, WINNER_OWN, is_own(line, place));
    let line_column = column_of(line, place);
    let right_of_line = (column << COLUMN_BITS) + (1 << (COLUMN_BITS - 1u)) - line_column;
    // A line before the middle of the pixel is blended with the one after it, and the other way round.
    var side = 0u;
    var beside = at;
    if (right_of_line > 0 && ((line.flags & LINE_JOINS) != 0u || (word & 1u) != 0u)) {
        side = WINNER_AFTER;
        beside = at + 1u;
    } else if (right_of_line < 0 && at > start && (lines[max(at, 1u) - 1u].flags & LINE_JOINS) != 0u) {
        side = WINNER_BEFORE;
        beside = at - 1u;
    }
    let parted = column_of(lines[beside], place) - line_column;
    // Lines that have come closer, or changed places, are not blended.
    if (side == 0u || sign(parted) != sign(right_of_line)) {
        return vec2u(word >> 1u, own);
    }
    let shift = select(0u, COLUMN_BITS, abs(parted) >= (1 << 22u));
    let columns = abs(vec2i(right_of_line, parted)) >> vec2u(shift);
    let weight = min((255 * columns.x + columns.y / 2) / columns.y, 255);
    return vec2u(word >> 1u, u32(weight) | side | own);
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
    let end = starts[row + 1u];
    for (var column = local; column < SLICE_COLUMNS; column += SLICE_WORKGROUP) {
        atomicStore(&depths[column], NONE);
        atomicStore(&words[column], NONE);
    }
    workgroupBarrier();
    var count = 0u;
    for (var at = start + local; at < end; at += SLICE_WORKGROUP) {
        let line = lines[at];
        let place = place_of(line, view);
        let of_line = cover_of_line(line, place, tile);
        put_depths(of_line);
        count += of_line.end - of_line.begin;
        if ((line.flags & LINE_JOINS) != 0u) {
            let of_span = cover_of_span(at, line, place, tile);
            put_depths(of_span);
            count += of_span.end - of_span.begin;
        }
    }
    atomicAdd(&fragment_count, count);
    workgroupBarrier();
    for (var at = start + local; at < end; at += SLICE_WORKGROUP) {
        let line = lines[at];
        let place = place_of(line, view);
        let word = (at - start) << 1u;
        put_words(cover_of_line(line, place, tile), word);
        if ((line.flags & LINE_JOINS) != 0u) {
            put_words(cover_of_span(at, line, place, tile), word | 1u);
        }
    }
    workgroupBarrier();
    for (var column = left + local; column < u32(tile.y); column += SLICE_WORKGROUP) {
        let word = atomicLoad(&words[column - left]);
        var found = vec2u(NONE, 0u);
        if (word != NONE) {
            found = winner(start, word, i32(column), view);
        }
        winners[scanline * block.width + column] = found;
    }
    if (local == 0u) {
        atomicAdd(&fragments[scanline], atomicLoad(&fragment_count));
    }
}
