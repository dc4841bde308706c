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
