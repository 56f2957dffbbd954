# SPDX-License-Identifier: GPL-3.0-or-later
# Debian releases in folders (debootstrap + chroot), kept in a cache outside the repository. To be sourced by bash.
#
# Needs root, debootstrap and a Debian mirror: that of this machine's own apt. Mounts live in a mount namespace of each
# command, so that nothing stays mounted, whatever ends it. ROOT.lock is held by whoever works in ROOT (shared) or makes
# it (exclusive), so that none is thrown away under a running command.

cache=${PENUMBRA_CACHE:-${XDG_CACHE_HOME:-$HOME/.cache}/penumbra}
inside=/srv  # the home of whoever works in a chroot, with the sources that are tested there; kept when it is made anew
days_until_stale=14  # sid moves on: what is older is made anew

# The sentence why no chroot can be made here, or nothing.
why_no_chroot() {
  if [[ $EUID -ne 0 ]]; then
    echo "only root can make a chroot"
  elif ! command -v debootstrap >/dev/null; then
    echo "debootstrap is not installed"
  elif ! unshare --mount --pid --fork true 2>/dev/null; then
    echo "this machine allows no mount namespaces"
  fi
}

# The mirror that this machine's apt uses for Debian itself; nothing if that is unknown (then debootstrap's own choice).
debian_mirror() {
  apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' 'Label: Debian' 2>/dev/null | head -n 1
}

# enter ROOT COMMAND...: runs a command inside; of the environment only CI, proxies, pip's and ccache's settings go along.
enter() {
  local root=$1
  shift
  cp /etc/resolv.conf /etc/hosts "$root/etc/"
  if [[ -e /etc/ssl/certs/ca-certificates.crt ]]; then  # this machine's, which may know a proxy's certificate
    mkdir -p "$root/etc/ssl/certs"
    cp /etc/ssl/certs/ca-certificates.crt "$root/etc/ssl/certs/"
  fi
  local variables
  mapfile -t variables < <(
    env | grep -E '^(CI|CXXFLAGS|CMAKE_CXX_COMPILER_LAUNCHER|PIP_(CERT|DEFAULT_TIMEOUT|INDEX_URL)|[a-z]+_proxy|[A-Z]+_PROXY)='
  )
  flock --shared "$root.lock" unshare --mount --pid --fork --kill-child bash -c '
    mount -t proc proc "$0/proc" && mount --rbind /dev "$0/dev" && exec chroot "$0" "$@"' \
    "$root" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME="$inside" LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive \
    "${variables[@]}" "$@" </dev/null
}

# make_chroot SUITE ROOT: a new one, whole or not at all.
make_chroot() {
  local suite=$1 root=$2 new=$2.new
  rm -rf "$new"
  mkdir -p "$(dirname "$root")"
  debootstrap --variant=minbase --include=ca-certificates "$suite" "$new" $(debian_mirror) >"$new.log" 2>&1 || {
    tail -n 5 "$new.log"
    return 1
  }
  rm "$new.log"
  printf '#!/bin/sh\nexit 101\n' >"$new/usr/sbin/policy-rc.d"  # no service is started
  chmod +x "$new/usr/sbin/policy-rc.d"
  echo force-unsafe-io >"$new/etc/dpkg/dpkg.cfg.d/fast"  # what a crash leaves is made anew
  apt-config dump | grep -E '^Acquire::(https?|Check|Retries)' >"$new/etc/apt/apt.conf.d/01host" || true
  if [[ -d $root$inside ]]; then
    rm -rf "$new$inside"
    mv "$root$inside" "$new$inside"
  fi
  rm -rf "$root"
  mv "$new" "$root"
}

# ensure_chroot NAME SUITE: a whole and recent one at $cache/NAME, made by this recipe. One at a time for each NAME.
ensure_chroot() {
  local root=$cache/$1 recipe wait=
  recipe=$(declare -f make_chroot | sha256sum)
  if [[ -e $root/.penumbra && -z $(enter "$root" dpkg --audit 2>&1) ]]; then
    [[ "$(cat "$root/.penumbra")" != "$recipe" || -n $(find "$root/.penumbra" -mtime +$days_until_stale) ]] || return 0
    wait=--nonblock
  fi
  (
    flock --exclusive $wait 9 || {
      echo "== $1: older than $days_until_stale days or of another recipe, but someone works in it: taken as it is"
      exit 0
    }
    echo "== $1: making the environment in $root"
    if make_chroot "$2" "$root"; then
      echo "$recipe" >"$root/.penumbra"
    elif [[ -n $wait ]]; then
      echo "== $1: no other could be made, so the one that is there is taken"
    else
      exit 1
    fi
  ) 9>"$root.lock"
}

# install_packages ROOT PACKAGE...: those that are missing, NAME:arm64 for the other architecture. One at a time.
install_packages() {
  local root=$1 native installed missing
  shift
  native=$(dpkg --print-architecture)
  installed=$(enter "$root" dpkg-query --show --showformat '${Package}:${Architecture} ${db:Status-Status}\n' |
    sed -n "s/ installed$//; T; s/:\(all\|$native\)$//; p")
  missing=$(printf '%s\n' "$@" | grep -vxF "$installed") || return 0
  [[ $missing != *:arm64* ]] || enter "$root" dpkg --add-architecture arm64
  enter "$root" apt-get update -qq >"$root.log" 2>&1 || true  # what is missing is said below
  enter "$root" apt-get install --yes -qq --no-install-recommends $missing >>"$root.log" 2>&1 || {
    tail -n 5 "$root.log"
    return 1
  }
  rm "$root.log"
}

# copy_sources REPOSITORY FOLDER: what git would commit, and nothing else.
copy_sources() {
  rm -rf "$2"
  mkdir -p "$2"
  git -C "$1" ls-files -z --cached --others --exclude-standard --deduplicate |
    tar --create --directory="$1" --null --files-from=- | tar --extract --directory="$2"
}
