"""XLA's option for whole loops is added, and replaces nothing of the user's."""

import os
import subprocess
import sys

import pytest

from fascicle.core.lazy import enable_whole_loops


OPTION = "--xla_backend_extra_options=xla_cpu_small_while_loop_byte_threshold=100000000"


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("", OPTION),
        ("--xla_dump_to=there", f"--xla_dump_to=there {OPTION}"),
        (OPTION, OPTION),
        ("--xla_backend_extra_options=xla_other=1", "--xla_backend_extra_options=xla_other=1"),
    ],
)
def test_it_is_added_unless_there_is_one(before, after, monkeypatch):
    monkeypatch.setenv("XLA_FLAGS", before)
    enable_whole_loops()
    assert os.environ["XLA_FLAGS"] == after


@pytest.mark.parametrize("first", ["", "import fascicle as fs, jax; fs.Muscle"])
def test_dynamics_sets_it_before_xla_compiles(first):
    code = f"""
{first}
import fascicle.dynamics, os
print(os.environ["XLA_FLAGS"])
import jax, jax.numpy as jnp
text = jax.jit(lambda x: jax.lax.fori_loop(0, 9, lambda _, x: jnp.sin(x) + x[::-1] @ x, x)).lower(
    jnp.ones(500)).compile().as_text()
print("xla_cpu_small_call" in text)
"""
    environ = {name: value for name, value in os.environ.items() if name != "XLA_FLAGS"}
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, env=environ
    )
    assert done.stdout.split() == [OPTION, "True"]
