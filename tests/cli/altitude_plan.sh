# A plan from a data sheet, from a camera file and from a project.
source "$(dirname "$0")/lib.sh"
rows=(--spacing 3 --spacing-sigma 0.03 --half-width 0.6 --row-height 1.7)
lens=(--focal-mm 8.8 --sensor-mm 13.2 --size 1280 720)
expect_exit 0 "$furrow" altitude plan --help
expect_says "Example: furrow altitude plan"
expect_exit 0 "$furrow" altitude plan "${lens[@]}" "${rows[@]}" --height-above-ground 4 --pitch-deg -13.8 --out "$out/plan"
expect_says "expect a sigma of"
expect_says "variance_percent"
for file in plan.csv plan_budget.csv plan_over_pitch.png plan_over_pitch.svg plan_over_height.csv; do expect_file "$out/plan/$file"; done

"$furrow" altitude plan "${lens[@]}" "${rows[@]}" --height-above-canopy 2.3 --pitch-deg -13.8 --json > "$out/plan.json" 2> "$said" || die "--json failed"
grep -q '"sigma_by_cause_m"' "$out/plan.json" || die "--json lacks the budget"

write_camera "$out/camera.yaml" 0. 0. 0. 0. 0.
: > "$out/a.jpg"
printf 'name: x\ncamera: { model: camera.yaml }\nshots: { images: a.jpg }\nrows: { spacing_m: 3, half_width_m: 0.6, height_m: 1.7 }\n' > "$out/project.yaml"
expect_exit 0 "$furrow" altitude plan --project "$out" --height-above-ground 5 --pitch-deg -20
expect_says "3.30 m above the canopy at -20.0 deg"

expect_exit 2 "$furrow" altitude plan "${lens[@]}" --height-above-canopy 2 --pitch-deg -20
expect_says "no row spacing"
expect_exit 2 "$furrow" altitude plan "${lens[@]}" "${rows[@]}" --height-above-canopy 2 --pitch-deg 20
expect_says "a pitch below the horizon"
expect_exit 2 "$furrow" altitude plan --focal-px 800 "${rows[@]}" --height-above-canopy 2 --pitch-deg -20
expect_says "no picture size"
expect_exit 2 "$furrow" altitude plan "${lens[@]}" "${rows[@]}" --pitch-deg -20
