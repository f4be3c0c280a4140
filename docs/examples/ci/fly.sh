#!/bin/sh
# fly.sh SCENARIO PROGRAM [ARGUMENTS]: run a program beside a simulated payload, and end with its exit code.
#
# The payload is `ross sitl --serve`: the payload as `ross run` runs it, in a simulated room. The program is started as
#   python PROGRAM URL SCENARIO [ARGUMENTS]
# once telemetry can be received at URL. Environment:
#   ROSS    command of RoSS (ross)           PYTHON  interpreter that has ross_payload (python3)
#   SPEED   times real time (4)              OUT     folder for the payload's log and the ground truth (out/flight)
#   SEED    of everything random (0)          GRACE   seconds in which the payload has to end (30)
set -eu
[ $# -ge 2 ] || { echo "expected SCENARIO PROGRAM, got: $*" >&2; exit 2; }
scenario=$1 program=$2
shift 2
ross=${ROSS:-ross} python=${PYTHON:-python3} out=${OUT:-out/flight}
command -v "$ross" > /dev/null || { echo "expected RoSS as '$ross', found nothing: set ROSS, or pip install it" >&2; exit 2; }
[ -f "$program" ] || { echo "expected a program, got '$program', which is no file" >&2; exit 2; }
mkdir -p "$out"
port=$("$python" -c 'import socket
with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
    free.bind(("127.0.0.1", 0))
    print(free.getsockname()[1])')

with_us='setpriv --pdeathsig TERM'  # ends with this shell also where that is killed; not on every system
$with_us true 2> /dev/null || with_us=''
$with_us "$ross" sitl --serve --scenario "$scenario" --speed "${SPEED:-4}" --seed "${SEED:-0}" \
  --telemetry "udpout:127.0.0.1:$port" --out "$out" > "$out/payload.log" 2>&1 &
payload=$! flying='' killer='' ended=0 lived=''
finish() {
  kill -0 "$payload" 2> /dev/null && lived=yes  # else it has ended by itself, or somebody else has killed it
  kill -TERM $flying "$payload" 2> /dev/null || true
  [ -z "$killer" ] || kill "$killer" 2> /dev/null || true
  if [ -n "$lived$flying" ]; then  # one whose plug-in never returns does not end
    (sleep "${GRACE:-30}" && kill -KILL $flying "$payload") > /dev/null 2>&1 &
    killer=$!
  fi
  wait $flying "$payload" 2> /dev/null || ended=$?  # of the last one; the shell says "Terminated" there
  [ -z "$killer" ] || kill "$killer" 2> /dev/null || true
}
trap 'finish; exit 130' HUP INT TERM

status=0
exec 3<&0  # some shells, dash for one, give what they start with & an empty standard input
$with_us "$python" "$program" "udpin:127.0.0.1:$port" "$scenario" "$@" <&3 3<&- &
flying=$!
exec 3<&-
wait "$flying" || status=$?  # a signal ends this at once, and would not end a program in the foreground
flying=''
finish
if [ "$ended" -eq 137 ] && [ -n "$lived" ]; then
  echo "the payload did not end within ${GRACE:-30} s and was killed" >&2
  [ "$status" -ne 0 ] || status=1
elif [ "$ended" -ne 0 ] && [ "$ended" -ne 130 ] && [ "$ended" -ne 143 ]; then  # 143: SIGTERM came while it started
  echo "the payload ended by itself, with exit code $ended; its log says:" >&2
  tail -n 5 "$out/payload.log" >&2
  [ "$status" -ne 0 ] || status=1
fi
exit "$status"
