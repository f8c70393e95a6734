#!/usr/bin/env bash
# Runs a bundle in a bare Debian 12 root: first with no library of ours and no OpenGL there, then with
# that root's own OpenGL.
#
# usage: packaging/check_bundle.sh FOLDER
set -euo pipefail

(($# == 1)) || { printf 'usage: packaging/check_bundle.sh FOLDER\n' >&2; exit 1; }
bundle=$(realpath "$1")
at=/opt/$(basename "$bundle")
# $1 is the root, in mmdebstrap's shell
# shellcheck disable=SC2016
inside='env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin chroot "$1"'
verify="$inside $at/bin/occlude verify $at/share/occlude/assets/castle/castle.glb --path teleport --frames 4 --size 160x90"
mmdebstrap --quiet --variant=apt --include=libstdc++6 \
    --customize-hook="copy-in '$bundle' /opt" \
    --customize-hook="$inside $at/bin/occlude info bunnies:count=3 --device cpu" \
    --customize-hook="$verify --device cpu --algorithms exact" \
    --customize-hook="$inside apt-get -q install -y --no-install-recommends libegl1 libopengl0 libgl1-mesa-dri" \
    --customize-hook="$verify --device gl --algorithms exact" \
    bookworm /dev/null
