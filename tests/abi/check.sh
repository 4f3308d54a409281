#!/usr/bin/env bash
# tests/abi/check.sh LIBRARY           compares the binary form of the C interface with that of tests/abi/lamella_c.abi
# tests/abi/check.sh LIBRARY --renew   writes that file anew: after a change that is meant
#
# What is added breaks no program. Everything else is a change that programs compiled before must survive.
set -euo pipefail
library=$1
baseline=$(dirname "${BASH_SOURCE[0]}")/lamella_c.abi
if [[ "${2:-}" == --renew ]]; then
    abidw --headers-dir include/lamella --drop-private-types --exported-interfaces-only --no-corpus-path --no-comp-dir-path --no-show-locs --no-elf-needed --out-file "$baseline" "$library"
    exit
fi
abidiff --harmless --no-added-syms --no-show-locs "$baseline" "$library" || {
    echo "the C interface has changed; if that is meant: tests/abi/check.sh $library --renew" >&2
    exit 1
}
