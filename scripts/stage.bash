#!/usr/bin/env bash
# Sourced by scripts/test and .ci/run: `stage NAME` begins a stage and prints the times of the one before it.

stage_name="" stage_start=0 stage_cpu=0 stage_times=""

stage() {
    stage_end
    stage_name=$1 stage_start=$SECONDS stage_cpu=$cpu
    printf '\n== %s\n' "$stage_name"
}

stage_end() {
    cpu_seconds
    [ -n "$stage_name" ] || return 0
    local line
    line="$((SECONDS - stage_start)) s, $((cpu - stage_cpu)) s of processor time: $stage_name"
    printf -- '-- %s\n' "$line"
    stage_times+="   $line"$'\n'
    stage_name=""
}

# `stages_passed WORDS` ends the last stage and prints the total and what each stage took, the slowest first.
stages_passed() {
    stage_end
    printf '\n== %s: %s s, %s s of processor time\n' "$1" "$SECONDS" "$cpu"
    printf '%s' "$stage_times" | sort -rn
}

# Sets `cpu` to the processor time of this shell's finished children, in whole seconds.
cpu_seconds() {
    # In a subshell `times` would count that one's children: it has to run here, into a file.
    local file
    file=$(mktemp)
    times >"$file"
    cpu=$(awk 'NR == 2 { for (i = 1; i <= 2; i++) { split($i, t, /[ms]/); sum += 60 * t[1] + t[2] } printf "%d", sum }' "$file")
    rm -f "$file"
}
