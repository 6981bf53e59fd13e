#!/bin/sh
# Make the bundled logs again: sh data/make.sh (or `make data`). Same seeds, same logs.
set -eu
cd "$(dirname "$0")/.."
rig() { fric simulate experiment configs/virtual-rig.yaml --axis x --force "$@"; }
rig --kind constant-velocity --seed 1 --samples 600 -o data/constant-velocity.h5
rig --kind presliding-sine --seed 2 --samples 2500 -o data/presliding-sine.h5
rig --kind sliding-sine --seed 3 --samples 3500 -o data/sliding-sine.h5
rig --kind frequency-response --seed 4 -o data/frequency-response.h5
python data/as_circle.py configs/virtual-rig.yaml data/circle.h5
python data/as_csv.py data/constant-velocity.h5 data/strokes
