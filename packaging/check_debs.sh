#!/usr/bin/env bash
# Builds the Debian packages from this checkout, lets lintian look at them, installs them into a bare
# Debian 12 root and uses them there: the program, a C++ and a C program of somebody else's.
#
# usage: packaging/check_debs.sh FOLDER      FOLDER gets the packages
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

(($# == 1)) || { printf 'usage: packaging/check_debs.sh FOLDER\n' >&2; exit 1; }
mkdir -p "$1"
folder=$(realpath "$1")
rm -rf "${folder:?}"/*
mkdir "$folder/occlude"
git ls-files -z | xargs -0 cp --parents -t "$folder/occlude"
cp -r packaging/debian "$folder/occlude/debian"
(cd "$folder/occlude" && dpkg-buildpackage -b -us -uc)
lintian --fail-on error,warning --info "$folder"/*.changes

# $1 is the root, in mmdebstrap's shell
# shellcheck disable=SC2016
mmdebstrap --quiet --variant=apt --include=ca-certificates \
    --customize-hook='mkdir "$1/packages"' \
    --customize-hook="copy-in $(echo "$folder"/*.deb) /packages" \
    --customize-hook="copy-in '$folder/occlude/tests/install' '$PWD/packaging/use_debs.sh' /opt" \
    --customize-hook='env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin chroot "$1" /opt/use_debs.sh' \
    bookworm /dev/null
