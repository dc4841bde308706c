# The real flight, when its pictures are here.
source "$(dirname "$0")/lib.sh"
[ -d "$data/flights/mini-se" ] || skip "FURROW_DATA has no flights/mini-se"
export FURROW_DATA=$data
"$furrow" run "$source/projects/mini-se-corn" --out "$out/corn" > "$out/log" 2> "$said"
code=$?
[ "$code" -le 1 ] || die "run ended with $code"
cat "$out/log" "$said"
for file in shots.csv report.html manifest.json calibration/camera.cameramodel; do expect_file "$out/corn/$file"; done
[ "$(wc -l < "$out/corn/shots.csv")" -eq 8 ] || die "shots.csv has not 7 shots"
grep -q "1280x720" "$out/corn/report.html" || die "the report does not say at which size was calibrated"
grep -q "4000x2250" "$out/corn/report.html" || die "the report does not say to which size the intrinsics were carried"
