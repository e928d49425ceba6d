"""Nothing in the repository names a machine: no package index, no absolute path of a desk."""

import re
import subprocess
from pathlib import Path

import pytest


ROOT = Path(__file__).parents[2]
# written in pieces, so that this file does not find itself
INDEX_HOSTS = re.compile(
    "|".join(["py" + r"pi\.(org|python)", "python" + r"hosted\.", "/sim" + "ple/?[\"'\\s]"])
)
INDEX_OPTIONS = re.compile("--(extra-)?index" + "-url|--find" + "-links")
DESK_PATHS = re.compile(r"(?<![\w.])/(work|home|root|Users|opt)" + r"/[\w.]+")
LOCK_ADDRESS = re.compile(r"https?:|file:|@ ")


def tracked() -> list[Path]:
    listing = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    done = subprocess.run(listing, cwd=ROOT, capture_output=True, text=True)
    if done.returncode != 0:
        pytest.skip("not a git checkout")  # an unpacked source archive
    return [ROOT / name for name in done.stdout.split("\0") if name and (ROOT / name).is_file()]


def text(path: Path) -> str:
    return path.read_bytes().decode("utf-8", errors="ignore")


@pytest.mark.parametrize(
    "pattern", [INDEX_HOSTS, INDEX_OPTIONS, DESK_PATHS], ids=lambda p: p.pattern
)
def test_no_file_names_a_machine(pattern):
    found = [
        f"{p.relative_to(ROOT)}: {m.group()}" for p in tracked() for m in pattern.finditer(text(p))
    ]
    assert not found


def test_the_lock_holds_hashes_and_no_address():
    lock = text(ROOT / "requirements.lock")
    assert lock.count("--hash=sha256:") > 1000
    assert not LOCK_ADDRESS.search(lock)
