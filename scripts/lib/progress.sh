# shellcheck shell=bash
# Shows progress and estimates the remaining time, for scripts that source this.

# The steps of ninja's output on stdin, as lines "DONE ALL".
ninja_steps() { sed -u -n 's|^\[\([0-9]*\)/\([0-9]*\)\] .*|\1 \2|p'; }

# The same for the output of ctest.
ctest_steps() { sed -u -n 's|^ *\([0-9]*\)/\([0-9]*\) Test *#.*|\1 \2|p'; }

# The output of the tests that failed, then what ctest prints at its end.
ctest_verdict() { # LOG
  if grep -q '^The following tests FAILED:' "$1"; then
    sed -n '/\*\*\*Failed\|\*\*\*Timeout\|\*\*\*Exception/,/^ *[0-9]*\/[0-9]* Test *#/p' "$1"
  fi
  sed -n '/% tests passed/,$p' "$1"
}

# The same for the output of apt-get -o APT::Status-Fd=1: packages are fetched in the first half.
apt_steps() {
  sed -u -n -e 's|^dlstatus:[^:]*:\([0-9]*\).*|\1 200|p' -e 's|^pmstatus:[^:]*:\([0-9]*\).*|\1 200 100|p' |
    while read -r ready all before; do echo "$((ready + ${before:-0})) $all"; done
}

time_text() { # SECONDS
  if [ "$1" -lt 60 ]; then echo "$1 s"; else echo "$((($1 + 30) / 60)) min"; fi
}

# One line. Until a tenth is done the remaining time follows from the guess, afterwards from the pace so far;
# after more time than the guess the work counts as half done.
progress_text() { # WHAT DONE ALL GONE_S GUESS_S
  local what=$1 ready=$2 all=$3 gone=$4 guess=$5 left
  if [ $((ready * 10)) -ge "$all" ] && [ "$ready" -gt 0 ]; then
    left=$((gone * (all - ready) / ready))
  else
    left=$((guess > gone ? guess - gone : gone))
  fi
  echo "$what: $((all > 0 ? ready * 100 / all : 0)) % after $(time_text "$gone"), about $(time_text "$left") to go"
}

# Reads lines "DONE ALL" until they end. On a terminal one line that changes, else a line every 30 s.
show_progress() { # WHAT GUESS_S
  local what=$1 guess=$2 start=$SECONDS next=0 ready=0 all=0 line gone every=30 before='' after=$'\n'
  if [ -t 2 ]; then every=1 before=$'\r\e[K' after=''; fi
  while true; do
    gone=$((SECONDS - start))
    if [ "$gone" -ge "$next" ]; then
      printf '%s%s%s' "$before" "$(progress_text "$what" "$ready" "$all" "$gone" "$guess")" "$after" >&2
      next=$((gone + every))
    fi
    if read -r -t 1 line; then
      read -r ready all <<< "$line"
    elif [ $? -le 128 ]; then # the end; above 128 nothing came in this second
      break
    fi
  done
  printf '%s%s\n' "$before" "$what: took $(time_text $((SECONDS - start)))" >&2
}
