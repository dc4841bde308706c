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
# The telling pictures with their corners, the same whatever the threads, and the numbers of calibration.json.
[ "$(ls "$out"/cam/figures/corners_view_*.png | wc -l)" -eq 3 ] || die "expected the best, the median and the worst view"
for reason in 'lowest RMS' 'median RMS' 'highest RMS'; do grep -qF ": $reason; RMS" "$out/cam/report.html" || die "no picture of the view of the $reason"; done
for threads in 1 4; do
  expect_exit 0 "$furrow" calibrate --threads $threads --target "$source/calib_targets/opencv-9x6-25mm.yaml" --out "$out/threads$threads" "$out"/boards/*.jpg
done
diff -r "$out/threads1/figures" "$out/threads4/figures" || die "figures differ with the threads"
if command -v python3 >/dev/null; then
  python3 - "$out/cam" <<'P' || die "the figures' tables are not calibration.json's residuals"
import csv, glob, json, re, sys
views = json.load(open(sys.argv[1] + "/calibration.json"))["views"]
for file in glob.glob(sys.argv[1] + "/figures/corners_view_*.csv"):
    view = views[int(re.search(r"_(\d+)\.csv", file)[1]) - 1]
    rows = list(csv.DictReader(open(file)))
    assert view["used"] and len(rows) == len(view["residual_px"]) == 54
    for row, (du, dv), (u, v) in zip(rows, view["residual_px"], view["observed_px"]):
        for name, value in (("residual_u_px", du), ("residual_v_px", dv), ("u_px", u), ("v_px", v)):
            assert abs(float(row[name]) - value) < 6e-5, (file, name)
P
fi
[ "$(grep -cE '"search_steps": [1-9]' "$out/cam/calibration.json")" -eq 13 ] || die "calibration.json does not say what each search took"
grep -qF 'Nothing was left out.' "$out/cam/report.html" || die "the page does not say that the searches ended within their bound"
grep -qE '"rms_px": 0\.[0-4]' "$out/cam/calibration.json" || die "RMS is not below 0.5 px"
if command -v python3 >/dev/null && python3 -c 'import mrcal' 2>/dev/null; then
  python3 -c 'import sys, mrcal; m = mrcal.cameramodel(sys.argv[1]); assert m.intrinsics()[0] == "LENSMODEL_OPENCV5", m.intrinsics()' \
    "$out/cam/camera.cameramodel" || die "mrcal does not read camera.cameramodel"
fi
