#!/bin/sh
# Build the Debian package of this checkout, for this release of Debian and this processor, into DIR (default: dist).
#   sh docs/deploy/build-deb.sh [DIR]
# WHEELS names a folder of wheels to install from, instead of fetching them; EXTRAS the extras.
set -eu
source=$(cd "$(dirname "$0")/../.." && pwd)
out=${1:-$source/dist}
for tool in dpkg-buildpackage dh; do
  type "$tool" >/dev/null 2>&1 || { echo "$tool is missing; type: sudo apt-get install build-essential debhelper python3-venv"; exit 2; }
done
[ -f "$source/docs/deploy/debian/control" ] || { echo "expected a checkout around $0, got none"; exit 2; }

mkdir -p "$out"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
tree=$work/ross-payload
mkdir "$tree"
tar -C "$source" --exclude=__pycache__ --exclude=_build -c pyproject.toml README.md LICENSE CHANGELOG.md requirements-hashed.txt \
  ross_payload protocols sim docs | tar -C "$tree" -x
cp -r "$source/docs/deploy/debian" "$tree/debian"
cp "$source/docs/examples/ross.service" "$tree/debian/ross-payload.ross.service"

version=$(sed -n 's/^__version__ = "\(.*\)"/\1/p' "$source/ross_payload/__init__.py" | sed -E 's/(a|b|rc|\.dev)/~\1/')
release=$(. /etc/os-release && echo "$VERSION_ID")
: "${SOURCE_DATE_EPOCH:=$(git -C "$source" log -1 --format=%ct 2>/dev/null || date +%s)}"
export SOURCE_DATE_EPOCH
cat > "$tree/debian/changelog" <<END
ross-payload ($version+deb$release) stable; urgency=medium

  * /usr/share/doc/ross-payload/changelog.gz tells what has changed.

 -- The RoSS payload authors <noreply@ross-payload.invalid>  $(date -u -R -d "@$SOURCE_DATE_EPOCH")
END

(cd "$tree" && dpkg-buildpackage --build=binary --unsigned-changes --unsigned-buildinfo)
cp "$work"/ross-payload_*.deb "$out"
cd "$out"
if [ -f SHA256SUMS ]; then  # of `make release`
  { sed '/  ross-payload_.*\.deb$/d' SHA256SUMS; sha256sum ross-payload_*.deb; } > SHA256SUMS.new
  mv SHA256SUMS.new SHA256SUMS
fi
ls "$PWD"/ross-payload_*.deb
