"""Makes the pictures that the README and the manual show: `python docs/pictures.py [STUDY...]`.

Without arguments the picture of the demo; with the folders of finished studies the figures of theirs that are shown:
`explanation/measured.md` names their commands.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

STATIC = Path(__file__).parent / "_static"
SHOWN = ("aoa", "methods", "orientation-refined")  # of a study


def main(studies: list[Path]) -> None:
    """Keep pictures with few colours, so that they stay small."""
    if not studies:
        demo()
    for folder in studies:
        for name in SHOWN:
            if (folder / f"{name}.png").is_file():
                with Image.open(folder / f"{name}.png") as picture:
                    picture.convert("L").quantize(16).save(STATIC / f"{name}.png", optimize=True)


def demo() -> None:
    """Run the demo and keep its picture."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "ross_payload.cli", "sitl", "--seed", "0", "--out", folder]
        subprocess.run(command, check=True)  # noqa: S603 - our own command
        with Image.open(Path(folder) / "mission.png") as picture:
            small = picture.convert("RGB").resize(
                (picture.width * 4 // 5, picture.height * 4 // 5), Image.Resampling.LANCZOS
            )
            small.quantize(200, method=Image.Quantize.MAXCOVERAGE).save(STATIC / "mission.png", optimize=True)


if __name__ == "__main__":
    main([Path(name) for name in sys.argv[1:]])
