#!/usr/bin/env bash
# regions.sh PAGE TOOL: runs the commands of tools/docs/regions.md in a folder with a mesh of four boxes, and checks that each did
# what the page says.

# box LOW HIGH: the facets of a box from LOW to HIGH in x and from 0 to 10 in y and z, as ASCII STL.
box() {
    local corner facet
    local -a corners=("$1 0 0" "$2 0 0" "$2 10 0" "$1 10 0" "$1 0 10" "$2 0 10" "$2 10 10" "$1 10 10")
    for facet in 021 032 456 467 015 054 126 165 237 276 304 347; do
        echo "facet normal 0 0 0 outer loop"
        for corner in "${facet:0:1}" "${facet:1:1}" "${facet:2:1}"; do
            echo "vertex ${corners[$corner]}"
        done
        echo "endloop endfacet"
    done
}
prepare() { { echo "solid part"; box 0 5; box 4 9; box 9.05 12; box 20 30; echo "endsolid part"; } > part.stl; }

source "$(dirname "${BASH_SOURCE[0]}")/page.sh" "$@"
[[ $(grep -c '^lamella slice' examples) == 7 ]] || { echo "the page does not show seven slices"; exit 1; }

# has FILE COUNT WORDS: the SVG has that many contours of that kind in its 50 layers.
has() { [[ $(grep -o "$3" "$1" | wc -l) == "$2" ]] || { echo "$1: not $2 times $3"; exit 1; }; }
has united.svg 150 'slic3r:type="contour"'
has closed.svg 100 'slic3r:type="contour"'
has shrunk.svg 150 'slic3r:type="contour"'
has shrunk.svg 50 'points="0.2,0.2 8.8,0.2 8.8,9.8 0.2,9.8"'
has light.svg 150 'slic3r:type="contour"'
has light.svg 50 'points="20,0 30,0 30,10 20,10"'
has flagged.svg 150 'slic3r:type="contour"'
has flagged.svg 100 'class="near"'
has overhang.svg 3 'slic3r:type="contour"'
grep -q '"fill_rule": *"outermost"' rules.json || { echo "the report does not name the rule"; exit 1; }
