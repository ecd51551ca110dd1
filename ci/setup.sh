#!/usr/bin/env bash
# SPDX-License-Identifier: MIT OR Apache-2.0
#
# Makes this machine able to build terrafill and to run it: a C compiler, a Vulkan driver, and for
# tests the validation layer, the tools that check geometry shaders, curl, and cargo-nextest. Installs
# only what is missing, and touches no driver where a Vulkan device works already. Says nothing when
# there is nothing to do, except, in the last line, which device was found.
#
# usage: ci/setup.sh [--for bench|test]
# shellcheck disable=SC2016 # apt expands $(SITE), not the shell
set -euo pipefail
cd "$(dirname "$0")/.."

purpose="test"
case "$#:${1:-}:${2:-}" in
    0::) ;;
    2:--for:bench | 2:--for:test) purpose=$2 ;;
    *)
        echo "usage: ci/setup.sh [--for bench|test]" >&2
        exit 2
        ;;
esac

note() { echo "setup: $*"; }
fail() {
    echo "setup: $*" >&2
    exit 1
}

# --- Rust ------------------------------------------------------------------------------------

command -v cargo >/dev/null ||
    fail "cargo is missing: install Rust with rustup (https://rustup.rs), then run this again"
wanted=$(sed -n 's/^rust-version = "\(.*\)"/\1/p' Cargo.toml)
found=$(rustc --version | sed 's/^rustc \([0-9.]*\).*/\1/')
if [ "$(printf '%s\n%s\n' "$wanted" "$found" | sort -V | sed -n 1p)" != "$wanted" ]; then
    fail "Rust $found found, $wanted or newer needed: rustup update stable"
fi

# --- what is there ---------------------------------------------------------------------------

# Name of the first Vulkan device, or nothing. Without vulkaninfo a loader and a driver's manifest
# have to do as evidence.
device() {
    if command -v vulkaninfo >/dev/null; then
        { vulkaninfo --summary 2>/dev/null || true; } |
            sed -n 's/^[[:space:]]*deviceName[[:space:]]*=[[:space:]]*//p' | sed -n 1p
    elif has_loader && has_manifest icd.d '*.json'; then
        echo "a driver is installed (vulkaninfo, which would name its device, is not)"
    fi
}

has_loader() {
    local cache
    cache=$({ ldconfig -p || /sbin/ldconfig -p || true; } 2>/dev/null)
    [[ $cache == *libvulkan.so.1* ]]
}

# Whether a file of this pattern lies where the loader looks for manifests.
has_manifest() {
    local folder
    for folder in /usr/share/vulkan /usr/local/share/vulkan /etc/vulkan "$HOME/.local/share/vulkan"; do
        if compgen -G "$folder/$1/$2" >/dev/null; then
            return 0
        fi
    done
    return 1
}

# --- apt -------------------------------------------------------------------------------------

as_root() {
    if [ "$(id -u)" -eq 0 ]; then
        "$@"
    elif command -v sudo >/dev/null; then
        sudo "$@"
    else
        fail "root is needed for: $* (no sudo here)"
    fi
}

apt_get() { as_root env DEBIAN_FRONTEND=noninteractive apt-get -qq -o Dpkg::Use-Pty=0 "$@" >/dev/null; }

updated=no
apt_install() {
    if [ "$updated" = no ]; then
        apt_get update
        updated=yes
    fi
    note "installing $*"
    apt_get install -y --no-install-recommends "$@"
}

# Mesa of Debian 12 is 22.3, without mesh shaders; that of its backports has them. The mirror is
# the one that this machine already uses.
enable_backports() {
    local list=/etc/apt/sources.list.d/terrafill-backports.list
    local keyring=/usr/share/keyrings/debian-archive-keyring.gpg
    local site
    if [ -n "$(apt-get indextargets --format '$(SITE)' 'Codename: bookworm-backports')" ]; then
        return 0
    fi
    site=$(apt-get indextargets --format '$(SITE)' 'Codename: bookworm' 'Component: main' | sort -u | sed -n 1p)
    if [ -z "$site" ] || [ ! -e "$keyring" ]; then
        return 1
    fi
    echo "deb [signed-by=$keyring] $site bookworm-backports main" | as_root tee "$list" >/dev/null
    if ! apt_get update; then
        as_root rm -f "$list"
        apt_get update || true
        return 1
    fi
}

install_driver() {
    apt_install libvulkan1 vulkan-tools
    if [ "$distribution" = "debian 12" ]; then
        if enable_backports && {
            note "installing mesa-vulkan-drivers from bookworm-backports"
            apt_get install -y --no-install-recommends -t bookworm-backports mesa-vulkan-drivers
        }; then
            return 0
        fi
        note "bookworm-backports cannot be used; the older Mesa of bookworm has no mesh shaders"
    fi
    apt_install mesa-vulkan-drivers
}

# shellcheck source=/dev/null
distribution=$(. /etc/os-release 2>/dev/null && echo "${ID:-} ${VERSION_ID:-}" || true)
require_apt() {
    case "$distribution" in
        debian\ * | ubuntu\ *) command -v apt-get >/dev/null && return 0 ;;
    esac
    fail "$1 is missing, and this script can install it only on Debian and Ubuntu: install $2"
}

# --- install what is missing -----------------------------------------------------------------

if ! command -v cc >/dev/null; then
    require_apt "a C compiler" "a C compiler and pkg-config"
    apt_install build-essential pkg-config
fi
if [ -z "$(device)" ]; then
    require_apt "a Vulkan device" "a Vulkan driver, such as Mesa's lavapipe, and vulkan-tools"
    install_driver
fi
if [ "$purpose" = test ]; then
    if ! has_manifest explicit_layer.d 'VkLayer_khronos_validation*.json'; then
        require_apt "the Vulkan validation layer" "VK_LAYER_KHRONOS_validation"
        apt_install vulkan-validationlayers
    fi
    if ! command -v curl >/dev/null; then
        require_apt "curl, which \`terrafill data get\` fetches with," "curl"
        apt_install curl ca-certificates
    fi
    # Wanted, not needed: what they check is checked in, and check-shaders names what is missing.
    if ! command -v glslangValidator >/dev/null || ! command -v spirv-val >/dev/null; then
        case "$distribution" in
            debian\ * | ubuntu\ *)
                apt_install glslang-tools spirv-tools || note "without glslang-tools, spirv-tools"
                ;;
            *) note "no glslangValidator or no spirv-val: geometry shaders are not compiled again" ;;
        esac
    fi
    if ! cargo nextest --version >/dev/null 2>&1; then
        note "building cargo-nextest, which runs each test in a process of its own with a time limit"
        cargo install --quiet --locked cargo-nextest
    fi
fi

name=$(device)
[ -n "$name" ] || fail "no Vulkan device works, although a driver is installed: see vulkaninfo"
note "Vulkan device: $name"
