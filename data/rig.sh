#!/bin/sh
# `make rig`: the virtual rig, with everything identified from its own noisy logs and nothing given. Both axes make their
# experiments; plant, static map and GMS model are identified, controller and observer designed; then the circle is run
# with these on the machine as it truly is. All is left in the folder named (demo/rig).
set -eu
cd "$(dirname "$0")/.."
rig=configs/virtual-rig.yaml
out=${1:-demo/rig}
mkdir -p "$out"
run() { printf '\n$ %s\n' "$*"; "$@"; }
used=""
for axis in x y; do
    log=$out/log-$axis.h5
    run fric simulate experiment $rig --axis $axis --kind all --samples 2000 --seed 1 -o "$log" --force
    run fric identify plant "$log" -o "$out/plant-$axis.yaml" --force
    run fric identify static "$log" --plant "$out/plant-$axis.yaml" -o "$out/static-$axis.yaml" --force
    run fric identify gms "$log" --static "$out/static-$axis.yaml" --plant "$out/plant-$axis.yaml" \
        -o "$out/friction-$axis.yaml" --force
    run fric design controller "$out/plant-$axis.yaml" -o "$out/controller-$axis.yaml" --force
    run fric design observer "$out/plant-$axis.yaml" --controller "$out/controller-$axis.yaml" \
        -o "$out/observer-$axis.yaml" --force
    for part in plant controller observer friction; do
        used="$used --with $axis=$out/$part-$axis.yaml"
    done
done
# shellcheck disable=SC2086  # the words of $used are meant
run fric simulate circle $rig $used --plot "$out/circles.png" --force
# shellcheck disable=SC2086
fric simulate circle $rig $used --json > "$out/circle.json"
