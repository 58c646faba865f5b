# shellcheck shell=bash
# Completion of lumctl, lumdump, lumsim for bash. Options and the words they take
# are read from the tools' own --help, so this file does not have to know them.

_lumsdk_options() {
    "$1" --help 2>/dev/null | grep -oE -- '(^|[ ,])--[a-z][a-z-]*' | grep -oE -- '--[a-z-]+' | sort -u
}

# The words of "--option a|b|c" in the help.
_lumsdk_words() {
    "$1" --help 2>/dev/null | sed -nE "s/.*$2 ([a-z0-9]+(\|[A-Za-z0-9]+)+).*/\1/p" | head -n 1 | tr '|' '\n'
}

_lumsdk_files() {
    compopt -o filenames 2>/dev/null
    mapfile -t COMPREPLY < <(compgen -f -- "$1")
}

_lumsdk_choose() {
    mapfile -t COMPREPLY < <(compgen -W "$1" -- "$2")
}

_lumctl_commands='apply doctor heartbeat holdoff laser lines offset power send set-ip shell status threshold time tlv yscan'

# The first word that is a command, as far as the cursor.
_lumctl_command() {
    local word
    for word in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do
        case " $_lumctl_commands " in
        *" $word "*)
            printf '%s\n' "$word"
            return
            ;;
        esac
    done
}

_lumsdk() {
    local tool=$1 current=$2 previous=$3 words
    case $previous in
    --output | -o | --calibration | --profile | --log | --truth | --replay)
        _lumsdk_files "$current"
        return
        ;;
    --interface)
        words=$(ls /sys/class/net 2>/dev/null)
        _lumsdk_choose "$words" "$current"
        return
        ;;
    --*)
        words=$(_lumsdk_words "$tool" "$previous")
        if [ -n "$words" ]; then
            _lumsdk_choose "$words" "$current"
            return
        fi
        ;;
    esac
    if [[ $current == -* ]]; then
        _lumsdk_choose "$(_lumsdk_options "$tool")" "$current"
    elif [[ ${tool##*/} == lumctl* ]]; then
        case $(_lumctl_command) in
        '') _lumsdk_choose "$_lumctl_commands" "$current" ;;
        laser) _lumsdk_choose 'on off' "$current" ;;
        lines) _lumsdk_choose '640 64' "$current" ;;
        threshold | offset) _lumsdk_choose 'green blue' "$current" ;;
        apply) _lumsdk_files "$current" ;;
        esac
    elif [[ ${tool##*/} == lumdump* ]]; then
        if [[ udp:// == "$current"* && -n $current ]]; then
            COMPREPLY=(udp://)
            compopt -o nospace 2>/dev/null
        else
            _lumsdk_files "$current"
        fi
    fi
}

complete -F _lumsdk lumctl lumdump lumsim
