source "$(dirname "$0")/lib.sh"
expect_exit 0 "$furrow" --help
expect_says "demo"
for command in demo simulate calibrate camera rows follow run target version; do
  expect_exit 0 "$furrow" $command --help
  expect_says "Example: furrow $command"
done
expect_exit 0 "$furrow" version
expect_says "furrow "
expect_exit 2 "$furrow"
expect_exit 2 "$furrow" nonsense
expect_exit 2 "$furrow" rows --out "$out"
expect_exit 2 "$furrow" rows --out "$out" --method magic a.jpg

# Numbers that are none, or that no quantity can be.
for words in "--height nan" "--spacing nan" "--spacing inf" "--height -1" "--half-width 0" "--rate nan" "--rate 1e-6" "--speed nan" "--pitch nan" "--threads -1"; do
  expect_exit 2 "$furrow" follow pictures $words
  expect_says "${words%% *}: '${words#* }'; wanted "
done
expect_exit 2 "$furrow" calibrate --out "$out" --corner-outliers nan a.jpg
expect_says "--corner-outliers: 'nan'; wanted 0 or a number above it"
# A sigma of something that was not said would do nothing.
for word in spacing height pitch; do
  expect_exit 2 "$furrow" follow pictures --$word-sigma 0.1
  expect_says "requires --$word"
done
