#!/usr/bin/env bash
# tests/abi/check.sh LIBRARY              compares the binary form of the C interface with that of tests/abi/lamella_c.abi
# tests/abi/check.sh LIBRARY --renew      writes that file anew: after a change that is meant
# tests/abi/check.sh LIBRARY --self-test  checks that changes, and whatever cannot be compared, are reported
#
# Added functions break no program. Everything else is a change that programs compiled before must survive.
set -euo pipefail
library=$1
baseline=$(dirname "${BASH_SOURCE[0]}")/lamella_c.abi

# compare BASELINE LIBRARY: fails where they differ, and where either cannot be read.
compare() {
    # abidiff takes a broken file, and a library without debug information, for an interface without types.
    xmllint --noout "$1" || return 1
    grep -q "<class-decl name='lamella_options' size-in-bits=" "$1" || { echo "$1 describes no interface"; return 1; }
    local sections
    sections=$(readelf -SW "$2") || return 1
    [[ $sections == *.debug_info* ]] || { echo "$2 has no debug information"; return 1; }
    abidiff --harmless --no-added-syms --no-show-locs "$1" "$2"
}

# must_fail NAME EXPECTED BASELINE LIBRARY: the comparison must fail, and say why.
must_fail() {
    local said
    if said=$(compare "$3" "$4" 2>&1); then
        echo "self-test: not reported: $1"
        exit 1
    fi
    [[ $said == *$2* ]] || { echo "self-test: $1: not '$2' but: $said"; exit 1; }
}

# must_report NAME EXPECTED EXPRESSION: of a baseline changed by sed the library must differ.
must_report() {
    sed -E "$3" "$baseline" > "$work/$1.abi"
    if cmp -s "$baseline" "$work/$1.abi"; then
        echo "self-test: $1 changes nothing"
        exit 1
    fi
    must_fail "$1" "$2" "$work/$1.abi" "$library"
}

self_test() {
    work=$(mktemp -d)
    trap 'rm -rf "$work"' EXIT
    compare "$baseline" "$library"
    must_report function_gone "lamella_result_hash_of" "s/'lamella_result_hash'/'lamella_result_hash_of'/"
    must_report function_of_another_type "lamella_result_hash" \
        "/<function-decl name='lamella_result_hash'/,/<\/function-decl>/s/(<return type-id=')[^']*/\1type-id-1/"
    must_report field_renamed "mm_per_uni'" "s/'mm_per_unit'/'mm_per_uni'/"
    must_report field_moved "heights_mm" \
        "/layout-offset-in-bits='128'/{N;s/128(.*'heights_mm')/136\1/}"
    must_report struct_larger "struct lamella_options" "s/(class-decl name='lamella_options' size-in-bits=)'[0-9]*'/\1'8000'/"
    must_report soname "SONAME" "s/soname='liblamella_c[.]so[.]0[.]3'/soname='liblamella_c.so.1'/"
    must_report broken_baseline "parser error" "s/<abi-instr/<<abi-instr/"
    : > "$work/empty.abi"
    must_fail empty_baseline "parser error" "$work/empty.abi" "$library"
    head -n 300 "$baseline" > "$work/cut.abi"
    must_fail cut_baseline "parser error" "$work/cut.abi" "$library"
    echo '<abi-corpus/>' > "$work/bare.abi"
    must_fail bare_baseline "describes no interface" "$work/bare.abi" "$library"
    must_fail no_baseline "" "$work/none.abi" "$library"
    must_fail no_library "" "$baseline" "$work/none.so"
    must_fail no_elf_file "" "$baseline" "$baseline"
    objcopy --strip-debug "$library" "$work/stripped.so"
    must_fail stripped_library "no debug information" "$baseline" "$work/stripped.so"
    PATH=$work:$PATH
    printf '#!/bin/sh\nexit 1\n' > "$work/abidiff"
    chmod +x "$work/abidiff"
    hash -r
    must_fail broken_tool "" "$baseline" "$library"
    echo "changes of the C interface are reported"
}

case ${2:-} in
    --renew)
        abidw --headers-dir include/lamella --drop-private-types --exported-interfaces-only --no-corpus-path --no-comp-dir-path --no-show-locs --no-elf-needed --out-file "$baseline" "$library"
        ;;
    --self-test)
        self_test
        ;;
    "")
        compare "$baseline" "$library" || {
            echo "the C interface has changed; if that is meant: tests/abi/check.sh $library --renew" >&2
            exit 1
        }
        ;;
    *)
        sed -n '2,4s/^# //p' "$0"
        exit 2
        ;;
esac
