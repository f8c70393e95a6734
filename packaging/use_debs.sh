#!/bin/sh
# Installs the packages in /packages into this bare Debian 12 root and uses them: the programs of
# somebody else's in /opt/install by CMake and by pkg-config, and the program on its castle.
# packaging/check_debs.sh runs it there.
set -eux
export DEBIAN_FRONTEND=noninteractive
apt-get -q update
apt-get -q install -y --no-install-recommends /packages/libocclude1_*.deb /packages/libocclude-dev_*.deb \
    /packages/occlude_*.deb g++ cmake make pkg-config

cmake -S /opt/install -B /opt/build -DOCCLUDE_COMPONENTS=gl,c,conformance
cmake --build /opt/build
/opt/build/consumer
/opt/build/consumer_c

# shellcheck disable=SC2046 # several words
c++ -std=c++20 /opt/install/consumer.cpp -o /opt/by_pkg_config $(pkg-config --static --cflags --libs occlude occlude-gl)
/opt/by_pkg_config
# shellcheck disable=SC2046
cc /opt/install/consumer.c -o /opt/c_by_pkg_config $(pkg-config --cflags --libs occlude-c)
/opt/c_by_pkg_config

castle=/usr/share/occlude/assets/castle/castle.glb
occlude verify $castle --device cpu --frames 2 --size 160x90 --algorithms exact
occlude bench $castle --device cpu --frames 2 --size 160x90
test -e /usr/share/man/man1/occlude.1.gz
