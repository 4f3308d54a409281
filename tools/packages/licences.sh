# Sourced by the scripts that make packages.

# copy_licences LIBRARIES FOLDER PACKAGE...: into FOLDER, the licences of lamella, of what libraries.sh has built in LIBRARIES, of
# the headers that everything is compiled with, and of other packages of Debian.
copy_licences() {
    local from=$1 to=$2 file name
    mkdir -p "$to"
    cp LICENSE "$to/lamella"
    cp -L /usr/share/common-licenses/{LGPL-2.1,GPL-3} "$to"  # of glibc and of the compiler's libraries, which allow this use
    for file in "$from"/sources/*/debian/copyright; do
        name=$(basename "${file%/debian/copyright}")
        cp "$file" "$to/${name%%-[0-9]*}"
    done
    for name in libfast-float-dev nlohmann-json3-dev "${@:3}"; do
        cp "/usr/share/doc/$name/copyright" "$to/$name"
    done
}
