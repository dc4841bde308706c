# Shared by the cases: furrow, source, out (an empty folder); expect_exit CODE COMMAND...; expect_says TEXT (in the last command's output).
set -uo pipefail
furrow=$1 source=$2 out=$3
rm -rf "$out" && mkdir -p "$out"
data=${FURROW_DATA:-$source/../shared/data}
said="$out/.said"

die() { echo "FAILED: $*"; [ -f "$said" ] && sed 's/^/  | /' "$said"; exit 1; }
skip() { echo "SKIPPED: $*"; exit 77; }

expect_exit() {
  local wanted=$1 code=0
  shift
  "$@" >"$said" 2>&1 || code=$?
  [ "$code" -eq "$wanted" ] || die "'$*' ended with $code, wanted $wanted"
}
expect_says() { grep -qF -- "$1" "$said" || die "the output lacks: $1"; }
expect_file() { [ -s "$1" ] || die "$1 is missing or empty"; }
