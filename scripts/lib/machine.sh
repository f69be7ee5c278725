# A Debian of this machine's release that boots, for scripts that test what needs one. Source it, set `work`
# (a folder that keeps what is downloaded) and call, as root: machine_can, machine_make, machine_boot,
# machine_run, machine_end. Who needs several sets `machine` and `machine_pid` to those of the one that is meant.

machine=$work/machine
machine_release=$(. /etc/os-release && echo "$VERSION_CODENAME")
machine_pid= # of systemd-nspawn

# Prints in one line what is missing; false when something is.
machine_can() {
  local tool
  [ "$(id -u)" -eq 0 ] || { echo "needs root"; return 1; }
  for tool in mmdebstrap systemd-nspawn nsenter; do
    command -v $tool > /dev/null || { echo "there is no $tool (scripts/setup --tests)"; return 1; }
  done
  unshare --mount --pid --net --ipc --uts --fork true 2> /dev/null || { echo "this kernel allows no namespaces"; return 1; }
}

# A fresh machine in $machine.
machine_make() {
  mkdir -p "$work/archives"
  if [ ! -e "$work/base.tar" ]; then
    mmdebstrap --quiet --variant=minbase --skip=cleanup/apt/lists \
      --include=systemd,systemd-sysv,iproute2 "$machine_release" "$work/base.part.tar" || return 1
    mv "$work/base.part.tar" "$work/base.tar"
  fi
  rm -rf "$machine"
  mkdir "$machine"
  tar -C "$machine" -xf "$work/base.tar"
  # Writing without fsync is faster, and the disk need not survive a power cut.
  echo force-unsafe-io > "$machine/etc/dpkg/dpkg.cfg.d/unsafe-io"
}

# machine_fetch PACKAGE_FILE...: downloads what these depend on, and writes its names, one a line, to
# $work/dependencies. The machine itself has no network.
machine_fetch() {
  mkdir -p "$machine/packages"
  cp "$@" "$machine/packages"
  unshare --mount bash -c '
    mount --bind "$2/archives" "$1/var/cache/apt/archives"
    cp -L /etc/resolv.conf "$1/etc/resolv.conf"
    apt() { chroot "$1" apt-get -qq -o APT::Sandbox::User=root --no-install-recommends "${@:2}"; }
    apt "$1" -s install $(cd "$1" && echo ./packages/*.deb) | sed -n "s/^Inst \([^ ]*\).*/\1/p" | sort > "$2/all"
    apt "$1" -y --download-only install $(cd "$1" && echo ./packages/*.deb) > /dev/null
    rm "$1/etc/resolv.conf"' bash "$machine" "$work" || return 1
  for file in "$@"; do dpkg-deb --field "$file" Package; done | sort > "$work/ours"
  comm -23 "$work/all" "$work/ours" > "$work/dependencies"
}

# machine_boot FOLDER: boots it, without network, with FOLDER as /test; waits until it is up.
machine_boot() {
  echo "${machine##*/}" > "$machine/etc/hostname"
  machine_test=$1
  systemd-nspawn --quiet --boot --directory="$machine" --private-network --register=no --keep-unit \
    --bind-ro="$1:/test" --bind="$work/archives:/var/cache/apt/archives" \
    > "$machine.console" 2>&1 < /dev/null &
  machine_pid=$!
  machine_wait
}

machine_wait() {
  local try
  for try in $(seq 300); do
    kill -0 $machine_pid 2> /dev/null || { tail -n 5 "$machine.console"; return 1; }
    case "$(machine_run systemctl is-system-running 2> /dev/null)" in
      running | degraded) return 0 ;;
    esac
    sleep 0.2
  done
  echo "the machine is not up after a minute"
  return 1
}

# Process id of the machine's first process.
machine_init() {
  local children
  children=$(cat "/proc/$machine_pid/task/$machine_pid/children" 2> /dev/null) || return 1
  [ -n "$children" ] && echo "${children%% *}"
}

# machine_run COMMAND...: in the machine, as root.
machine_run() {
  local init
  init=$(machine_init) || return 1
  nsenter --target "$init" --all env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 \
    DEBIAN_FRONTEND=noninteractive "$@"
}

# Systemd-nspawn ends when a machine that it keeps in this unit starts again, so it is started again.
machine_reboot() {
  machine_run systemctl reboot
  wait $machine_pid || true
  machine_boot "$machine_test"
}

machine_stop() {
  [ -n "$machine_pid" ] || return 0
  machine_run systemctl poweroff 2> /dev/null || true
  ( sleep 20; kill -KILL $machine_pid ) 2> /dev/null &
  wait $machine_pid 2> /dev/null || true
  kill $! 2> /dev/null || true
  machine_pid=
}

machine_end() {
  machine_stop
  rm -rf "$machine" "$machine.console"
}
