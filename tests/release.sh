#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# `./dev release`, up to its packages, in a repository of its own with these files: release.sh <project>
set -euo pipefail
project=$(cd "$1" && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
copy=$folder/copy
version=99.1.0
export GIT_CONFIG_GLOBAL=$folder/gitconfig GIT_CONFIG_NOSYSTEM=1
git config --global user.name "The test" && git config --global user.email test@localhost
git config --global init.defaultBranch main

fail() {
  echo "$1" >&2
  exit 1
}
release() { /usr/bin/python3 -B "$copy/cmake/release.py" "$copy" "$@"; }
# refused <what it says> <argument>...
refused() {
  if release "${@:2}" >"$folder/said" 2>&1; then fail "not refused: release ${*:2}"; fi
  grep -q -- "$1" "$folder/said" || fail "release ${*:2} says $(cat "$folder/said"), and not $1"
}

# Without git there is nothing to copy: an archive of the source.
git -C "$project" rev-parse --git-dir >/dev/null 2>&1 || exit 77
mkdir "$copy"
git -C "$project" ls-files -z --cached --others --exclude-standard |
  (cd "$project" && xargs -0 sh -c 'for f; do [ ! -e "$f" ] || printf "%s\0" "$f"; done' -) |
  tar -C "$project" --null -T - -cf - | tar -C "$copy" -xf -
git -C "$copy" init --quiet
# There is something new to tell.
/usr/bin/python3 -B - "$copy/CHANGELOG.md" <<'PYTHON'
import pathlib, re, sys
file = pathlib.Path(sys.argv[1])
file.write_text(re.sub(r"^## Next\n(.*?)(?=^## )", "## Next\n\n- **News of the test.**\n\n", file.read_text(),
                       flags=re.MULTILINE | re.DOTALL))
PYTHON
git -C "$copy" add --all && git -C "$copy" commit --quiet --message "All files"

refused "is no version" 1.2
refused "is not later than" 0.1.0
echo >>"$copy/README.md"
refused "README.md" "$version"
git -C "$copy" checkout --quiet README.md
git -C "$copy" rev-parse HEAD >"$folder/before"

# A dry run shows the changes, and makes none.
release --dry-run "$version" >"$folder/said"
for line in "+project(thenar VERSION $version " "+version: $version" "+date-released: " "+## $version ("; do
  grep -qF -- "$line" "$folder/said" || fail "a dry run does not show $line"
done
[[ -z $(git -C "$copy" status --porcelain --ignored) ]] || fail "a dry run changes files"
[[ $(git -C "$copy" rev-parse HEAD) == "$(cat "$folder/before")" && -z $(git -C "$copy" tag) ]] || fail "a dry run writes to git"

# A release: its commit, its tag, its changes, and an archive that knows its commit.
release "$version"
[[ -z $(git -C "$copy" status --porcelain) ]] || fail "a release leaves files that are not committed"
commit=$(git -C "$copy" rev-parse "v$version^{commit}")
[[ $commit == "$(git -C "$copy" rev-parse HEAD)" && $(git -C "$copy" rev-parse HEAD~) == "$(cat "$folder/before")" ]] ||
  fail "the tag is not at the one new commit"
/usr/bin/python3 -B - "$copy/CHANGELOG.md" "$version" <<'PYTHON'
import pathlib, re, sys
text, version = pathlib.Path(sys.argv[1]).read_text(), re.escape(sys.argv[2])
sys.exit(not re.search(rf"^## Next\n\n## {version} \(\d{{4}}-\d\d-\d\d\)\n\n- \*\*News of the test", text, re.MULTILINE))
PYTHON
(cd "$copy" && cmake -P tests/docs.cmake >/dev/null) || fail "the documents do not agree on the version"
tar -C "$folder" -xzf "$copy/out/release/thenar-$version.tar.gz"
cmake -D GIT=git -D SOURCE="$folder/thenar-$version" -D OUTPUT="$folder/source_id.cpp" \
  -P "$folder/thenar-$version/engine/formats/source_id.cmake"
grep -q "kSource = \"${commit:0:12}\"" "$folder/source_id.cpp" || fail "the archive does not know its commit: $(cat "$folder/source_id.cpp")"

# Again: it goes on with the files. Then nothing is new.
rm "$copy/out/release/thenar-$version.tar.gz"
release "$version"
[[ -e $copy/out/release/thenar-$version.tar.gz && $(git -C "$copy" rev-parse HEAD) == "$commit" ]] || fail "a release is made twice"
refused "nothing under 'Next'" 99.2.0
