#!/bin/sh
# Reproduces the recipe of models/plant-mini from scratch: expert data, a training, then rounds of
# DAgger (the trained network drives, the expert's actions are recorded) and further trainings.
# The history and scores of plant-mini itself are in its model card.
#
#   SCALE=0.02 OUT=/tmp/trial models/make_model.sh     a trial of minutes
#   models/make_model.sh                               1x data, in `reports/model/`
#
# A stage whose output is there is skipped, one that was stopped goes on. All that a stage needs is
# kept: $OUT/data-*, $OUT/stage-*, $OUT/work-*.
set -eu

SCALE=${SCALE:-1}       # of the data; 1 is PlanT's 1x, 228,000 frames
OUT=${OUT:-reports/model}       # where everything goes; the model is $OUT/plant
WORKERS=${WORKERS:-2}   # processes that drive and make frames
THREADS=${THREADS:-0}   # of a training; 0 is one a core
BATCH=${BATCH:-128}
BENCH=${BENCH:-plant-bench}

# Inputs of the network; see docs/notes/learning.md.
BASIS="--horizon 5 --segments 4 --view 60 --vulnerable --stop-line --limit-input --speed-input --speed-dropout 0.1"
ANSWERS="--targets expert-action --held-out 0.05 --batch $BATCH --threads $THREADS --workers $WORKERS --accelerator cpu"

frames() { awk "BEGIN { print int($1 * $SCALE + 0.5) }"; }

# collect NAME FRAMES OPTIONS: data in $OUT/NAME
collect() {
  name=$1; count=$(frames "$2"); shift 2
  [ -e "$OUT/$name/done" ] && return
  $BENCH collect --out "$OUT/$name" --frames "$count" --workers "$WORKERS" "$@"
  touch "$OUT/$name/done"
}

# train NAME OPTIONS: weights in $OUT/NAME
train() {
  name=$1; shift
  [ -e "$OUT/$name/card.md" ] && return
  # shellcheck disable=SC2086  # lists of words
  $BENCH train plant --out "$OUT/$name" --work "$OUT/work-$name" $ANSWERS "$@"
}

mkdir -p "$OUT"
D=$OUT/data

collect data-expert 228000 --seed 0 --perturb 0.3
# shellcheck disable=SC2086
train stage-b $BASIS --data "$D-expert" --epochs 3 --rate 5e-4

collect data-own-1 58700 --seed 1 --driver "plant-unguarded@$OUT/stage-b"
# shellcheck disable=SC2086
train stage-c $BASIS --data "$D-expert" --data "$D-own-1" --start "$OUT/stage-b" \
  --epochs 1 --rate 5e-4 --stationary-fraction 0.15

collect data-own-2 47850 --seed 3 --driver "plant-unguarded@$OUT/stage-c"
# shellcheck disable=SC2086
train stage-d $BASIS --conflicts --data "$D-expert" --data "$D-own-1" --data "$D-own-2" \
  --start "$OUT/stage-c" --epochs 2 --rate 5e-4 --stationary-fraction 0.15

collect data-own-3 29640 --seed 4 --driver "plant-unguarded@$OUT/stage-d"
ALL="--data $D-expert --data $D-own-1 --data $D-own-2 --data $D-own-3"
# shellcheck disable=SC2086
train stage-e $BASIS --conflicts $ALL --start "$OUT/stage-d" \
  --epochs 3 --drop-after 2 --rate 4e-4 --stationary-fraction 0.15
# shellcheck disable=SC2086
train plant $BASIS --conflicts --motion $ALL --start "$OUT/stage-e" \
  --epochs 2 --drop-after 1 --rate 4e-4 --stationary-fraction 0.15 --overshoot-weight 1.1 --onnx

echo "The model: $OUT/plant. It drives with: $BENCH score --agent plant@$OUT/plant"
