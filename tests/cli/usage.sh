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
