"""Stream a job with grbl-streamer: arguments port and goal [mm], G-code on standard input; fails on any error."""

import sys
import time


def main() -> None:
    from grbl_streamer import GrblStreamer

    port, goal, job = sys.argv[1], float(sys.argv[2]), sys.stdin.read()
    seen: dict[str, list[tuple[object, ...]]] = {}
    grbl = GrblStreamer(lambda event, *values: seen.setdefault(event, []).append(values))
    grbl.poll_interval = 0.1
    grbl._rx_buffer_size = 90  # it does not count its own queries, which go into the same 128 bytes
    grbl.cnect(port, 115200)
    end = time.monotonic() + 100

    def until(reached):
        while not reached():
            if time.monotonic() > end or "on_error" in seen or "on_alarm" in seen:
                sys.exit(f"{grbl.cmode} {grbl.cmpos} {seen}")
            time.sleep(0.05)

    try:
        until(grbl.is_connected)
        grbl.poll_start()
        until(lambda: any("[GC:" in text for (text,) in seen.get("on_read", ())))  # grbl tells none of that in motion
        grbl.write(job)
        grbl.job_run()
        until(lambda: grbl.cmode == "Idle" and abs(grbl.cmpos[0] - goal) <= 0.1125)
    finally:
        grbl.disconnect()


if __name__ == "__main__":
    main()
