#!/usr/bin/env bash
# Makes sure that wgpu finds a Vulkan adapter on Linux; installs Mesa's software driver (lavapipe) if there is none.
# Says what it does. Exit status 0: there is an adapter; 1: there is none, and why.
set -euo pipefail

say() { printf 'vulkan: %s\n' "$*"; }
fail() {
    printf 'vulkan: %s\n' "$*" >&2
    exit 1
}

case "$(uname -s)" in
Linux) ;;
Darwin)
    say "macOS draws with Metal, nothing to install"
    exit 0
    ;;
*)
    say "$(uname -s): wgpu takes the system's own driver, nothing to install"
    exit 0
    ;;
esac

has_loader() {
    local ldconfig listed folder
    ldconfig="$(PATH="$PATH:/sbin:/usr/sbin" command -v ldconfig || true)"
    if [ -n "$ldconfig" ]; then
        listed="$("$ldconfig" -p 2>/dev/null || true)"
        case "$listed" in *libvulkan.so.1*) return 0 ;; esac
    fi
    for folder in /lib /lib64 /usr/lib /usr/lib64 /usr/local/lib /lib/*-linux-gnu /usr/lib/*-linux-gnu \
        ${LD_LIBRARY_PATH:+${LD_LIBRARY_PATH//:/ }}; do
        if [ -e "$folder/libvulkan.so.1" ]; then return 0; fi
    done
    return 1
}

# A driver's manifest, and for a hardware driver a device too: distributions install all of Mesa's manifests at once.
has_driver() {
    local manifest device
    if [ -n "${VK_DRIVER_FILES:-}${VK_ICD_FILENAMES:-}" ]; then return 0; fi
    for manifest in /usr/share/vulkan/icd.d/*.json /usr/local/share/vulkan/icd.d/*.json /etc/vulkan/icd.d/*.json \
        "${XDG_DATA_HOME:-${HOME:-/root}/.local/share}"/vulkan/icd.d/*.json; do
        if [ ! -e "$manifest" ]; then continue; fi
        case "$manifest" in */lvp_* | */swiftshader* | */vk_swiftshader*) return 0 ;; esac
        for device in /dev/dri/renderD* /dev/nvidia0 /dev/dxg; do
            if [ -e "$device" ]; then return 0; fi
        done
    done
    return 1
}

has_adapter() {
    local listed
    if command -v vulkaninfo >/dev/null 2>&1; then
        listed="$(vulkaninfo --summary 2>/dev/null || true)"
        case "$listed" in *deviceName*) return 0 ;; *) return 1 ;; esac
    fi
    has_loader && has_driver
}

if has_adapter; then
    say "an adapter is there"
    exit 0
fi

as_root=()
if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null 2>&1 ||
        fail "no adapter, and neither root nor sudo to install one. Install Mesa's Vulkan drivers and the Vulkan loader."
    as_root=(sudo)
fi

if command -v apt-get >/dev/null 2>&1; then
    say "no adapter; installing Mesa's software driver: apt-get install libvulkan1 mesa-vulkan-drivers"
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get update -qq ||
        say "apt-get update failed, trying with the lists that are there"
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
        apt-get install -y -qq --no-install-recommends libvulkan1 mesa-vulkan-drivers ||
        fail "apt-get could not install them"
elif command -v dnf >/dev/null 2>&1; then
    say "no adapter; installing Mesa's software driver: dnf install vulkan-loader mesa-vulkan-drivers"
    "${as_root[@]}" dnf install -y -q vulkan-loader mesa-vulkan-drivers || fail "dnf could not install them"
elif command -v pacman >/dev/null 2>&1; then
    say "no adapter; installing Mesa's software driver: pacman -S vulkan-icd-loader vulkan-swrast"
    "${as_root[@]}" pacman -S --noconfirm --needed vulkan-icd-loader vulkan-swrast || fail "pacman could not install them"
else
    fail "no adapter, and no package manager that this script knows (apt-get, dnf, pacman)." \
        "Install Mesa's lavapipe and the Vulkan loader (libvulkan.so.1)."
fi

has_adapter || fail "installed, and still no adapter: look at VK_LOADER_DEBUG=all vulkaninfo"
say "an adapter is there now"
