#!/bin/sh
# Fill DIR with the files of Debian that a payload in /opt/ross needs: Python, PortAudio and what these need; no shell, no apt.
#   sh docs/deploy/rootfs.sh DIR      in Debian 12, after `apt-get update`, as root
set -eu
root=$1
packages="base-files media-types netbase libc6 libc-bin libcrypt1 libgcc-s1 libstdc++6 zlib1g libexpat1 libssl3 libffi8 libbz2-1.0
  liblzma5 libuuid1 libsqlite3-0 libtinfo6 libncursesw6 libreadline8 python3.11-minimal libpython3.11-minimal libpython3.11-stdlib
  libportaudio2 libasound2 libasound2-data libjack-jackd2-0 libdb5.3 libopus0 libsamplerate0"

mkdir -p "$root/var/lib/dpkg/status.d" "$root/tmp" "$root/run" "$root/proc" "$root/sys" "$root/dev" "$root/etc/ross"
work=$(mktemp -d)
(cd "$work" && apt-get -qq -o APT::Sandbox::User=root download $packages)
for deb in "$work"/*.deb; do
  dpkg-deb --extract "$deb" "$root"
  name=$(dpkg-deb --field "$deb" Package)
  dpkg-deb --field "$deb" > "$root/var/lib/dpkg/status.d/$name" # scanners of images read what is installed there
done
rm -rf "$work"
# Licences stay (usr/share/doc/*/copyright).
find "$root/usr/share/doc" -type f ! -name copyright -delete
rm -rf "$root/usr/share/man" "$root/usr/share/info" "$root/usr/share/lintian" "$root/usr/share/gcc" "$root/usr/share/gdb" \
  "$root"/usr/lib/*/gconv "$root/usr/lib/python3.11/lib2to3" "$root/usr/lib/python3.11/pydoc_data/topics.py"

ln -sf python3.11 "$root/usr/bin/python3"
cat > "$root/etc/passwd" <<END
root:x:0:0:root:/root:/usr/sbin/nologin
ross:x:10001:10001:RoSS payload:/state:/usr/sbin/nologin
END
# The groups of sound cards and serial ports have these numbers in Debian and Raspberry Pi OS; others need --group-add.
cat > "$root/etc/group" <<END
root:x:0:
dialout:x:20:ross
audio:x:29:ross
ross:x:10001:
END
echo "hosts: files dns" > "$root/etc/nsswitch.conf"
ldconfig -r "$root"
chmod 1777 "$root/tmp"
install -d -o 10001 -g 10001 -m 0700 "$root/state"
