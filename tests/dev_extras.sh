#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# `./dev extras` where no package is a Chromium, as on Ubuntu: it says so, and installs all the rest. Nothing is
# installed here: apt-get is a script of ours.
set -euo pipefail
dev=$1
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

for tool in bash env dirname sed grep sort cat printf; do ln -s "$(command -v "$tool")" "$folder/$tool"; done
script() {
  printf '#!/usr/bin/env bash\n%s\n' "$2" >"$folder/$1"
  chmod +x "$folder/$1"
}
script npm ''
script node ''
script dpkg-query ''
script sudo 'exec "$@"'
script chromium-browser 'echo "this needs the snap"; exit 1'
script apt-get 'echo "$*" >>"'"$folder"'/asked"; [[ $* != *chromium* ]]'

words=$(PATH=$folder "$dev" extras 2>&1) || { echo "$words"; exit 1; }
grep -q 'tests of the page in a browser will be skipped' <<<"$words" || { echo "$words"; exit 1; }
grep -q 'libopenmpi-dev' "$folder/asked" || { cat "$folder/asked"; exit 1; }
grep -q 'libfclib-dev' "$folder/asked" || { cat "$folder/asked"; exit 1; }
