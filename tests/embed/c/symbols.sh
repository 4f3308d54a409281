#!/usr/bin/env bash
# symbols.sh SHARED STATIC HEADERS FOLDER: the shared library exports the functions of the headers in the folder HEADERS and
# nothing else; what the static one defines for others is lamella's. FOLDER takes what is written.
set -euo pipefail
shared=$1 static=$2 headers=$3 folder=$4

# exports_interface LIBRARY: fails unless LIBRARY exports the functions of the headers.
exports_interface() {
    local defined
    defined=$(nm -D --defined-only --format=posix "$1") || return 1
    diff <(grep -ho 'LAMELLA_C_API[^;(]*' "$headers"/*.h | grep -o 'lamella_[a-z0-9_]*$' | sort) \
        <(awk '{ sub(/@.*/, "", $1); print $1 }' <<< "$defined" | sort)
}

[[ $(cat "$headers"/*.h | grep -c '^LAMELLA_C_API') -ge 25 ]] || { echo "$headers declares too little"; exit 1; }
exports_interface "$shared" || { echo "$shared does not export what $headers declares"; exit 1; }
! exports_interface "$(dirname "$(c++ -print-libgcc-file-name)")/libstdc++.so" > "$folder/differences" 2>&1 ||
    { echo "a library that exports something else is not noticed"; exit 1; }

dynamic=$(readelf -dW "$shared")
[[ $dynamic =~ SONAME[^$'\n']*\[liblamella_c\.so\.[0-9]+\.[0-9]+\] ]] || { echo "$shared has no SONAME"; exit 1; }
relocations=$(readelf -rW "$shared")
[[ $relocations == *JUMP_SLO* ]] || { echo "readelf lists no calls of $shared"; exit 1; }
[[ $relocations != *lamella* ]] || { echo "a host can catch calls within $shared"; exit 1; }

# Strong symbols: those of templates from the C++ library are weak.
symbols=$(nm --defined-only --extern-only "$static")
foreign=$(awk '$2 ~ /^[TDBR]$/ && $3 !~ /lamella/ { print $3 }' <<< "$symbols")
[[ -z $foreign && $symbols == *lamella_slice* ]] || { echo "$static defines $foreign"; exit 1; }
# Position-independent: a shared library can be made of it, which exports the C interface and nothing of C++; or, as a plugin's,
# nothing at all.
seen_in_library() {
    c++ -shared "$@" -Wl,--whole-archive "$static" -Wl,--no-whole-archive -o "$folder/whole.so"
    nm -D --defined-only "$folder/whole.so" | awk '$2 ~ /^[TDBR]$/ { print $3 }'
}
symbols=$(seen_in_library)
[[ -n $symbols && -z $(grep -v '^lamella_' <<< "$symbols") ]] || { echo "of a host's library these would be seen: $symbols"; exit 1; }
symbols=$(seen_in_library -Wl,--exclude-libs,ALL)
[[ -z $symbols ]] || { echo "of a plugin these would be seen: $symbols"; exit 1; }
rm "$folder/whole.so" "$folder/differences"
echo "symbols are lamella's"
