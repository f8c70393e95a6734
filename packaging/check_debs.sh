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

# shellcheck disable=SC2016 # $1 is the root, in mmdebstrap's shell
mmdebstrap --quiet --variant=apt --include=ca-certificates \
    --customize-hook='mkdir "$1/packages"' \
    --customize-hook="copy-in $(echo "$folder"/*.deb) /packages" \
    --customize-hook="copy-in '$folder/occlude/tests/install' /opt" \
    --customize-hook='chroot "$1" sh -c "apt-get -q update && apt-get -q install -y --no-install-recommends \
        /packages/libocclude1_*.deb /packages/libocclude-dev_*.deb /packages/occlude_*.deb g++ cmake make pkg-config"' \
    --customize-hook='chroot "$1" sh -c "cmake -S /opt/install -B /opt/build -DOCCLUDE_COMPONENTS=gl,c,conformance \
        && cmake --build /opt/build && /opt/build/consumer && /opt/build/consumer_c"' \
    --customize-hook='chroot "$1" sh -c "c++ -std=c++20 /opt/install/consumer.cpp -o /opt/by_pkg_config \
        \$(pkg-config --static --cflags --libs occlude occlude-gl) && /opt/by_pkg_config"' \
    --customize-hook='chroot "$1" occlude verify city:blocks=4,triangles=40k --device cpu --frames 4 --size 160x90' \
    --customize-hook='chroot "$1" test -e /usr/share/man/man1/occlude.1.gz' \
    bookworm /dev/null
