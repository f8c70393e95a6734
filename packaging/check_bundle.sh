#!/usr/bin/env bash
# Runs a bundle in a bare Debian 12 root: no library of ours is installed there, and no OpenGL.
#
# usage: packaging/check_bundle.sh FOLDER
set -euo pipefail

(($# == 1)) || { printf 'usage: packaging/check_bundle.sh FOLDER\n' >&2; exit 1; }
bundle=$(realpath "$1")
name=$(basename "$bundle")
# shellcheck disable=SC2016 # $1 is the root, in mmdebstrap's shell
mmdebstrap --quiet --variant=essential --include=libstdc++6 \
    --customize-hook="copy-in '$bundle' /opt" \
    --customize-hook='env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin chroot "$1" /opt/'"$name"'/bin/occlude verify city:blocks=4,triangles=40k \
        --device cpu --algorithms exact --frames 4 --size 160x90' \
    --customize-hook='env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin chroot "$1" /opt/'"$name"'/bin/occlude info bunnies:count=3' \
    bookworm /dev/null
