# The main job with nothing but the repository.
source "$(dirname "$0")/lib.sh"
"$furrow" demo --json "$out/demo" > "$out/demo.json" 2> "$said"
code=$?
[ "$code" -le 1 ] || die "demo ended with $code"
for file in shots.csv budget.csv fusion.csv rows.json report.html manifest.json calibration/calibration.json; do expect_file "$out/demo/$file"; done
for figure in "$out"/demo/figures/*.png; do expect_file "${figure%.png}.svg"; done
header=$(head -1 "$out/demo/shots.csv")
for column in shot_id image t_utc latitude_deg longitude_deg height_takeoff_m height_vps_m pitch_log_deg pitch_deg pitch_sigma_deg \
  above_canopy_thesis_m above_canopy_spacing_m above_canopy_refined_m above_canopy_refined_sigma_m above_ground_refined_m above_canopy_fused_m above_ground_fused_sigma_m cross_track_m \
  heading_error_deg rows_used status; do
  [[ ",$header," == *",$column,"* ]] || die "shots.csv lacks $column"
done
grep -rqE '/(home|root|tmp|work)/' "$out/demo/shots.csv" "$out/demo/rows.json" "$out/demo/manifest.json" && die "an absolute path got into an output"
# The refined height must beat the thesis formula, and the bound holds with room to spare (the measured table is in the README).
awk -F'"rmse_share":' '/"rmse_share"/ {print $2 + 0}' "$out/demo.json" > "$out/shares"
[ "$(wc -l < "$out/shares")" -eq 9 ] || die "demo --json lacks the comparison with the truth"
thesis=$(sed -n 1p "$out/shares") refined=$(sed -n 4p "$out/shares")
awk -v r="$refined" -v t="$thesis" 'BEGIN {exit !(r < 0.10 && r < t)}' || die "refined height errs by $refined of the height, the thesis formula by $thesis"
# The truth of each way, then of the fused heights with each source off: the log must help.
fused=$(sed -n 5p "$out/shares")
awk -v f="$fused" -v r="$refined" 'BEGIN {exit !(f < r)}' || die "fused height errs by $fused of the height, refined from rows alone by $refined"
