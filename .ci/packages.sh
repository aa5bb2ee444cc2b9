# Sourced by the scripts beside it.

# Installs packages of the distribution, as root or with sudo.
install_packages() {
    local as_root=()
    [ $# != 0 ] || return 0
    if ! command -v apt-get >/dev/null; then
        echo "error: $* missing, and there is no apt-get to install it" >&2
        return 1
    fi
    if [ "$(id -u)" != 0 ]; then
        sudo -n true || { echo "error: $* missing: install it, or let sudo work without a password" >&2; return 1; }
        as_root=(sudo -n)
    fi
    "${as_root[@]}" apt-get update -qq
    "${as_root[@]}" apt-get install -y -qq --no-install-recommends "$@"
}
