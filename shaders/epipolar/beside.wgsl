// Neighbouring line that a winner is blended with.

// Takes the index of a line and the second word of the winner; returns the index of the neighbouring line, or the line itself.
fn beside_of(at: u32, rest: u32) -> u32 {
    if ((rest & WINNER_AFTER) != 0u) {
        return at + 1u;
    }
    if ((rest & WINNER_BEFORE) != 0u) {
        return at - 1u;
    }
    return at;
}
