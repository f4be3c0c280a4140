"""What the Containerfile and the compose file claim: read from them, in soak tests from the images that they make."""

import json
import re
import shlex
import shutil
import socket
import subprocess
import tomllib
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest
import soundfile
import yaml
from packaging.requirements import Requirement

from bare_debian import ROOT, need, run
from containerfile import Containerfile
from ports import free_port
from processes import ROSS, program
from ross_payload import __version__
from ross_payload.plugins import available
from ross_payload.service.check import loaded
from waiting import wait_for

DEPLOY = ROOT / "docs" / "deploy"
LARGEST = 250e6  # bytes of an image of the payload
RUN = ("payload", "blueos", "world")  # stages that are run
TYPES = {"device-integration", "example", "theme", "other", "tool"}  # of an extension of BlueOS


@pytest.fixture(scope="module")
def file():
    return Containerfile(DEPLOY / "Containerfile")


@pytest.fixture(scope="module")
def compose():
    return yaml.safe_load((DEPLOY / "compose.yaml").read_text())


def test_what_is_copied_is_in_the_checkout(file):
    for stage in file.stages.values():
        for word, rest in stage.instructions:
            if word == "COPY" and "--from" not in rest:
                assert all((ROOT / path).exists() for path in rest.split()[:-1]), rest


@pytest.mark.parametrize("name", RUN)
def test_no_image_runs_as_root(file, name):
    assert file.last(name, "USER") == "ross"


def test_the_payload_is_asked_for_its_health_and_keeps_its_state_in_a_volume(file):
    program, command = file.command("payload", "HEALTHCHECK")
    assert (Path(program).name, command) == ("ross", "health")
    assert command in available("ross_payload.commands")
    assert file.last("payload", "VOLUME") == "/state"
    assert "STATE_DIRECTORY=/state" in file.last("payload", "ENV")


def test_the_image_starts_what_the_service_of_systemd_starts(file):
    unit = (ROOT / "docs/examples/ross.service").read_text()
    started = [*file.command("payload", "ENTRYPOINT"), *file.command("payload", "CMD")]
    assert started == re.search(r"(?m)^ExecStart=(.*)", unit)[1].split()
    for setting in re.search(r"(?m)^Environment=(.*)", unit)[1].split():
        assert setting in file.last("payload", "ENV")


def test_the_extras_of_the_image_are_known(file):
    (extras,) = [rest for word, rest in file.inherited("built") if word == "ARG" and rest.startswith("EXTRAS=")]
    known = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    assert set(extras.removeprefix("EXTRAS=").split(",")) <= set(known)


def test_the_extension_has_the_labels_that_the_repository_of_blueos_reads(file):
    labels = file.labels("blueos")
    assert labels["version"] == __version__
    assert labels["type"] in TYPES
    assert Requirement(labels["requirements"]).name == "core"
    tags = json.loads(labels["tags"])
    assert len(tags) <= 10
    assert all(re.fullmatch("[a-z0-9-]+", tag) for tag in tags)
    assert all(
        {"name", "email"} <= set(each) for each in (*json.loads(labels["authors"]), json.loads(labels["company"]))
    )
    metadata = json.loads((DEPLOY / "blueos" / "metadata.json").read_text())
    assert {"name", "website", "docker", "description"} == set(metadata)


def test_the_extension_asks_for_devices_and_the_network_and_no_more(file):
    host = json.loads(file.labels("blueos")["permissions"])["HostConfig"]
    assert "Privileged" not in host
    assert "CapAdd" not in host
    assert host["CapDrop"] == ["ALL"]
    assert host["ReadonlyRootfs"]
    state, config, devices = (bind.split(":") for bind in host["Binds"])
    assert state == ["ross-state", "/state"]  # a volume: a folder of the host would be root's, and in the file browser
    assert config[1:] == ["/etc/ross", "ro"]
    assert devices == ["/dev", "/dev"]
    assert all(rule.startswith("c ") for rule in host["DeviceCgroupRules"])


