#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Completions as each shell makes them, and the manual page as its readers take it: completion.sh <thenar> <app/completion>
# Shells that are not installed are left out; bash is there.
set -euo pipefail
thenar=$1 scripts=$2
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
mkdir "$folder/results" && touch "$folder/my scene.yaml" "$folder/box_mine.yaml"
cd "$folder"
PATH=$(dirname "$thenar"):$PATH

fail() {
  echo "$1" >&2
  exit 1
}

# bash_says <word>...: what the last word becomes, a line each.
bash_says() {
  bash --norc -c '
    source "$1"
    complete -p thenar >/dev/null || exit 1
    compopt() { :; }  # Only of use while bash itself completes.
    COMP_WORDS=(thenar "${@:2}") COMP_CWORD=$(($# - 1))
    _thenar thenar "${!#}" "${@: -2:1}"
    printf "%s\n" "${COMPREPLY[@]}"' - "$scripts/thenar.bash" "$@"
}

# fish_says <command line>
fish_says() { fish --no-config -c "source $scripts/thenar.fish; complete -C '$1'" | cut -f1; }

# zsh_becomes <command line> <what the line then holds>: as typed, with a tab behind it.
zsh_becomes() {
  timeout --foreground 60 zsh -f -c '
    zmodload zsh/zpty
    zpty shell zsh -f -i
    zpty -w shell "PS1=; fpath=(${(q)1} \$fpath); autoload -Uz compinit; compinit -u -D; print RE\"\"ADY"
    zpty -r -m shell said "*READY*"
    zpty -w -n shell "$2"$'"'\\t'"'
    zpty -r -m shell said "*$3*"
    zpty -d shell' zsh "$scripts" "$1" "$2" >/dev/null || fail "zsh: '$1' does not become '$2'"
}

# expect <what was said> <line that must be there>...
expect() {
  local said=$1 line
  for line in "${@:2}"; do grep -qxF -- "$line" <<<"$said" || fail "'$line' is not in:"$'\n'"$said"; done
}

[[ $(bash_says ru) == run ]] || fail "bash: ru becomes $(bash_says ru)"
expect "$(bash_says run box_)" box_grasp box_mine.yaml
expect "$(bash_says run --f)" --floor
expect "$(bash_says run box_grasp --format '')" text json
expect "$(bash_says run box_grasp --format = j)" json
expect "$(bash_says run 'my')" "my scene.yaml"
expect "$(bash_says run box_grasp --set contact.fr)" contact.friction=
expect "$(bash_says hand '')" import capacity leap
expect "$(bash_says solve --method ex)" exact_cone
[[ -z $(bash_says scenes '') && -z $(bash_says run --time '') && -z $(bash_says nothing '') ]] || fail "bash completes what nothing is known of"
if command -v fish >/dev/null; then
  expect "$(fish_says 'thenar ru')" run
  expect "$(fish_says 'thenar run box_')" box_grasp box_mine.yaml
  expect "$(fish_says 'thenar run --f')" --floor
  expect "$(fish_says 'thenar run box_grasp --format=j')" --format=json
fi
if command -v zsh >/dev/null; then
  zsh_becomes 'thenar ru' 'thenar run'
  zsh_becomes 'thenar run box_gr' box_grasp
  zsh_becomes 'thenar run --fl' --floor
fi

# The manual page has every command with its exit codes.
thenar man >thenar.1
for command in $(thenar complete '' | cut -f1); do
  thenar "$command" --help | grep -q "Exit code" || fail "thenar $command --help does not name its exit codes"
  grep -qF "\"thenar $command" thenar.1 || fail "the manual page has no $command"
done
if command -v mandoc >/dev/null; then mandoc -T lint -W warning thenar.1 || fail "mandoc warns"; fi
if command -v groff >/dev/null; then
  said=$(LC_ALL=C.UTF-8 groff -man -Tutf8 -ww -rCHECKSTYLE=3 thenar.1 2>&1 >/dev/null)
  [[ -z $said ]] || fail "groff warns: $said"
fi
