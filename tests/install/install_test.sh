#!/usr/bin/env bash
# install_test.sh CMAKE BUILD CONSUMER WORK: installs BUILD under WORK/prefix, builds CONSUMER against it, runs it.
set -euo pipefail
cmake=$1 build=$2 consumer=$3 work=$4
rm -rf "$work"
"$cmake" --install "$build" --prefix "$work/prefix" >/dev/null
[ -x "$work/prefix/bin/furrow" ]
"$cmake" -G Ninja -S "$consumer" -B "$work/build" -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH="$work/prefix" \
  -DCMAKE_CXX_FLAGS="$(sed -n 's/^CMAKE_CXX_FLAGS:STRING=//p' "$build/CMakeCache.txt")" >/dev/null
"$cmake" --build "$work/build" >/dev/null
"$work/build/consumer"
