#!/usr/bin/env bash
# Makes sure that there is a Chromium with which the test of the gallery's page opens it; on Linux installs one if there is
# none. Prints what it does. Exit status 0: there is one; 1: there is none, and why.
set -euo pipefail

say() { printf 'chromium: %s\n' "$*"; }
fail() {
    printf 'chromium: %s\n' "$*" >&2
    exit 1
}

# The same names in the same order as in tests/gallery_page/browser.rs.
has_browser() {
    local name
    if [ -n "${ANTUMBRA_CHROMIUM:-}" ]; then
        [ -x "$ANTUMBRA_CHROMIUM" ] || fail "ANTUMBRA_CHROMIUM is $ANTUMBRA_CHROMIUM, which is no program"
        return 0
    fi
    for name in chromium-headless-shell chromium chromium-browser google-chrome google-chrome-stable; do
        if command -v "$name" >/dev/null 2>&1; then return 0; fi
    done
    [ -x "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome" ]
}

if has_browser; then
    say "a browser is there"
    exit 0
fi
[ "$(uname -s)" = Linux ] || fail "there is none; install Chromium or Chrome, or name one in ANTUMBRA_CHROMIUM"

as_root=()
if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null 2>&1 ||
        fail "there is none, and neither root nor sudo to install it; name one in ANTUMBRA_CHROMIUM"
    as_root=(sudo)
fi

if command -v apt-get >/dev/null 2>&1; then
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get update -qq ||
        say "apt-get update failed, trying with the lists that are there"
    # Debian packages the part without a window by itself; it is smaller and starts faster.
    package=chromium
    if [ -n "$(apt-cache --names-only search '^chromium-headless-shell$')" ]; then package=chromium-headless-shell; fi
    say "there is none; installing it: apt-get install $package"
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
        apt-get install -y -qq --no-install-recommends "$package" >/dev/null || fail "apt-get could not install $package"
elif command -v dnf >/dev/null 2>&1; then
    say "there is none; installing it: dnf install chromium"
    "${as_root[@]}" dnf install -y -q chromium || fail "dnf could not install it"
elif command -v pacman >/dev/null 2>&1; then
    say "there is none; installing it: pacman -S chromium"
    "${as_root[@]}" pacman -S --noconfirm --needed chromium || fail "pacman could not install it"
else
    fail "there is none, and no package manager that this script knows (apt-get, dnf, pacman); install Chromium"
fi

has_browser || fail "installed, and still not found"
say "a browser is there now"
