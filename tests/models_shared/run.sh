#!/bin/sh
# run.sh FOLDER TESTS TAG: runs the tests with the tag. Exit status 77, "skipped" for ctest, if the folder has no meshes.
if [ ! -f "$1/liver.stl" ]; then
    echo "skipped: no test meshes in $1"
    exit 77
fi
exec "$2" "$3"
