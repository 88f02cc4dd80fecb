#!/bin/sh
# Runs a program with assertions through scenes of every kind, the methods that every build has, and a picture: run.sh TAUT
# Scenes and the rest go side by side.
set -eu
taut=$1
cd "$(dirname "$0")/../.."
out=$(mktemp -d)
side=
trap '[ -z "$side" ] || { kill "$side" || true; wait "$side" || true; } 2> /dev/null; rm -rf "$out"' EXIT

scenes() {
  for scene in rope_swing two_bodies bench_heavy bench_stick hard/coincident hard/falling_chain hard/pulled_apart \
    hard/release_straight_up hard/taut_snap hard/whip contact/interrupted_pendulum contact/peg_slip contact/post \
    contact/rope_floor contact/scale contact/sticks_meet materials/bungee materials/flag_rope materials/wind topology/crane \
    topology/lasso topology/rope_ladder topology/string_shooter; do
    "$taut" simulate "scenes/$scene.toml" --set duration=0.3 --csv "$out/scene.csv" --no-estimate -q > "$out/said_of_scenes" ||
      { echo "$scene ends with $?"; exit 1; }
  done
}
scenes &
side=$!
for method in impulse springs xpbd dynamic-constraints multibody truth direct; do
  "$taut" simulate scenes/rope_swing.toml --method "$method" --set duration=0.2 --csv "$out/motion.csv" -q > "$out/said" ||
    { echo "$method ends with $?"; exit 1; }
done
"$taut" simulate scenes/pin.toml --csv "$out/motion.csv" --no-estimate -q > "$out/said"
"$taut" render scenes/rope_swing.toml --poster 0.1 --size 96x54 --samples 1 --out "$out" -q > "$out/said"
"$taut" export scenes/rope_swing.toml -o "$out/motion.glb" --set duration=0.1 -q > "$out/said"
wait "$side"
