#!/usr/bin/env bash
# An OCI image is made of the tool, read back from its archive and run: the files are those of one machine.
source "$(dirname "${BASH_SOURCE[0]}")/support.sh"
build="$(dirname "$tool")/.."
most_megabytes=30

# buildah of its own folders, as in tools/cluster/image.sh.
images() { buildah --root "$work/storage" --runroot "$work/run" --storage-driver vfs "$@"; }

# in_image WORD...: runs the command in the container.
in_image() { images run "${by[@]}" --volume "$work:$work" --workingdir "$work" "$container" -- "$@"; }

step "an image"
"$root/tools/cluster/image.sh" lamella.tar "$build"
(($(stat --format=%s lamella.tar) < most_megabytes * 1000000)) || fail "the archive is larger than $most_megabytes MB"
container=$(images from --quiet "oci-archive:$work/lamella.tar")
images inspect "$container" > image.json
python3 - "$(lamella --version)" << 'END'
import json, sys
config = json.load(open("image.json"))["OCIv1"]["config"]
assert config["Entrypoint"] == ["lamella"], config
assert config["Labels"]["org.opencontainers.image.licenses"] == "Apache-2.0", config
assert config["Labels"]["org.opencontainers.image.version"] == sys.argv[1].split()[-1], config
END

step "it runs"
by=(--runtime runc --network none)
if ! in_image lamella --version > version.txt 2> log.run; then
    echo "by chroot, as runc fails here: $(tail -n 1 log.run)"
    by=(--isolation chroot)
    in_image lamella --version > version.txt
fi
lamella --version | cmp - version.txt || fail "the image has another version"
for mesh in meshes/m3.stl meshes/m11.stl; do
    lamella slice "$mesh" --layer-height 0.1 --hash | grep -i hash > here.txt
    in_image lamella slice "$mesh" --layer-height 0.1 --hash | grep -i hash > there.txt
    cmp here.txt there.txt || fail "the hash of $mesh differs"
done
in_image lamella slice meshes/m3.stl --layer-height 0.1 --memory 8M -o /dev/null --to csv > /dev/null || fail "no temporary file"
status=0
in_image lamella batch meshes "${batch_options[@]}" > image.txt || status=$?
((status == 5)) || fail "the batch in the image: status $status, not 5 for the damaged mesh"
same one_machine masks

step "nothing is left"
if "$root/tools/cluster/image.sh" broken.tar "$work" > log.broken 2>&1; then
    fail "a folder without a tool is accepted"
fi
grep -q "^error: .* has no tool" log.broken || fail "no tool: $(cat log.broken)"
if "$root/tools/cluster/image.sh" none/lamella.tar "$build" > log.broken 2>&1; then
    fail "a folder that is not there is accepted"
fi
[[ -z "$(find . -name '*.part')" && ! -e broken.tar ]] || fail "a part of an archive is left"
images rm --all > /dev/null
echo done
