# What a person may hand to `calibrate` by mistake, on the pictures of Debian's opencv-doc.
source "$(dirname "$0")/lib.sh"
pictures=/usr/share/doc/opencv-doc/examples/data
[ -d "$pictures" ] || skip "opencv-doc is not installed"
board="$source/calib_targets/opencv-9x6-25mm.yaml"
mkdir -p "$out/my boards/left" "$out/my boards/right"
number=0
for file in "$pictures"/left0[1-4].jpg* "$pictures"/right0[5-8].jpg*; do
  case $file in *left*) folder=left ;; *) folder=right ;; esac
  number=$((number % 4 + 1))
  case $file in *.gz) gunzip -c "$file" ;; *) cat "$file" ;; esac > "$out/my boards/$folder/board $number.jpg"
done

# One name in two folders, with blanks: told apart, and the same bytes in another order.
cd "$out/my boards" || exit 1
"$furrow" calibrate --target "$board" --out "$out/twins" left/*.jpg right/*.jpg > /dev/null 2>&1
"$furrow" calibrate --target "$board" --out "$out/twins again" right/*.jpg left/*.jpg > /dev/null 2>&1
for name in "left/board 1.jpg" "right/board 1.jpg"; do
  grep -qF "\"image\": \"$name\"" "$out/twins/calibration.json" || die "calibration.json does not know $name"
done
cmp "$out/twins/camera.yaml" "$out/twins again/camera.yaml" || die "the order of the files changed the camera"

# Folders and patterns stand for their pictures: the same bytes. A folder's notes are no pictures.
echo "taken in May" > left/notes.txt
"$furrow" calibrate --target "$board" --out "$out/folders" left right > /dev/null 2>&1
"$furrow" calibrate --target "$board" --out "$out/mixed" "left/board 1.jpg" left/board\ [234].jpg 'right/*.jpg' > /dev/null 2>&1
cmp "$out/twins/calibration.json" "$out/folders/calibration.json" || die "folders gave another calibration than their pictures"
cmp "$out/twins/calibration.json" "$out/mixed/calibration.json" || die "pictures and a pattern gave another calibration"
expect_exit 0 "$furrow" target check "$board" left right
expect_says "fits 8 of 8"
expect_exit 0 "$furrow" camera undistort "$out/twins/camera.yaml" left right --out "$out/flat"
expect_file "$out/flat/left/board 1.jpg"
expect_file "$out/flat/right/board 1.jpg"
"$furrow" camera validate "$out/twins/camera.yaml" left right --target "$board" > "$said" 2>&1
expect_says "Still good"
expect_exit 0 "$furrow" rows --no-overlays --out "$out/rows" left
mkdir "$out/no pictures" && echo "later" > "$out/no pictures/notes.txt"
for words in "calibrate --target $board --out $out/none" "target check $board" "camera undistort $out/twins/camera.yaml --out $out/none" \
  "camera validate $out/twins/camera.yaml --target $board" "rows --out $out/none"; do
  expect_exit 2 "$furrow" $words left "$out/no pictures"
  expect_says "no pictures: the folder holds no picture"
done

# What is solved and which corners count.
"$furrow" calibrate --target "$board" --out "$out/aspect" --squares unknown_aspect --corner-outliers 3 --view-outliers 3 --weigh-corners left right > "$said" 2>&1
grep -qE '"board_aspect": \{' "$out/aspect/calibration.json" || die "the board's aspect was not solved"
grep -qE '"corners_left_out": [1-9]' "$out/aspect/calibration.json" || die "no corner was left out"
expect_exit 2 "$furrow" calibrate --target "$board" --out "$out/aspect" --squares oblong left

# One picture, and three copies of it.
expect_exit 2 "$furrow" calibrate --target "$board" --out "$out/one" "left/board 1.jpg"
expect_says "1 usable boards in 1 pictures"
for copy in 1 2 3; do cp "left/board 1.jpg" "$out/copy $copy.jpg"; done
expect_exit 2 "$furrow" calibrate --target "$board" --out "$out/one" "$out"/copy*.jpg
expect_says "byte-identical to copy 1.jpg"
[ -e "$out/one" ] && die "a refused calibration left results behind"

# A disk that is full, under the results and under standard output.
(ulimit -f 16; expect_exit 2 "$furrow" calibrate --target "$board" --out "$out/full" left/*.jpg) || exit 1
expect_says "File too large"
[ -z "$(find "$out/full" -name '*part*')" ] || die "a failed write left $(find "$out/full" -name '*part*')"
"$furrow" calibrate --json --target "$board" --out "$out/told" left/*.jpg > /dev/full 2> "$said"
[ $? -eq 2 ] || die "a full standard output went unnoticed"
expect_says "disk full"

# Millimetres for metres.
printf 'type: checkerboard\ncorners: [9, 6]\nsquare_m: 25\n' > "$out/mm.yaml"
expect_exit 2 "$furrow" calibrate --target "$out/mm.yaml" --out "$out/mm" left/*.jpg
expect_says "25 mm is 0.025"
