#!/usr/bin/env bash
# Measures on a machine with a GPU what was built on another, and prints a report in Markdown.
#
#   scripts/gpu-report.sh prepare [MODELS]   builds and packs everything into gpu-report/ (less than 64 MiB)
#   scripts/gpu-report.sh run [OUT]          unpacks and measures; the report is OUT/report.md. Needs no toolchain
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
}

# Prints what a command says as a block, and goes on if it fails or takes too long.
block() {
    local limit=$1
    shift
    printf '```\n'
    timeout "$limit" "$@" 2>&1 || printf '(ended with %s)\n' "$?"
    printf '```\n\n'
}

run() {
    local out=${1:-out/gpu-report} bin shot
    mkdir -p "$out"
    tar -C "$packed" -xJf "$packed/bin.tar.xz"
    bin=$packed/bin
    {
        printf '# Frames at 1920×1080, by technique\n\n'
        block 240 "$bin/techniques" --size 1920x1080 --models "$packed/models"
        printf '# Bevy'"'"'s maps beside ours\n\n'
        block 90 "$bin/bevy_compare" --headless --out "$out/bevy_compare" --size 1920x1080
        printf '# Pictures beside those of the other device\n\n```\n'
        for shot in $shots; do
            local name
            name=$(basename "$shot" .json)
            timeout 20 "$bin/render" "examples/shots/$shot" --out "$out/shots/$name" --against "$packed/here/$name" 2>&1 ||
                printf '%s: ended with %s\n' "$name" "$?"
        done
        printf '```\n\n# Messages of validation\n\n```\n'
        grep -ciE 'validation|VUID' "$out/report.md" || true
        printf '```\n'
    } >"$out/report.md"
    cat "$out/report.md"
}

case "${1:-}" in
prepare | run) "$@" ;;
*)
    sed -n '2,9s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
    exit 2
    ;;
esac
