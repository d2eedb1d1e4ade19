# SPDX-License-Identifier: Apache-2.0
# fish completion for thenar, which says itself what a word can become.
function __thenar_complete
    set -l words (commandline -opc)
    set -l begun (commandline -ct)
    for line in ($words[1] complete $words[2..-1] "$begun" 2>/dev/null)
        switch $line
            case :files
                __fish_complete_path (string replace -r '^--[^=]*=' '' -- "$begun")
            case :folders
                __fish_complete_directories (string replace -r '^--[^=]*=' '' -- "$begun")
            case '*'
                printf '%s\n' $line
        end
    end
end
complete -c thenar -f -a '(__thenar_complete)'
