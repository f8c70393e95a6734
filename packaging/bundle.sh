#!/usr/bin/env bash
# Makes a folder with the program and the libraries that it needs, for Linux machines that have
# neither it nor them: glibc 2.36, libstdc++ of GCC 12 or later, and OpenGL where it is to be used.
#
# usage: packaging/bundle.sh PREFIX FOLDER      PREFIX: where `cmake --install` put the program
set -euo pipefail

# What belongs to a machine: the C and C++ runtimes, which its graphics drivers load too, and OpenGL.
readonly of_the_machine='^(linux-vdso|ld-linux|lib(c|m|dl|rt|pthread|resolv|stdc\+\+|gcc_s|GL|GLX|GLdispatch|OpenGL|EGL|drm))[.-]'

die() {
    printf 'bundle.sh: %s\n' "$*" >&2
    exit 1
}

(($# == 2)) || die 'usage: packaging/bundle.sh PREFIX FOLDER'
prefix=$1
folder=$2
[[ -x $prefix/bin/occlude ]] || die "$prefix/bin/occlude is not there; run cmake --install first"
command -v patchelf >/dev/null || die 'patchelf is missing (Debian: patchelf)'

# The licence of the package that a library comes from, where Debian's packages tell it.
copy_licence() {
    local file package
    file=$(basename "$(realpath "$1")")
    package=$(dpkg-query -S "*/$(uname -m)-linux-gnu/$file" 2>/dev/null | head -n 1 | cut -d : -f 1) || true
    [[ -n $package && -e /usr/share/doc/$package/copyright ]] ||
        die "$1 is of no Debian package, so its licence is not known; it must be passed on with the library"
    cp "/usr/share/doc/$package/copyright" "$folder/licences/$package.txt"
}

rm -rf "$folder"
mkdir -p "$folder/bin" "$folder/lib" "$folder/licences"
cp "$prefix/bin/occlude" "$folder/bin/"
cp "$(dirname "${BASH_SOURCE[0]}")/../LICENSE" "$folder/licences/occlude.txt"
cp -r "$prefix/share" "$folder/"
while read -r name _ path _; do
    [[ $path == /* ]] || continue
    [[ $name =~ $of_the_machine ]] && continue
    cp -L "$path" "$folder/lib/$name"
    chmod 644 "$folder/lib/$name"
    copy_licence "$path"
    patchelf --set-rpath "\$ORIGIN" "$folder/lib/$name"
done < <(ldd "$prefix/bin/occlude")
patchelf --set-rpath "\$ORIGIN/../lib" "$folder/bin/occlude"

# Nothing but the machine's own may be found outside of the folder.
outside=$(env -i ldd "$folder/bin/occlude" | awk -v folder="$(realpath "$folder")" '
    $2 == "=>" && index($3, folder) != 1 { print $1 }' | grep -vE "$of_the_machine" || true)
[[ -z $outside ]] || die "not in the bundle: $outside"
printf 'bundle: %s, %s, %d libraries\n' "$folder" "$(du -sh "$folder" | cut -f1)" "$(find "$folder/lib" -type f | wc -l)"
