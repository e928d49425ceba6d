"""A compiler of C, as strict as a controller's."""

import ctypes
import shutil
import subprocess

import pytest


STRICT = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic")


@pytest.fixture
def compiled():
    """C as a shared library, which must pass without a warning."""
    gcc = shutil.which("gcc")
    if gcc is None:
        pytest.skip("no gcc here to compile C with")

    def of(source, flags=("-O2",)):
        library = source.with_suffix(".so")
        command = [gcc, *STRICT, *flags, "-shared", "-fPIC", "-o", library, source, "-lm"]
        made = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
        assert made.returncode == 0, made.stderr[:1000]
        return ctypes.CDLL(str(library))

    return of
