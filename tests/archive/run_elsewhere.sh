#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Runs the archive of tools/bundle where it was not built: in an empty folder of this machine, and in a root folder with
# the next Debian release, which has only drivers (PoCL for OpenCL, OSMesa for GL). The archive bakes, draws and serves
# there.
#   run_elsewhere.sh REPOSITORY BUILD_FOLDER
# Without root rights, mmdebstrap, patchelf or a Debian mirror, only the first part runs, and the exit code is 77
# (skipped).
set -euo pipefail
repository=$1
build=$2
release=trixie
work=$(mktemp -d)
root=$work/root
finish() {
  for mounted in dev proc sys; do
    if mountpoint -q "$root/$mounted"; then umount -l "$root/$mounted"; fi
  done
  rm -rf --one-file-system "$work"
}
trap finish EXIT
skip() { printf 'run_elsewhere: skipped: %s\n' "$*"; exit 77; }

command -v patchelf > /dev/null || skip 'patchelf is not installed (Debian package patchelf)'
"$repository/tools/bundle" --build "$build" --output "$work/multum.tar.xz" --xz-preset 0

# Runs the commands that a new user would try, inside the unpacked folder.
cat > "$work/try.sh" << 'TEXT'
set -euo pipefail
cd "$1"
bin=$PWD/bin
here=$2
mkdir -p "$here"
cd "$here"
"$bin/multum" devices
"$bin/multum" testmap map --size 64 > /dev/null
"$bin/multum" bake map_normal.png -o map.ndf.exr --green up --quiet
"$bin/multum" verify map.ndf.exr
"$bin/multum" info map.ndf.exr | grep '^checksum'
"$bin/multum-view" map.ndf.exr --context osmesa --size 96x64 -o frame.png
[ -s frame.png ]
# Starts a daemon and a client from this folder.
mkdir maps
"$bin/multum" serve --data served --listen "unix:$here/socket" --root "$here/maps" > serve.txt 2>&1 &
daemon=$!
trap 'kill $daemon 2> /dev/null || true; wait $daemon 2> /dev/null || true' EXIT
for _ in $(seq 100); do
  [ ! -S socket ] || break
  sleep 0.1
done
[ -S socket ] || { cat serve.txt; exit 1; }
"$bin/multum" jobs list --server "unix:$here/socket"
"$bin/test/pyramid_test" --gtest_brief=1 | tail -n 1
TEXT

echo 'run_elsewhere: in an empty folder'
mkdir "$work/elsewhere"
tar -xJf "$work/multum.tar.xz" -C "$work/elsewhere"
unpacked=$(echo "$work"/elsewhere/multum-*)
# Uses this machine's PoCL, and the kernels that it compiled for other tests.
env -i PATH=/usr/bin:/bin HOME="$work/elsewhere" LANG=C.UTF-8 MULTUM_CACHE_DIR= \
  POCL_CACHE_DIR="${POCL_CACHE_DIR:-${XDG_CACHE_HOME:-${HOME:-$work}/.cache}/pocl/kcache}" \
  bash "$work/try.sh" "$unpacked" "$work/elsewhere/tried" | tee "$work/here.txt"

[ "$(id -u)" -eq 0 ] || skip "a root of $release needs root privileges"
command -v mmdebstrap > /dev/null || skip 'mmdebstrap is not installed (Debian package mmdebstrap)'
mirror=$("$repository/tools/debian_mirror") || skip 'apt names no Debian mirror'
echo "run_elsewhere: in a root of $release"
# Packages and their dependencies are unpacked but not configured, which is enough for the programs here.
mmdebstrap --variant=extract --include=pocl-opencl-icd,libosmesa6,base-files,bash,coreutils,grep "$release" "$root" \
  "$mirror" > "$work/root.log" 2>&1 ||
  { tail -n 5 "$work/root.log"; skip "mmdebstrap could not make a root of $release"; }
# PoCL counts processors in /sys.
{ mount --bind /dev "$root/dev" && mount -t proc proc "$root/proc" && mount --bind /sys "$root/sys"; } ||
  skip 'nothing may be mounted here'
mkdir -p "$root/opt"
mv "$unpacked" "$root/opt/multum"
cp "$work/try.sh" "$root/try.sh"
chroot "$root" /usr/bin/env -i PATH=/usr/bin:/bin HOME=/tmp LANG=C.UTF-8 MULTUM_CACHE_DIR= \
  bash /try.sh /opt/multum /tmp/tried | tee "$work/there.txt"
# Another C library, another PoCL and another compiler must give the same bytes.
cmp <(grep '^checksum' "$work/here.txt") <(grep '^checksum' "$work/there.txt")
echo 'run_elsewhere: both bakes have the same checksum'
