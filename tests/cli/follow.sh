# A row followed through pictures and a video.
source "$(dirname "$0")/lib.sh"
cat > "$out/scene.yaml" <<'Y'
name: "follow"
seed: 31
boards: { count: 0 }
flight:
  shot_interval_s: 0.2
  legs:
    - { height_above_ground_m: 4, end_height_above_ground_m: 4, pitch_deg: -30, end_pitch_deg: -30, shots: 8 }
Y
"$furrow" simulate "$out/scene.yaml" --out "$out/sim" >/dev/null 2>&1 || die "simulate"
metres=(--camera "$out/sim/camera_true.yaml" --spacing 3 --pitch -30 --rate 5)

# Metres, files, figures, comparison by hand; the same bytes on one thread and on four.
printf 'picture,deviation_m,flight\nshot-0002,0.1,first\nshot-0004.jpg,0.1,first\n7,0.1,second\n8,0.1,second\n99,0,second\n' > "$out/hand.csv"
for threads in 1 4; do
  "$furrow" follow "$out/sim/frames" "${metres[@]}" --threads $threads --out "$out/o$threads" --by-hand "$out/hand.csv" \
    --mavlink "file:$out/steer$threads" --speed 1 > "$out/lines$threads" 2> "$said" || die "follow"
done
expect_says "5 a second assumed"
expect_says "8 pictures, rows in 8, hold in 0"
expect_says "1 pictures read by hand are not in the source"
cmp "$out/lines1" "$out/lines4" || die "lines depend on the number of threads"
cmp "$out/steer1" "$out/steer4" || die "steering frames depend on the number of threads"
diff -r "$out/o1" "$out/o4" || die "files depend on the number of threads"
[ "$(wc -l < "$out/lines1")" -eq 8 ] || die "not one line a picture"
grep -qE '^\{"picture":"shot-0001.jpg","index":0,"t_s":0.0,"status":"ok"' "$out/lines1" || die "the first line: $(head -1 "$out/lines1")"
[ "$(grep -c '"cross_track_m":-\?[0-9]' "$out/lines1")" -eq 8 ] || die "no cross-track"
for file in follow.csv overlay.mp4 by_hand.csv figures/following_over_time.png figures/deviation_by_hand.png; do expect_file "$out/o1/$file"; done
grep -q '^total,thesis,4,' "$out/o1/by_hand.csv" || die "by_hand.csv: $(cat "$out/o1/by_hand.csv")"
# Two heartbeats of 21 bytes in 1.4 s, eight setpoints of 65.
[ "$(stat -c %s "$out/steer1")" -eq $((2 * 21 + 8 * 65)) ] || die "steering: $(stat -c %s "$out/steer1") bytes"

# A video, without a camera: pixels.
expect_exit 0 "$furrow" follow "$out/o1/overlay.mp4"
expect_says '"offset_px":'
[ "$(grep -c '^{' "$said")" -eq 8 ] || die "not one line a picture of the video"

# A stream that stops is a camera that went away; a video without its end has no index.
expect_exit 2 "$furrow" follow "file://$out/o1/overlay.mp4"
expect_says "the camera gives no more pictures"
head -c $(($(stat -c %s "$out/o1/overlay.mp4") * 2 / 3)) "$out/o1/overlay.mp4" > "$out/cut.mp4"
expect_exit 2 "$furrow" follow "$out/cut.mp4"
expect_says "its beginning or index is missing"

# Metres by a height from elsewhere.
expect_exit 0 "$furrow" follow "$out/sim/frames" --camera "$out/sim/camera_true.yaml" --height 2.3 --height-sigma 0.2 --pitch -30 --rate 5
[ "$(grep -c '"cross_track_m":-\?[0-9]' "$said")" -eq 8 ] || die "no cross-track by a height"

# One broken picture, one of another size: a status and a reason, and the rest goes on.
mkdir -p "$out/mixed" && cp "$out"/sim/frames/*.jpg "$out/mixed" && printf 'broken' > "$out/mixed/shot-0003.jpg"
expect_exit 0 "$furrow" follow "$out/mixed" --rate 5 --no-overlay --out "$out/m"
expect_says '"picture":"shot-0003.jpg","index":2,"t_s":0.4,"status":"picture_unreadable","reason":"shot-0003.jpg:'
[ "$(grep -c '^{' "$said")" -eq 8 ] || die "the rest did not go on"
[ -e "$out/m/overlay.mp4" ] && die "an overlay nobody asked for"

# A polite kill ends in good order with whole files; a hard one leaves no half file.
mkfifo "$out/slow"
"$furrow" follow "$out/sim/frames" --rate 5 --out "$out/killed" > "$out/slow" 2>/dev/null &
pid=$!
exec 3< "$out/slow"; read -r _ <&3; kill -9 $pid; wait $pid 2>/dev/null; exec 3<&-
[ -e "$out/killed/follow.csv" ] && [ "$(wc -l < "$out/killed/follow.csv")" -ne 9 ] && die "a half follow.csv"
# A reader that goes away ends the run, and its files are whole.
"$furrow" follow "$out/sim/frames" --rate 5 --no-overlay --out "$out/left" 2>/dev/null | head -1 >/dev/null
expect_file "$out/left/follow.csv"

mkdir -p "$out/empty"
expect_exit 2 "$furrow" follow "$out/empty"
expect_says "the folder holds no"
expect_exit 2 "$furrow" follow "$out/none.mp4"
expect_says "none.mp4: there is no such file, folder or camera"
expect_exit 2 "$furrow" follow "$out/hand.csv"
expect_says "FFmpeg finds no video in it"
expect_exit 2 "$furrow" follow /dev/video97
expect_says "no camera answers there"
expect_exit 2 "$furrow" follow "$out/sim/frames" --spacing 3
expect_says "--camera FILE beside it"
expect_exit 2 "$furrow" follow "$out/sim/frames" --camera "$out/sim/camera_true.yaml"
expect_says "--spacing METRES, --height METRES or --half-width METRES beside it"
expect_exit 2 "$furrow" follow "$out/sim/frames" --mavlink udp:127.0.0.1:14550
expect_says "no way to metres"
expect_exit 2 "$furrow" follow "$out/sim/frames" --rule thesis --mavlink udp:drone:14550
expect_says "udp:HOST:PORT with a numeric HOST"
printf 'picture,deviation_m\nshot-0001,wide\n' > "$out/bad.csv"
expect_exit 2 "$furrow" follow "$out/sim/frames" --by-hand "$out/bad.csv"
expect_says "bad.csv:2: deviation_m is 'wide'; wanted a number"
