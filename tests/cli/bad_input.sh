source "$(dirname "$0")/lib.sh"
board="$source/calib_targets/opencv-9x6-25mm.yaml"

expect_exit 2 "$furrow" calibrate --target "$out/none.yaml" --out "$out/c" a.jpg
expect_says "none.yaml: there is no such file"
expect_exit 2 "$furrow" calibrate --target "$board" --out "$out/c" "$out/none.jpg"
expect_says "none.jpg"
[ -e "$out/c" ] && die "a failed calibration left results behind"

printf 'type: checkerboard\ncorners: [9, 6]\nsquare_m: 25\n' > "$out/mm.yaml"
expect_exit 2 "$furrow" calibrate --target "$out/mm.yaml" --out "$out/c" a.jpg
expect_says "mm.yaml"

expect_exit 2 "$furrow" target sheet "$out/mm.yaml" -o "$out/mm.pdf"
expect_says "25 mm is 0.025"
expect_exit 2 "$furrow" target sheet "$source/calib_targets/thesis-9x6-38mm.yaml" --paper A4 -o "$out/b.pdf"
expect_says "it fits on A2"
[ -e "$out/b.pdf" ] && die "a refused sheet was written"
expect_exit 0 "$furrow" target sheet "$board" -o "$out/board.png" --dpi 72
expect_exit 0 "$furrow" target check "$board" "$out/board.png"
expect_says "fits 1 of 1"
printf 'type: checkerboard\ncorners: [10, 7]\nsquare_m: 0.025\n' > "$out/squares.yaml"
expect_exit 1 "$furrow" target check "$out/squares.yaml" "$out/board.png"
expect_says "corners: [9, 6] fits"
expect_exit 2 "$furrow" calibrate --out "$out/c" "$out/board.png"
expect_says "a checkerboard of 9x6 inner corners shows in 1 of 1"
expect_says "--square-mm 25"

printf 'not a picture' > "$out/broken.jpg"
expect_exit 2 "$furrow" rows --out "$out/r" "$out/broken.jpg"
expect_says "broken.jpg"

printf 'name: x\ncamera: { modle: a.yaml }\nshots: { images: "*.jpg" }\n' > "$out/project.yaml"
expect_exit 2 "$furrow" run "$out/project.yaml" --out "$out/p"
expect_says "project.yaml:2: unknown key 'modle' in 'camera'; wanted 'model' perhaps"

: > "$out/empty.csv"
cat > "$out/camera.yaml" <<'Y'
%YAML:1.0
---
image_width: 64
image_height: 48
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 50., 0., 31.5, 0., 50., 23.5, 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: [ 0., 0., 0., 0., 0. ]
Y
printf 'name: x\ncamera: { model: camera.yaml }\nshots: { images: "*.jpg" }\ntelemetry: { file: empty.csv }\n' > "$out/project.yaml"
expect_exit 2 "$furrow" run "$out/project.yaml" --out "$out/p"
expect_says "empty.csv"

# Where results cannot go is said before the work.
expect_exit 2 "$furrow" run "$out/project.yaml" --out "$out/empty.csv/p"
expect_says "empty.csv' is no folder"
expect_exit 2 "$furrow" calibrate --target "$board" --out "$out/empty.csv" "$out/board.png"
expect_says "empty.csv' is no folder"

# Numbers that no farm and no camera has are named with their place.
printf 'name: x\ncamera: { model: camera.yaml }\nshots: { images: board.png }\nrows: { spacing_m: 3000 }\n' > "$out/project.yaml"
expect_exit 2 "$furrow" run "$out/project.yaml" --out "$out/p"
expect_says "project.yaml:4: rows.spacing_m is 3000; wanted metres, from 0.001 to 100"
sed 's/50., 0., 31.5/.nan, 0., 31.5/' "$out/camera.yaml" > "$out/nan.yaml"
expect_exit 2 "$furrow" camera show "$out/nan.yaml"
expect_says "nan.yaml:9: \`camera_matrix\` holds '.nan'"
[ -e "$out/p" ] && die "a refused run left results behind"

printf 'seed: 1\nnonsense: 2\n' > "$out/scene.yaml"
expect_exit 2 "$furrow" simulate "$out/scene.yaml" --out "$out/s"
expect_says "scene.yaml"

# Pictures of one name in two folders keep an overlay each.
for folder in left right; do
  mkdir -p "$out/$folder"
  { printf 'P6\n320 240\n255\n'; head -c 230400 /dev/zero; } > "$out/$folder/a.ppm"
done
(cd "$out/left" && expect_exit 0 "$furrow" rows --out "$out/twins" a.ppm ../right/a.ppm) || exit 1
expect_file "$out/twins/overlays/left/a.png"
expect_file "$out/twins/overlays/right/a.png"
grep -q '"left/a.ppm"' "$out/twins/rows.json" || die "rows.json does not tell the twins apart"

# A file over the size limit fails like a full disk, and leaves no half file.
(ulimit -f 8; expect_exit 2 "$furrow" rows --out "$out/limit" "$out/left/a.ppm") || exit 1
expect_says "File too large"
[ -z "$(find "$out/limit" -name '*part*')" ] || die "a failed write left $(find "$out/limit" -name '*part*')"
