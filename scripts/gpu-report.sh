#!/usr/bin/env bash
# Measures on a machine with a GPU what was built on another, and prints a report in Markdown.
#
#   scripts/gpu-report.sh prepare [MODELS]   builds and packs everything into gpu-report/ (less than 64 MiB)
#   scripts/gpu-report.sh run [OUT]          unpacks and measures; the report is OUT/report.md. Needs xz, libvulkan.so.1
#                                            and a driver, and no toolchain; takes 8 minutes at most
#
# `prepare` takes scenes that are not in the repository from MODELS (default: ANTUMBRA_MODELS), and draws the shots on the
# device of this machine; `run` compares its own pictures with those.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
packed=gpu-report
scenes="interior.glb dungeon_A.glb town_A.glb"
shots=$(cd examples/shots && ls ./*.json | grep -v schema)

prepare() {
    local models=${1:-${ANTUMBRA_MODELS:-assets/models}} bin=$packed/bin scene shot
    rm -rf "$packed" && mkdir -p "$bin" "$packed/models" "$packed/here"
    local options="--release --features bevy,gltf,reference,profile --config profile.release.strip=true --config profile.release.debug=false"
    # shellcheck disable=SC2086
    cargo build $options --example render --example bevy_compare
    cp target/release/examples/{render,bevy_compare} "$bin"
    local bench
    # shellcheck disable=SC2086
    bench=$(cargo build $options --bench techniques --message-format json | sed -n 's/.*"executable":"\([^"]*techniques[^"]*\)".*/\1/p' | tail -1)
    cp "$bench" "$bin/techniques"
    for scene in $scenes; do
        find "$models" assets/models -name "$scene" -exec cp {} "$packed/models/" \; -quit
    done
    for shot in $shots; do
        "$bin/render" "examples/shots/$shot" --out "$packed/here/$(basename "$shot" .json)" >/dev/null
    done
    find "$packed/here" -type f ! -name image.png -delete
    tar -C "$packed" -cJf "$packed/bin.tar.xz" bin && rm -r "$bin"
    du -sh "$packed"
    if [ "$(du -sm "$packed" | cut -f1)" -ge 64 ]; then
        echo "gpu-report: $packed is larger than 64 MiB" >&2
        exit 1
    fi
}

# Prints what a command says as a block, and goes on if it fails or takes too long.
block() {
    local limit=$1
    shift
    printf '```\n'
    timeout -k 5 "$limit" "$@" 2>&1 || printf '(ended with %s)\n' "$?"
    printf '```\n\n'
}

run() {
    local out=${1:-out/gpu-report} bin shot
    mkdir -p "$out"
    tar -C "$packed" -xJf "$packed/bin.tar.xz"
    bin=$packed/bin
    {
        printf '# Frames at 1920×1080, by technique\n\n'
        local scene
        for scene in $scenes; do
            block 110 "$bin/techniques" --size 1920x1080 --repetitions 3 --models "$packed/models" "$scene"
        done
        printf '# Bevy'"'"'s maps beside ours\n\n'
        block 90 "$bin/bevy_compare" --headless --scene "$packed/models/interior.glb" --out "$out/bevy_compare" --size 1920x1080 \
            --lights 1,9,64 --frames 9
        printf '# Pictures beside those of the other device\n\n```\n'
        local name option
        for shot in $shots; do
            name=$(basename "$shot" .json)
            for option in --baseline ""; do
                # shellcheck disable=SC2086
                timeout 20 "$bin/render" "examples/shots/$shot" --out "$out/shots/$name" --against "$packed/here/$name" $option 2>&1 ||
                    printf '%s: ended with %s\n' "$name" "$?"
            done
        done
        printf '```\n\n# Milliseconds of the passes of these first frames\n\n```\n'
        for shot in $shots; do
            printf '%s\n' "$shot"
            sed -n '/"[cg]pu_ms"/,/}/p' "$out/shots/$(basename "$shot" .json)/stats.json"
        done
        printf '```\n'
    } >"$out/report.md"
    cat "$out/report.md"
    # An error of wgpu ends a program with a panic.
    ! grep -nE 'panicked at|ended with|not below' "$out/report.md"
}

case "${1:-}" in
prepare | run) "$@" ;;
*)
    sed -n '2,10s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
    exit 2
    ;;
esac
