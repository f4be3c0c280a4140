#!/bin/sh
# What the tests need of Debian: as root, install what is missing; otherwise print the one line to type.
missing=
command() { type "$1" >/dev/null 2>&1 || { shift; missing="$missing $*"; }; }
package() { dpkg -s "$1" >/dev/null 2>&1 || missing="$missing $1"; }

command make make
command git git
command python3 python3 python3-venv
command gcc gcc linux-libc-dev libc6-dev
command systemd-analyze systemd
command openssl openssl
command curl curl
browser=$CHROMIUM
for each in chromium chromium-browser; do type $each >/dev/null 2>&1 && browser=$each; done
[ -n "$browser" ] || command chromium-headless-shell chromium-headless-shell fonts-dejavu-core
command tshark tshark
command pulseaudio pulseaudio
command ps procps
command ffmpeg ffmpeg
command gst-launch-1.0 gstreamer1.0-tools gstreamer1.0-plugins-base gstreamer1.0-plugins-good
package libportaudio2
package libasound2-plugins

[ -n "$missing" ] || exit 0
if [ "$(id -u)" = 0 ] && type apt-get >/dev/null 2>&1; then
  apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq $missing && exit 0
fi
echo "Tests are skipped for want of Debian packages. Type: sudo apt-get install$missing"
exit 1
