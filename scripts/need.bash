#!/usr/bin/env bash
# Sourced by the scripts beside it: `need PACKAGE…` installs the Debian packages that are missing, where root or sudo
# allows it, and says so where it does not.

need() {
    local missing=() package
    command -v dpkg-query >/dev/null || return 0
    for package in "$@"; do
        [ "$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || missing+=("$package")
    done
    [ ${#missing[@]} -gt 0 ] || return 0
    local as_root=()
    [ "$(id -u)" = 0 ] || as_root=(sudo -n)
    if command -v apt-get >/dev/null && { [ "$(id -u)" = 0 ] || sudo -n true 2>/dev/null; }; then
        echo "installing ${missing[*]}" >&2
        export DEBIAN_FRONTEND=noninteractive
        "${as_root[@]}" apt-get update -qq </dev/null >&2 || echo "apt-get update failed; trying with the lists there are" >&2
        "${as_root[@]}" apt-get install -y -qq --no-install-recommends "${missing[@]}" </dev/null >/dev/null ||
            echo "NOT INSTALLED: ${missing[*]}" >&2
    else
        echo "NOT INSTALLED, and apt-get cannot do it here: ${missing[*]}" >&2
    fi
}

# A tool that is there needs no package of that name.
need_tool() {
    command -v "$1" >/dev/null || need "$2"
    command -v "$1" >/dev/null || { echo "$1 is needed and not there" >&2; exit 1; }
}
