"""Makes the picture that the README and the manual show: `python docs/pictures.py`, after a change that shows in it."""

import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

STATIC = Path(__file__).parent / "_static"


def main() -> None:
    """Run the demo and keep its picture with few colours, so that it stays small."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "ross_payload.cli", "sitl", "--seed", "0", "--out", folder]
        subprocess.run(command, check=True)  # noqa: S603 - our own command
        with Image.open(Path(folder) / "mission.png") as picture:
            small = picture.convert("RGB").resize(
                (picture.width * 4 // 5, picture.height * 4 // 5), Image.Resampling.LANCZOS
            )
            small.quantize(200, method=Image.Quantize.MAXCOVERAGE).save(STATIC / "mission.png", optimize=True)


if __name__ == "__main__":
    main()
