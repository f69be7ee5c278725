# Sourced by the scripts that measure accuracy: the ToF conditions, and means over scenes.
# shellcheck shell=bash
shopt -s inherit_errexit
export LC_ALL=C.UTF-8  # where commas are decimal, awk reads 1.5 as 1

fail() { echo "$(basename "$0"): $*" >&2; exit "${code:-1}"; }

conditions=(clean sparse noise1 noise2 sr4000 blind25 blind50 blind75 none wrapped calib3 calib6)
# A range sensor that is off: what it says is wrong, not noisy.
bias_conditions=(range10 range-10 range20 wiggle10 bumps1.5 bumps3 bumps6 real)
# What a parameter is chosen, and a part is judged, by: each kind of damage once.
main_conditions=(clean sparse noise1 noise2 sr4000 blind50 none)

# Flags of sprout-evaluate for a condition.
condition_flags() {
  case "$1" in
    clean) echo "--tof grid:auto" ;;
    sparse) echo "--tof grid:auto*2" ;;
    noise1) echo "--seed-noise-px 1 --seed-jitter-px 1" ;;
    noise2) echo "--seed-noise-px 2 --seed-jitter-px 2" ;;
    sr4000) echo "--tof sr4000" ;;
    blind*) echo "--tof sr4000?blind=${1#blind}" ;;
    none | coarsenone | zonesnone) echo "--tof none" ;;
    zones*) echo "--tof zones:${1#zones}" ;;
    every*) echo "--tof sr4000?every=${1#every}" ;;
    coarse*) echo "--tof grid:auto*${1#coarse}" ;;
    wrapped) echo "--tof sr4000?wrapped=25" ;;
    calib*) echo "--tof sr4000?calibration=${1#calib}" ;;
    align*) echo "--tof sr4000?calibration=${1#align} --config scripts/lib/align_tof.textproto" ;;
    range*) echo "--tof grid:auto?range=${1#range}" ;;
    wiggle*) echo "--tof grid:auto?wiggle=${1#wiggle}&period=0.6" ;;
    bumps*) echo "--tof grid:auto?bumps=${1#bumps}" ;;
    real) echo "--tof sr4000?wiggle=10&amplitude=10&multipath=0.3&scatter=0.02" ;;
    mirrored) echo "--tof grid:auto?mirrored" ;;
    rows2_* | roll02_* | yaw01_*) rig_flags "$1" ;;
    *) fail "no condition $1" ;;
  esac
}

# The same for a knocked rig: ERROR_TOF_KNOWN, as rows2_sr4000_refined.
rig_flags() { # CONDITION
  local error tof known
  IFS=_ read -r error tof known <<< "$1"
  case "$error" in
    rows2) error=rows=2 ;;
    roll02) error=roll=0.2 ;;
    yaw01) error=yaw=0.1 ;;
  esac
  echo "$(condition_flags "$tof") --rig-error $error${known:+?$known}"
}

# Scenes of a condition among the sizes given. With damaged seeds only half and full size: there a
# pixel of noise means about the same.
condition_scenes() { # CONDITION SIZE...
  local condition=$1 size
  shift
  for size in "$@"; do
    case "$condition/$size" in
      clean/* | sparse/* | coarse*/* | every*/* | zones*/* | */half | */full) printf '%s\n' "$SPROUT_DATA/middlebury/$size"/*/ ;;
    esac
  done
}

build_evaluate() {
  [ -n "${SPROUT_DATA:-}" ] || code=2 fail "SPROUT_DATA is not set; scripts/fetch_middlebury gets the scenes"
  echo "$(basename "$0"): building" >&2
  mkdir -p build
  { cmake --preset release && cmake --build --preset release --target sprout-evaluate; } \
    > build/evaluate.log 2>&1 || fail "the build failed, see build/evaluate.log"
}

evaluate() { # CONDITION CSV "SIZES" FLAG...
  local condition=$1 csv=$2 scenes flags
  mapfile -t scenes < <(condition_scenes "$condition" $3)
  read -ra flags <<< "$(condition_flags "$condition")"
  shift 3
  build/release/bin/sprout-evaluate "${scenes[@]}" "${flags[@]}" --quiet --csv "$csv" "$@"
}

# Means over the scenes of a CSV, non-occluded pixels: METHOD <1 <=1 REFINE PRIOR GROW FILL TOTAL ms.
means() { # CSV
  awk -F, '
    NR == 1 { for (i = 1; i <= NF; ++i) column[$i] = i; next }
    $column["pixels"] == "nonocc" {
      m = $column["method"]
      if (!(m in n)) order[++methods] = m
      ++n[m]
      split("correct_lt1 correct_le1 refine_ms prior_ms grow_ms fill_ms total_ms", names, " ")
      for (k = 1; k <= 7; ++k) sum[m, k] += $column[names[k]]
    }
    END {
      for (j = 1; j <= methods; ++j) {
        m = order[j]
        printf "%s", m
        for (k = 1; k <= 7; ++k) printf k < 3 ? " %.2f" : " %.1f", sum[m, k] / n[m]
        print ""
      }
    }' "$1"
}
