"""The package of Debian in a bare Debian: from `apt install` to a service that is up, and gone without a trace."""

import os
import re
import subprocess
import time
from dataclasses import dataclass

import numpy as np
import pytest
import soundfile

from bare_debian import ROOT, Chroot, need, run

pytestmark = pytest.mark.soak

LIMIT_S = 180.0  # from `apt install` to a service that is up
RATE = 16000
ASKED = (
    "systemctl start ross", "echo started $?", "systemctl is-active ross", "systemctl show -P StatusText ross",
    "grep -E '^(Seccomp|CapEff|NoNewPrivs):' /proc/$(systemctl show -P MainPID ross)/status",
    "systemctl stop ross", "systemctl show -P Result ross", "systemctl poweroff --no-block",
)  # fmt: skip
TRY = """[Service]
Type=oneshot
ExecStart=/bin/sh /try
StandardOutput=file:/result
[Install]
WantedBy=multi-user.target
"""


@dataclass
class Story:
    """What happened to a system."""

    seconds: dict[str, float]
    doctor: str
    health: str
    ended: int
    kept: str = ""  # of the changed configuration, after the package was installed again
    booted: str = ""
    removed: set[str] | None = None
    purged: set[str] | None = None
    before: set[str] | None = None
    users: str = ""


@pytest.fixture(scope="module")
def package(tmp_path_factory, wheels):
    need(dpkg_buildpackage="dpkg-dev", dh="debhelper")
    out = tmp_path_factory.mktemp("deb")
    run(["sh", ROOT / "docs/deploy/build-deb.sh", out], env=os.environ | {"WHEELS": str(wheels)})
    return next(out.glob("*.deb"))


def described(system):
    """Change the configuration to microphones that are a file, which ends after a while."""
    noise = np.random.default_rng(0).normal(0, 0.01, (RATE * 120, 2))
    soundfile.write(system.folder / "var/lib/ross/noise.wav", noise, RATE)
    path = system.folder / "etc/ross/ross.toml"
    text = re.sub(r"(?m)^source = .*", 'source = "file:/var/lib/ross/noise.wav"', path.read_text())
    path.write_text(re.sub(r"(?m)^preset = .*\n", "", text))


def up(system):
    """Start the service's commands as its user, as the unit does; return what it says of itself and its exit code."""
    unit = (system.folder / "lib/systemd/system/ross.service").read_text()
    before, command = (re.search(rf"(?m)^{name}=-?(.*)", unit)[1].split() for name in ("ExecStartPre", "ExecStart"))
    system.run(*before, user="ross")
    process = subprocess.Popen([str(word) for word in system.command(*command, user="ross")])
    ask = [str(word) for word in system.command("ross", "health", "/etc/ross/ross.toml", user="ross")]
    try:
        while (told := subprocess.run(ask, capture_output=True, text=True, check=False)).returncode:
            assert process.poll() is None, "it has ended"
            time.sleep(0.1)
    finally:
        process.terminate()
    return told.stdout.strip(), process.wait(60)


def booted(system):
    """Boot the system with its own systemd, have it start and stop the service; return what it noted."""
    system.run("apt-get", "-qq", "-y", "--no-install-recommends", "install", "systemd", "systemd-sysv", "dbus")
    (system.folder / "etc/systemd/system/try.service").write_text(TRY)
    (system.folder / "try").write_text("\n".join(ASKED))
    system.run("systemctl", "-q", "enable", "try")
    command = ["systemd-nspawn", "-b", "-D", system.folder, "--register=no", "--keep-unit", "--private-network"]
    subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, check=False, timeout=300)
    return (system.folder / "result").read_text()


@pytest.fixture(scope="module")
def story(tmp_path_factory, bare_debian, package):
    system = Chroot(tmp_path_factory.mktemp("system") / "root", bare_debian)
    before, seconds, began = system.files(), {}, time.monotonic()
    run(["cp", package, system.folder / "root/ross-payload.deb"])
    system.run("apt-get", "-qq", "update")
    system.run("apt-get", "-qq", "-y", "install", "/root/ross-payload.deb")
    seconds["apt"] = time.monotonic() - began
    described(system)
    doctor = system.run("ross", "doctor", "/etc/ross/ross.toml", user="ross")
    seconds["doctor"] = time.monotonic() - began - seconds["apt"]
    health, ended = up(system)
    seconds["up"] = time.monotonic() - began - seconds["apt"] - seconds["doctor"]
    told = Story(seconds, doctor, health, ended, before=before)
    system.run("dpkg", "--install", "/root/ross-payload.deb")
    told.kept = (system.folder / "etc/ross/ross.toml").read_text()
    (system.folder / "opt/ross/lib/plug-in").write_text("what pip has put there")
    system.run("apt-get", "-qq", "-y", "remove", "ross-payload")
    told.removed = system.files() - before
    system.run("apt-get", "-qq", "-y", "purge", "ross-payload")
    recommended = "APT::AutoRemove::RecommendsImportant=false"  # by apt itself: certificates
    system.run("apt-get", "-qq", "-y", "-o", recommended, "autoremove", "--purge")
    told.purged = system.files() - before
    told.users = system.run("cat", "/etc/passwd", "/etc/group", "/etc/shadow", "/etc/gshadow")
    return told


def test_from_apt_install_to_a_service_that_is_up_takes_less_than_three_minutes(story):
    print({name: round(value, 1) for name, value in story.seconds.items()})  # noqa: T201  a figure of the manual
    assert sum(story.seconds.values()) < LIMIT_S


def test_the_doctor_finds_nothing_that_must_be_fixed(story):
    assert "fail " not in story.doctor
    assert "separating" in story.doctor  # the last of its checks


def test_the_commands_of_the_unit_run_as_its_user_and_end_in_good_order(story):
    assert (story.health, story.ended) == ("idle", 0)


def test_installing_it_again_keeps_the_changed_configuration(story):
    assert "file:/var/lib/ross/noise.wav" in story.kept


def test_removal_keeps_configuration_and_state_and_nothing_else_of_it(story):
    own = {path for path in story.removed if "ross" in path and not path.startswith("/var/lib/systemd")}  # debhelper's
    assert {"/etc/ross/ross.toml", "/var/lib/ross/noise.wav"} <= own
    assert all(path.startswith(("/etc/ross", "/var/lib/ross")) for path in own), own


def test_purge_leaves_nothing(story):
    assert story.purged <= {"/etc/ld.so.cache~", "/etc/passwd-", "/etc/group-", "/etc/shadow-", "/etc/gshadow-"}
    assert "ross" not in story.users


def test_systemd_starts_it_in_its_sandbox(tmp_path, bare_debian, package):
    need(systemd_nspawn="systemd-container")
    system = Chroot(tmp_path / "root", bare_debian)
    run(["cp", package, system.folder / "root/ross-payload.deb"])
    system.run("apt-get", "-qq", "update")
    system.run("apt-get", "-qq", "-y", "install", "/root/ross-payload.deb")
    described(system)
    noted = booted(system).split("\n")
    assert noted[:3] == ["started 0", "active", "idle"], noted
    assert {line.replace("\t", " ") for line in noted[3:6]} == {
        "CapEff: 0000000000000000",
        "NoNewPrivs: 1",
        "Seccomp: 2",
    }
    assert noted[6] == "success"
