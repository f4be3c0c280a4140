"""`ross ground` as a process of its own: what it says, what it costs, and a stop and a start in between."""

import os
import resource
import signal
import subprocess
from contextlib import contextmanager
from pathlib import Path

from ports import free_port
from processes import ROSS

CLOCK = os.sysconf("SC_CLK_TCK")
PAGE = os.sysconf("SC_PAGE_SIZE")


class Ground:
    """The process, the address of its page, and the port on which it hears payloads."""

    def __init__(self, *arguments):
        self.port = free_port()
        command = [*ROSS, "ground", f"udpin:127.0.0.1:{self.port}"]
        self._command = [*command, "--port", str(free_port()), *map(str, arguments)]
        self.start()

    def start(self):
        """Start, again too: the addresses stay the same."""
        self._process = subprocess.Popen(self._command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        said = []
        while "http" not in (said or [""])[-1]:
            said.append(self._process.stdout.readline())
            assert said[-1], f"ross ground did not start: {said}"
        self.url = next(word for word in said[-1].split() if word.startswith("http"))

    def end(self, number=signal.SIGINT):
        """End; Ctrl-C is a good end."""
        self._process.send_signal(number)
        rest, _ = self._process.communicate(timeout=60)
        assert number == signal.SIGKILL or self._process.returncode == 0, rest
        assert "Traceback" not in rest, rest

    @contextmanager
    def frozen(self):
        """Keep it from doing anything meanwhile."""
        self._process.send_signal(signal.SIGSTOP)
        try:
            yield
        finally:
            self._process.send_signal(signal.SIGCONT)

    def cpu(self):
        """Seconds of processor time so far."""
        fields = Path(f"/proc/{self._process.pid}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / CLOCK

    def memory(self):
        """Resident memory [bytes]."""
        return int(Path(f"/proc/{self._process.pid}/statm").read_text().split()[1]) * PAGE

    def dropped(self):
        """How many datagrams the system had to drop, because the process did not come for them."""
        rows = [line.split() for line in Path("/proc/net/udp").read_text().splitlines()[1:]]
        return sum(int(row[-1]) for row in rows if int(row[1].partition(":")[2], 16) == self.port)

    def fill_disk(self):
        """Let no file of it grow any longer."""
        resource.prlimit(self._process.pid, resource.RLIMIT_FSIZE, (0, resource.RLIM_INFINITY))

    def files(self):
        """How many files are open."""
        return len(list(Path(f"/proc/{self._process.pid}/fd").iterdir()))


@contextmanager
def served(*arguments):
    """Run it with a UDP port and a page of its own."""
    ground = Ground(*arguments)
    try:
        yield ground
    finally:
        ground.end()
