"""``ross ground`` in a process of its own, with a free port."""

import re
import subprocess
import sys
from contextlib import contextmanager

from ports import free_port

ROSS = [sys.executable, "-u", "-m", "ross_payload.cli", "ground"]
BEGIN = r"ross ground: (http\S+)  \(Ctrl-C ends it\)\n"


@contextmanager
def ground(*words, descriptors=None):
    """Start it, with a free port; yield the process and the page's address. ``descriptors``: soft and hard limit."""
    limited = [] if descriptors is None else ["prlimit", "--nofile={}:{}".format(*descriptors)]
    process = subprocess.Popen(
        [*limited, *ROSS, "--port", "0", *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    try:
        line = process.stdout.readline()
        begun = re.fullmatch(BEGIN, line)
        if begun is None:
            process.kill()
        assert begun, line + process.stderr.read()
        yield process, begun[1]
    finally:
        process.kill()
        process.communicate()


def link(port=None):
    return f"udpin:127.0.0.1:{port or free_port()}"
