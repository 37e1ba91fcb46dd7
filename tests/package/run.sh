#!/usr/bin/env bash
# The Debian package installs into a clean root and works there. As root, with debootstrap and the network; takes minutes:
# part of .ci/run, not of ctest. Ends with 77 (skipped) where that is not to be had.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
if ((EUID != 0)) || ! command -v debootstrap >/dev/null; then
  echo "SKIPPED: needs root and debootstrap"
  exit 77
fi
root=$(mktemp -d)
if ! mount -t proc proc "$root" 2>/dev/null; then # a container that may not
  rmdir "$root"
  echo "SKIPPED: nothing can be mounted here"
  exit 77
fi
umount "$root"
packaging/package -DTYNDALL_WERROR=ON  # as .ci/run builds, whose objects ccache has
trap 'umount "$root/proc" 2>/dev/null || true; rm -rf "$root"' EXIT
debootstrap --variant=minbase bookworm "$root" >"$root.log" 2>&1 || { tail "$root.log"; exit 1; }
rm "$root.log"
mount -t proc proc "$root/proc"
cp build/package/tyndall_*.deb "$root/tmp/tyndall.deb"
in_root() { chroot "$root" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive "$@"; }
in_root apt-get install -y --no-install-recommends /tmp/tyndall.deb >"$root/tmp/log" 2>&1 || { tail "$root/tmp/log"; exit 1; }
in_root tyndall --version
in_root tyndall render /usr/share/tyndall/scenes/lonely_cloud.json --photons 20000 --samples 2 --print-hash \
  -o /tmp/x.exr -o /tmp/x.png >"$root/tmp/hash"
diff tests/golden/lonely_cloud.hash "$root/tmp/hash"
in_root tyndall bake /usr/share/tyndall/scenes/lonely_cloud.json --photons 20000 -o /tmp/x.vdb # by the helper
for file in /tmp/x.exr /tmp/x.png /tmp/x.vdb /usr/share/man/man1/tyndall.1.gz \
  /usr/share/bash-completion/completions/tyndall /usr/share/zsh/site-functions/_tyndall; do
  [[ -s $root$file || -s $root${file%.gz} ]] || { echo "$file is missing"; exit 1; }
done
in_root apt-get remove -y tyndall >/dev/null
[[ ! -e $root/usr/bin/tyndall ]]
echo "the package installs, works and goes"
