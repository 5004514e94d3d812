#!/usr/bin/env bash
# Sourced by the scripts beside it, to install what is missing.

# `need PACKAGE…` installs Debian packages, where root or sudo allows it, and reports where it does not.

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

# `need_python PACKAGE…` installs Python packages, in the versions of requirements.txt, into a virtual environment under the
# target folder. Sets `environment` to its folder and `python` to its interpreter, or to python3 where it cannot be made.
# Returns 1 where the packages cannot be installed.
need_python() {
    local here done_already
    here=$(dirname "${BASH_SOURCE[0]}")
    environment=$(realpath -m "${CARGO_TARGET_DIR:-$here/../target}/scripts")
    python=$environment/bin/python
    done_already=$environment/installed-$(cksum <<<"$* $(cat "$here/requirements.txt")" | cut -d' ' -f1)
    [ ! -e "$done_already" ] || return 0
    echo "installing $*" >&2
    if [ ! -x "$environment/bin/pip" ]; then
        # Debian has it in a package of its own.
        python3 -c 'import ensurepip' 2>/dev/null || need python3-venv
        python3 -m venv --system-site-packages "$environment" >&2 || python=python3
    fi
    if [ "$python" != python3 ] &&
        timeout 300 "$python" -m pip install --quiet --disable-pip-version-check -c "$here/requirements.txt" "$@" </dev/null >&2; then
        touch "$done_already"
        return
    fi
    echo "NOT INSTALLED: $*" >&2
    return 1
}
