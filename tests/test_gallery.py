"""The gallery makes a picture and a line of a scenario, and the manual shows all of them."""

import subprocess
import sys
from pathlib import Path

import numpy as np
from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
SCRIPTS = sorted((ROOT / "scripts").glob("*.toml"))


def gallery(*arguments):
    command = [sys.executable, str(ROOT / "scripts" / "gallery.py"), *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_the_gallery_makes_a_picture_and_a_line(tmp_path):
    done = gallery(tmp_path, "--only", "towed_net", "--end", 0.05)
    assert done.returncode == 0, done.stderr
    (line,) = done.stdout.splitlines()
    assert "towed_net.toml" in line
    assert "91 knots, 0.05 s; held or drawn with" in line
    pixels = np.asarray(Image.open(tmp_path / "towed_net.png").convert("L"))
    assert pixels.shape == (480, 640)
    # a net of thin lines covers more than a hundredth of the picture, and never most of it
    assert 0.01 < np.mean(pixels < 240) < 0.5


def test_a_folder_that_is_a_file_is_one_line(tmp_path):
    file = tmp_path / "file"
    file.touch()
    done = gallery(file)
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1


def test_the_manual_shows_every_scenario():
    page = (ROOT / "netdae/manual/gallery.md").read_text(encoding="utf-8")
    for script in SCRIPTS:
        assert f"scripts/pictures/gallery/{script.stem}.png" in page, script.name
        assert (ROOT / "scripts/pictures/gallery" / f"{script.stem}.png").is_file()
