"""PulseAudio in user space with one output, and what is played into it: a null sink, its monitor, and `parec`."""

import os
import signal
import subprocess
import threading
import time

import numpy as np

from voice_sender import RATE
from waiting import wait_for

RECORDER_MS = 20  # that parec may keep back


class Loudspeaker:
    """A sound server with one output, which can be killed and started again."""

    def __init__(self, folder):
        own = ("PULSE_RUNTIME_PATH", "XDG_CONFIG_HOME", "HOME")
        self._socket, self._folder = folder / "native", folder
        self.environment = os.environ | dict.fromkeys(own, str(folder)) | {"PULSE_SERVER": f"unix:{self._socket}"}
        self._parts, self._arrivals = [], []  # samples, and when the last of them had come [s, monotonic]

    def start(self):
        """Start the server and record what it plays from now on."""
        out = f"module-null-sink sink_name=out format=s16le rate={RATE} channels=1"
        native = f"module-native-protocol-unix socket={self._socket} auth-anonymous=1"
        command = ["pulseaudio", "-n", "--daemonize=no", "--exit-idle-time=-1", "--use-pid-file=no"]
        with (self._folder / "pulse.log").open("ab") as log:
            self._server = subprocess.Popen(
                [*command, "-L", native, "-L", out], env=self.environment, stdout=log, stderr=log
            )
        wait_for(self._socket.exists, what=(self._folder / "pulse.log").read_text)
        self._parts, self._arrivals = [], []
        command = ["parec", "--device=out.monitor", "--raw", "--format=s16le", f"--rate={RATE}", "--channels=1"]
        self._recorder = subprocess.Popen(
            [*command, f"--latency-msec={RECORDER_MS}"], env=self.environment, stdout=subprocess.PIPE
        )
        self._reader = threading.Thread(target=self._read, args=(self._recorder.stdout, self._parts))
        self._reader.start()

    def kill(self):
        """Kill the server: no goodbye."""
        self._server.send_signal(signal.SIGKILL)
        self._recorder.kill()
        for process in (self._server, self._recorder):
            process.wait()
        self._reader.join()
        self._recorder.stdout.close()
        self._socket.unlink(missing_ok=True)

    def __enter__(self):
        self.start()
        return self

    def __exit__(self, *_):
        self.kill()

    def _read(self, pipe, parts):
        while part := os.read(pipe.fileno(), 4096):
            self._arrivals.append(time.monotonic())
            parts.append(part)

    @property
    def samples(self):
        """What was played since the start."""
        data = b"".join(tuple(self._parts))
        return np.frombuffer(data[: len(data) // 2 * 2], "<i2") / 32768

    @property
    def heard_until(self):
        """When the last sample had come [s, monotonic]."""
        return self._arrivals[-1]
