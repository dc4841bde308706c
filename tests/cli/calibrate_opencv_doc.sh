# The README's walk-through on the pictures of Debian's opencv-doc.
source "$(dirname "$0")/lib.sh"
pictures=/usr/share/doc/opencv-doc/examples/data
[ -d "$pictures" ] || skip "opencv-doc is not installed"
mkdir -p "$out/boards"
for file in "$pictures"/left[0-9][0-9].jpg*; do
  case $file in *.gz) gunzip -c "$file" > "$out/boards/$(basename "$file" .gz)" ;; *) cp "$file" "$out/boards" ;; esac
done
[ "$(ls "$out/boards" | wc -l)" -eq 13 ] || die "expected 13 pictures"
expect_exit 0 "$furrow" calibrate --target "$source/calib_targets/opencv-9x6-25mm.yaml" --out "$out/cam" "$out"/boards/*.jpg
for file in camera.cameramodel camera.yaml calibration.json report.html; do expect_file "$out/cam/$file"; done
expect_exit 0 "$furrow" calibrate --json --target "$source/calib_targets/opencv-9x6-25mm.yaml" --out "$out/again" "$out"/boards/*.jpg
cmp "$out/cam/calibration.json" "$out/again/calibration.json" || die "two runs gave different bytes"
cmp "$out/cam/report.html" "$out/again/report.html" || die "two runs gave different reports"
[ "$(grep -cE '"search_steps": [1-9]' "$out/cam/calibration.json")" -eq 13 ] || die "calibration.json does not say what each search took"
grep -qF 'Nothing was left out.' "$out/cam/report.html" || die "the page does not say that the searches ended within their bound"
grep -qE '"rms_px": 0\.[0-4]' "$out/cam/calibration.json" || die "RMS is not below 0.5 px"
if command -v python3 >/dev/null && python3 -c 'import mrcal' 2>/dev/null; then
  python3 -c 'import sys, mrcal; m = mrcal.cameramodel(sys.argv[1]); assert m.intrinsics()[0] == "LENSMODEL_OPENCV5", m.intrinsics()' \
    "$out/cam/camera.cameramodel" || die "mrcal does not read camera.cameramodel"
fi
