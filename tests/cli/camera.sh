source "$(dirname "$0")/lib.sh"
for job in show convert undistort diff validate; do
  expect_exit 0 "$furrow" camera $job --help
  expect_says "Example: furrow camera $job"
done
write_camera "$out/camera.yaml" -0.12 0.09 0.0008 -0.0005 -0.02
expect_exit 0 "$furrow" camera show "$out/camera.yaml" --sensor-mm 13.2 8.8
expect_says "9.017"
expect_says "FOV"
expect_exit 0 "$furrow" camera show "$out/camera.yaml" --json
expect_says '"without_inverse_share": 0'
expect_exit 2 "$furrow" camera show "$out/none.yaml"
expect_says "none.yaml: there is no such file"

for format in mrcal opencv ros colmap metashape matlab; do
  expect_exit 0 "$furrow" camera convert "$out/camera.yaml" -o "$out/camera.$format" --format $format
  expect_exit 0 "$furrow" camera diff "$out/camera.yaml" "$out/camera.$format"
  grep -qE "^RMS difference / px +0.0000$" "$said" || die "$format moves pixels"
done
expect_exit 2 "$furrow" camera convert "$out/camera.yaml" -o "$out/camera.cam"
expect_says "Pix4D .cam has one focal length"
[ -e "$out/camera.cam" ] && die "a refused export left a file behind"
expect_exit 2 "$furrow" camera convert "$out/camera.yaml" -o "$out/camera.txt"
expect_says "--format"
expect_exit 2 "$furrow" camera convert "$out/camera.yaml" -o "$out/chain.yaml" --format kalibr
expect_says "a Kalibr camchain has no room for k3"

sed 's/874.33/880.00/' "$out/camera.yaml" > "$out/other.yaml"
expect_exit 0 "$furrow" camera diff "$out/camera.yaml" "$out/other.yaml" --out "$out/diff"
expect_says "0.32"
expect_file "$out/diff/camera_difference.png"
expect_file "$out/diff/camera_difference.csv"

boards=/usr/share/doc/opencv-doc/examples/data
[ -d "$boards" ] || skip "no $boards (install opencv-doc)"
target="$source/calib_targets/opencv-9x6-25mm.yaml"
expect_exit 0 "$furrow" calibrate --target "$target" --out "$out/left" "$boards"/left??.jpg
# Its own pictures are still good, another lens's are not.
expect_exit 0 "$furrow" camera validate "$out/left/camera.cameramodel" "$boards"/left??.jpg --target "$target"
expect_says "Still good to 0.00 px"
sed -E "s/('intrinsics': \[ )[0-9.]+, [0-9.]+/\1560.0, 560.0/; /optimization_inputs/d" "$out/left/camera.cameramodel" > "$out/old.cameramodel"
expect_exit 1 "$furrow" camera validate "$out/old.cameramodel" "$boards"/left??.jpg --target "$target"
expect_says "No longer good"
expect_exit 2 "$furrow" camera validate "$out/camera.yaml" "$boards"/left??.jpg --target "$target"
expect_says "640x480"
expect_exit 0 "$furrow" camera undistort "$out/left/camera.yaml" "$boards/left01.jpg" "$boards/left02.jpg" --out "$out/flat"
expect_file "$out/flat/left01.jpg"
expect_file "$out/flat/mask.png"
expect_file "$out/flat/camera.yaml"
expect_exit 1 "$furrow" camera undistort "$out/left/camera.yaml" "$boards/left01.jpg" "$out/none.jpg" --out "$out/flat2"
expect_says "none.jpg"
expect_exit 2 "$furrow" camera undistort "$out/camera.yaml" "$boards/left01.jpg" --out "$out/flat3"
expect_says "640x480"
[ -e "$out/flat3" ] && die "nothing was undistorted, and a folder is there"
exit 0
