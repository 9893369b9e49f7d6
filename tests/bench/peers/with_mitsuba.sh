# To be sourced: sets `venv` to a Python with Mitsuba 3 from PyPI in a scratch folder `scratch`,
# which goes when the script ends. Where Mitsuba cannot be had, says so and ends the script well.
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
venv="$scratch/venv"
if ! { python3 -m venv "$venv" && "$venv/bin/pip" install -q mitsuba numpy; } \
  > "$scratch/pip.log" 2>&1; then
  echo "$(basename "$0"): skipped, no Mitsuba from PyPI: $(tail -n 1 "$scratch/pip.log")"
  exit 0
fi
