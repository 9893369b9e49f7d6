# To be sourced with packages of PyPI in `peer`: sets `venv` to a Python that has them, in a scratch
# folder `scratch`, which goes when the script ends. Where they cannot be had, says so and ends the
# script well. PEER_VENV may name a folder that keeps them.
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
venv="${PEER_VENV:-$scratch/venv}"
if ! { [ -x "$venv/bin/python" ] || python3 -m venv "$venv"
    "$venv/bin/pip" install -q $peer; } > "$scratch/pip.log" 2>&1; then
  echo "$(basename "$0"): skipped, PyPI has no $peer: $(tail -n 1 "$scratch/pip.log")"
  exit 0
fi
