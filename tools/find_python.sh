#!/bin/sh
# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
#
# Print the path of a Python 3.11, 3.12 or 3.13 that really runs; exit 1 with a message when there
# is none. Every match on PATH is executed, because version managers leave commands that only fail.
# PYTHON=... overrides all; else the one that carries the present environment is kept, so that a
# changed PATH does not rebuild it; else one that can also build (headers, ensurepip) is preferred.
set -u

runs='import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 13))'
builds='import ensurepip, os, sysconfig, sys
sys.exit(not os.path.exists(os.path.join(sysconfig.get_path("include"), "Python.h")))'

if [ -n "${PYTHON:-}" ]; then
    if "$PYTHON" -c "$runs" >/dev/null 2>&1; then
        command -v -- "$PYTHON"
        exit 0
    fi
    echo "find_python: PYTHON=$PYTHON is not a running Python 3.11, 3.12 or 3.13" >&2
    exit 1
fi

kept=$(sed -n 's/^executable = //p' "$(dirname -- "$0")/../.venv/pyvenv.cfg" 2>/dev/null)
if [ -n "$kept" ] && "$kept" -c "$runs" >/dev/null 2>&1; then
    printf '%s\n' "$kept"
    exit 0
fi

second_best=
old_ifs=$IFS
for name in python3 python3.13 python3.12 python3.11; do
    IFS=:
    for folder in $PATH; do
        candidate=$folder/$name
        [ -x "$candidate" ] || continue
        "$candidate" -c "$runs" >/dev/null 2>&1 || continue
        if "$candidate" -c "$builds" >/dev/null 2>&1; then
            printf '%s\n' "$candidate"
            exit 0
        fi
        [ -n "$second_best" ] || second_best=$candidate
    done
    IFS=$old_ifs
done

if [ -n "$second_best" ]; then
    printf '%s\n' "$second_best"
    exit 0
fi
echo "find_python: no Python 3.11, 3.12 or 3.13 found on PATH." >&2
echo "find_python: install one (Debian 12, Ubuntu 24.04: apt install python3 python3-dev" \
    "python3-venv) or name it: make setup PYTHON=/path/to/python3.12" >&2
exit 1
