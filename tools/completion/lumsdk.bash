# shellcheck shell=bash
# Completion of lumcal, lumctl, lumdump, lumfleet, lumodom, lumros2, lumsim, lumtable, lumview for bash. Options and the words they
# take are read from the tools' own --help, so this file does not have to know them.

# _lumsdk_options TOOL [COMMAND]
_lumsdk_options() {
    "$1" ${2:+"$2"} --help 2>/dev/null | sed '/^Usage: lumctl/,/^Options/d' | grep -oE -- '(^|[ ,])--[a-z][a-z-]*' | grep -oE -- '--[a-z-]+' | sort -u
}

# The words of "--option a|b|c" in the help, where a line that ends in | goes on.
_lumsdk_words() {
    "$1" --help 2>/dev/null | sed -e ':again' -e '/|$/ { N; s/\n *//; b again' -e '}' | sed -nE "s/.*$2 ([a-z0-9-]+(\|[A-Za-z0-9-]+)+).*/\1/p" | head -n 1 | tr '|' '\n'
}

_lumsdk_files() {
    compopt -o filenames 2>/dev/null
    mapfile -t COMPREPLY < <(compgen -f -- "$1")
}

_lumsdk_choose() {
    mapfile -t COMPREPLY < <(compgen -W "$1" -- "$2")
}

# As _lumsdk_choose, for words that go on: no space behind those that end in :
# or @.
_lumsdk_choose_open() {
    _lumsdk_choose "$1" "$2"
    case ${COMPREPLY[*]} in
    *[:@]) compopt -o nospace 2>/dev/null ;;
    esac
}

# Keys of calibrations and profiles, for --set.
_lumsdk_keys() {
    local keys=(
        speed_of_light tof_lsb_ps
        eyes.{blue,green}.{tof_offset_ps,azimuth.{center_deg,width_deg},elevation.{min_deg,max_deg}}
        eyes.{blue,green}.mount.{x_m,y_m,z_m,roll_deg,pitch_deg,yaw_deg}
        data_packet_type set_ip_order angle_order angle_lsb_deg line_span_us
        group.{tag,eye,line,num_samples,first_sample_index,timestamp}{,.at,.bytes} group.samples
        eye_values.{blue,green} tlv.{command,status,debug,yscan}
    )
    printf '%s=\n' "${keys[@]}"
}

_lumctl_commands() {
    "$1" --help 2>/dev/null | sed -nE 's/^  ([a-z][a-z-]*) .*/\1/p' | grep -vx 'lumctl' | sort -u
}

# What its help says may follow a command: "on|off", "FILE", "[a|b|c]".
_lumctl_takes() {
    "$1" "$2" --help 2>/dev/null | sed -nE "s/^Usage: lumctl \[OPTION\]\.\.\. $2 \[?([^] ]*).*/\1/p"
}

# What is open behind a command: its own options, and its words once.
_lumctl_words() {
    local tool=$1 current=$2 commands word command='' behind=0 takes=''
    commands=" $(_lumctl_commands "$tool" | tr '\n' ' ') "
    for word in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do
        if [ -n "$command" ]; then
            behind=$((behind + 1))
        elif [[ $commands == *" $word "* ]]; then
            command=$word
        fi
    done
    if [[ $current == -* ]]; then
        _lumsdk_choose "$(_lumsdk_options "$tool" ${command:+"$command"})" "$current"
        return
    fi
    case $command:$behind in
    :* | help:0)
        _lumsdk_choose "$commands" "$current"
        return
        ;;
    *:0) takes=$(_lumctl_takes "$tool" "$command") ;;
    esac
    case $takes in
    FILE | PLAN) _lumsdk_files "$current" ;;
    *[A-Z]*) ;;
    *'|'*) _lumsdk_choose "${takes//|/ }" "$current" ;;
    esac
}

_lumsdk() {
    local tool=$1 current=$2 previous=$3 words
    # bash splits words at colons
    if [[ ${COMP_WORDS[*]} == *'--shape csv :'* && $previous == [:v]* ]]; then
        _lumsdk_files "${current#:}"
        return
    fi
    if [[ ${tool##*/} == lumctl* && $previous == @(-o|--output) ]]; then
        compopt -o filenames 2>/dev/null
        mapfile -t COMPREPLY < <(compgen -d -- "$current")
        return
    fi
    case $previous in
    --out | --output | -o | --calibration | --profile | --rig | --log | --report | --truth | --poses | --pose-times | --labels | --replay | --csv | --prometheus)
        _lumsdk_files "$current"
        return
        ;;
    --set)
        compopt -o nospace 2>/dev/null
        _lumsdk_choose "$(_lumsdk_keys)" "$current"
        return
        ;;
    --interface)
        words=$(ls /sys/class/net 2>/dev/null)
        _lumsdk_choose "$words" "$current"
        return
        ;;
    --columns)
        words='x y z range azimuth elevation pulse_width timestamp frame eye line pixel return_number number_of_returns edge time sensor'
        compopt -o nospace 2>/dev/null
        mapfile -t COMPREPLY < <(compgen -P "${current%"${current##*,}"}" -W "$words" -- "${current##*,}")
        return
        ;;
    --shape)
        _lumsdk_choose_open 'uniform gaussian: regions: csv:' "$current"
        return
        ;;
    --fault)
        words='galvo-bx@ galvo-by@ galvo-gx@ galvo-gy@ board@ fan@ interlock@ switch@ silence@ reboot@'
        _lumsdk_choose_open "$words" "$current"
        return
        ;;
    --*)
        words=$(_lumsdk_words "$tool" "${previous/check-preset/preset}")
        if [ -n "$words" ]; then
            _lumsdk_choose "$words" "$current"
            return
        fi
        ;;
    esac
    if [[ ${tool##*/} == lumctl* ]]; then
        _lumctl_words "$tool" "$current"
    elif [[ $current == -* ]]; then
        if [[ ${tool##*/} != lumcal ]]; then
            _lumsdk_choose "$(_lumsdk_options "$tool")" "$current"
        elif ((COMP_CWORD == 1)); then
            _lumsdk_choose '--help --version' "$current"
        else
            _lumsdk_choose "$(_lumsdk_options "$tool" "${COMP_WORDS[1]}")" "$current"
        fi
    elif [[ ${tool##*/} == @(lumdump|lumview)* ]]; then
        if [[ udp:// == "$current"* && -n $current ]]; then
            COMPREPLY=(udp://)
            compopt -o nospace 2>/dev/null
        else
            _lumsdk_files "$current"
        fi
    elif [[ ${tool##*/}:$COMP_CWORD == lumcal:1 ]]; then
        _lumsdk_choose 'eyes check' "$current"
    elif [[ ${tool##*/} == @(lumcal|lumfleet|lumodom|lumros2) ]]; then
        _lumsdk_files "$current"
    fi
}

complete -F _lumsdk lumcal lumctl lumdump lumfleet lumodom lumros2 lumsim lumtable lumview