def test_what_compose_starts_has_a_root_that_cannot_be_written(file, compose):
    for name, service in compose["services"].items():
        assert service["read_only"], name
        assert service["build"]["target"] in file.stages
        assert (DEPLOY / service["build"]["context"]).resolve() == ROOT
    assert compose["services"]["payload"]["cap_drop"] == ["ALL"]
    assert compose["services"]["ground"]["ports"] == ["127.0.0.1:8765:8765"]
    assert loaded(DEPLOY / "compose.toml").service.autostart == "nothing"


@pytest.mark.soak
def test_the_payload_of_compose_hears_its_world_and_reports(compose, tmp_path):
    """The commands of the services, on the loopback instead of a network of containers."""
    sound, wire = free_port(), free_port()
    ports = {"world:40001": f"127.0.0.1:{sound}", "world:40002": f"127.0.0.1:{wire}"}
    ports |= {"0.0.0.0:40001": ports["world:40001"], "0.0.0.0:40002": ports["world:40002"]}

    def here(text, more=()):
        for there, place in {**ports, **dict(more)}.items():
            text = text.replace(there, place)
        return text

    world, payload = ([here(word) for word in compose["services"][name]["command"]] for name in ("world", "payload"))
    with ExitStack() as stack, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as ground:
        ground.bind(("127.0.0.1", 0))
        ground.settimeout(60)
        config = here(
            (DEPLOY / "compose.toml").read_text(), {"ground:14550": f"127.0.0.1:{ground.getsockname()[1]}"}.items()
        )
        (tmp_path / "ross.toml").write_text(config + f'\n[service]\nstate_dir = "{tmp_path}"\n')
        payload[-1] = tmp_path / "ross.toml"
        _, said = stack.enter_context(program([*ROSS, *world], tmp_path, "world.log"))
        wait_for(lambda: "[actuator]" in said.read_text())  # compose starts again what did not find it
        stack.enter_context(program([*ROSS, *payload], tmp_path, "payload.log"))
        ask = [*ROSS, "health", tmp_path / "ross.toml"]
        wait_for(lambda: subprocess.run(ask, capture_output=True, check=False).returncode == 0)
        assert ground.recv(2048)[:1] == b"\xfd"  # MAVLink 2


class Buildah:
    """Builds and mounts images in a folder of its own, without a daemon."""

    def __init__(self, folder):
        need(buildah="buildah")
        places = ["--root", folder / "images", "--runroot", folder / "run"]
        self._command = ["buildah", "--storage-driver", "vfs", *places]

    def __call__(self, *words):
        return run([*self._command, *words]).stdout.strip()

    def build(self, file, context, tag, *options):
        """Build an image without namespaces, which a sandbox may refuse."""
        self(
            "build",
            "--quiet",
            "--isolation",
            "chroot",
            "--format",
            "docker",
            "--file",
            file,
            "--tag",
            tag,
            *options,
            context,
        )


@pytest.fixture(scope="module")
def images(tmp_path_factory, bare_debian, wheels):
    """What builds images, and the folders of the payload's and the extension's, built on a bare Debian."""
    folder = tmp_path_factory.mktemp("images")
    buildah = Buildah(folder)
    (folder / "Containerfile").write_text(f"FROM scratch\nADD {bare_debian.name} /\n")
    buildah.build(folder / "Containerfile", bare_debian.parent, "localhost/bare")
    given = ["--build-arg", "BASE=localhost/bare", "--volume", f"{wheels}:/wheels:ro", "--layers"]
    mounted = {}
    for target in ("payload", "blueos"):
        buildah.build(DEPLOY / "Containerfile", ROOT, f"localhost/{target}", "--target", target, *given)
        mounted[target] = Path(buildah("mount", buildah("from", "--pull-never", f"localhost/{target}")))
    return buildah, mounted


@pytest.mark.soak
@pytest.mark.parametrize("target", ["payload", "blueos"])
def test_an_image_is_below_its_size(images, target):
    size = int(run(["du", "-sb", "--one-file-system", images[1][target]]).stdout.split()[0])
    print(f"{target}: {size / 1e6:.1f} MB")  # noqa: T201  a figure of the manual
    assert size < LARGEST


