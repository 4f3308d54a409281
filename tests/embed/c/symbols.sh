#!/usr/bin/env bash
# symbols.sh SHARED STATIC: the shared library exports nothing but the C interface; what the static one defines for others is
# lamella's.
set -euo pipefail
foreign=$(nm -D --defined-only "$1" | awk '{ print $3 }' | grep -v '^lamella_' || true)
[[ -z "$foreign" ]] || { echo "$1 exports $foreign"; exit 1; }
[[ $(nm -D --defined-only "$1" | grep -c ' T lamella_') -ge 30 ]] || { echo "$1 exports too little"; exit 1; }
readelf -d "$1" | grep -q 'SONAME.*liblamella_c[.]so[.][0-9]' || { echo "$1 has no SONAME"; exit 1; }
# Strong symbols: those of templates from the C++ library are weak.
foreign=$(nm --defined-only --extern-only "$2" | awk '$2 ~ /[TDBR]/ { print $3 }' | grep -v 'lamella' || true)
[[ -z "$foreign" ]] || { echo "$2 defines $foreign"; exit 1; }
# Position-independent: a shared library can be made of it.
c++ -shared -Wl,--whole-archive "$2" -Wl,--no-whole-archive -o "$3/whole.so"
rm "$3/whole.so"
echo "symbols are lamella's"
