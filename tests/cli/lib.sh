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

# write_camera FILE COEFFICIENT...: the thesis's camera, 874.33 px over 1280 px of a 13.2 mm sensor, as an OpenCV file.
write_camera() {
  local file=$1 coefficients
  shift
  coefficients=$(printf ', %s' "$@")
  cat > "$file" <<Y
%YAML:1.0
---
image_width: 1280
image_height: 720
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 874.33, 0., 640.49, 0., 872.39, 360.81, 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 1
   cols: $#
   dt: d
   data: [ ${coefficients#, } ]
Y
}
