#!/usr/bin/env bash
# Installs Spall by pip into a fresh environment, as docs/python.md says, and draws a picture with it. Ten minutes on two
# cores, and seconds where build/python-* has been compiled before.
# usage: try_pip.sh
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/environment.sh"
tree=$PWD
HOME=$(mktemp -d)
trap 'rm -rf "$HOME"' EXIT
export HOME PATH="/usr/bin:$PATH" # the distribution's Python has NumPy and others
export PIP_NO_INDEX=1             # a download would be an error

python3 -m venv --system-site-packages ~/spall
~/spall/bin/pip install .

cd "$HOME" # away from python/spall of the tree
ln -s "$tree/cases" .
~/spall/bin/spall check cases/hello/case.toml
~/spall/bin/python -c 'import spall, sys; assert spall.__file__.startswith(sys.prefix), spall.__file__'
begin=$(date +%s%N)
~/spall/bin/python "$tree/docs/examples/picture.py"
milliseconds=$((($(date +%s%N) - begin) / 1000000))
[ -s pile.png ]
echo "five lines drew a picture in $milliseconds ms"
[ "$milliseconds" -lt 60000 ]