CONFIG = """
[audio]
source = "file:/etc/ross/noise.wav"
[actuator]
kind = "tb6600"
[[links]]
url = "udpout:127.0.0.1:{port}"
"""
INSIDE = """
set -u
mount --bind {root} {root}
mount -o remount,ro,bind {root}
mount --rbind /dev {root}/dev
mount -t proc proc {root}/proc
mount -t tmpfs tmpfs {root}/tmp
mount --bind {state} {root}/state
mount --bind {config} {root}/etc/ross
inside() {{ exec env -i {environment} {chroot} --userspec=10001:10001 --groups=20,29 {root} "$@"; }}
(inside {start}) &
tries=0
until (inside {check}); do tries=$((tries + 1)); [ $tries -lt 300 ] || exit 1; sleep 0.2; done
(inside /usr/bin/python3 -c '{look}')
kill $!
wait $!
echo "ended with $?"
"""
LOOK = 'import ctypes.util, os; print(os.getuid(), os.statvfs("/").f_flag & 1, ctypes.util.find_library("portaudio"))'


def lived(buildah, target, root, folder, **environment):
    """Run an image as its user, with a root that cannot be written, until it is well; return what it said."""
    config = json.loads(buildah("inspect", "--type", "image", f"localhost/{target}"))["Docker"]["config"]
    state = folder / "state"
    run(["cp", "-a", root / "state", state])
    (folder / "config").mkdir()
    noise = np.random.default_rng(0).normal(0, 0.01, (16000 * 120, 2))
    soundfile.write(folder / "config" / "noise.wav", noise, 16000)
    (folder / "config" / "ross.toml").write_text(CONFIG.format(port=free_port()))
    variables = [*config["Env"], *(f"{name}={value}" for name, value in environment.items())]
    script = INSIDE.format(
        root=root,
        state=state,
        config=folder / "config",
        environment=shlex.join(variables),
        chroot=shutil.which("chroot"),  # the path of the image does not lead to it
        start=shlex.join([*config["Entrypoint"], *(config["Cmd"] or ())]),
        check=shlex.join(config["Healthcheck"]["Test"][1:]),
        look=LOOK,
    )
    return run(["unshare", "--mount", "--pid", "--fork", "--kill-child", "sh", "-c", script]).stdout.splitlines()


@pytest.mark.soak
def test_the_payload_runs_as_its_user_with_a_root_that_cannot_be_written(images, tmp_path):
    buildah, mounted = images
    said = lived(buildah, "payload", mounted["payload"], tmp_path)
    assert said[-3:] == ["idle", "10001 1 libportaudio.so.2", "ended with 0"]


@pytest.mark.soak
def test_the_extension_runs_as_its_user_with_a_root_that_cannot_be_written(images, tmp_path):
    buildah, mounted = images
    ports = {"ROSS_FRONT_PORT": free_port(), "ROSS_PAGE_PORT": free_port(), "ROSS_HOST": "127.0.0.1"}
    said = lived(
        buildah, "blueos", mounted["blueos"], tmp_path, **ports, ROSS_TELEMETRY=f"udpin:127.0.0.1:{free_port()}"
    )
    assert said[-3:] == ["idle", "10001 1 libportaudio.so.2", "ended with 0"]


@pytest.mark.soak
def test_every_package_of_a_payload_is_there_for_arm64(tmp_path):
    """Nothing is compiled when an image or a package is built there."""
    need()
    run(["/usr/bin/python3", "-m", "venv", tmp_path / "tools"])
    platforms = [f"--platform=manylinux_2_{minor}_aarch64" for minor in range(17, 37)]  # Debian 12 has glibc 2.36
    abis = [f"--abi={abi}" for abi in ("cp311", "abi3", "none")]
    which = ["--python-version=3.11", "--implementation=cp", *abis, *platforms, "--platform=manylinux2014_aarch64"]
    fetch = [
        tmp_path / "tools/bin/python",
        "-m",
        "pip",
        "--quiet",
        "download",
        "--no-deps",
        "--only-binary=:all:",
        *which,
    ]
    run([*fetch, "--require-hashes", "--requirement", ROOT / "requirements-hashed.txt", "--dest", tmp_path / "wheels"])
