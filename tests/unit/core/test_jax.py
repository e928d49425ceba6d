"""`import fascicle.jax`: 64 bits, pytrees and XLA's option; what JAX meets without it."""

import os
import subprocess
import sys

import pytest


pytest.importorskip("jax")


def run(code: str, **variables: str) -> list[str]:
    """Lines that a fresh Python prints."""
    environ = {name: value for name, value in os.environ.items() if name != "XLA_FLAGS"}
    command = [sys.executable, "-W", "error", "-c", code]
    done = subprocess.run(
        command, capture_output=True, text=True, check=True, env=environ | variables
    )
    return done.stdout.splitlines()


def test_jax_arrays_are_refused_before_fascicle_jax():
    code = """
import fascicle as fs, jax, jax.numpy as jnp, numpy as np
muscle = fs.example("kim2021_figure_6")
calls = [
    lambda: muscle.force(jnp.asarray(1e5), 0.1),
    lambda: muscle.force(1e5, jnp.asarray([0.1])),
    lambda: jax.jit(lambda P: muscle.force(P, 0.1))(1e5),
    lambda: muscle.replace(length=jnp.asarray(0.2)),
]
for call in calls:
    try:
        call()
    except fs.InvalidInputError as error:
        print(error.argument)
print(jnp.ones(1).dtype, float(muscle.force(1e5, 0.1)) > 0)
import fascicle.jax
print(jnp.ones(1).dtype, muscle.force(jnp.asarray(1e5), 0.1).dtype)
"""
    assert run(code) == ["JAX arrays"] * 4 + ["float32 True", "float64 float64"]


def test_modules_are_pytrees_whether_defined_before_or_after():
    code = """
import fascicle as fs
from fascicle.core.module import Module
class Before(Module):
    size: float
import fascicle.jax, jax
class After(Module):
    size: float
print(jax.tree.leaves([Before(1.0), After(2.0)]))
print(len(jax.tree.leaves(fs.example("kim2021_bundle_1_4"))) > 10)
"""
    assert run(code) == ["[1.0, 2.0]", "True"]


def test_fascicle_is_imported_where_jax_is_blocked():
    code = """
import sys
sys.modules["jax"] = None
import fascicle as fs
muscle = fs.example("kim2021_figure_6")
print(float(muscle.force(1e5, 0.1)) > 0, muscle.length.dtype)
"""
    assert run(code) == ["True float64"]


OPTION = "--xla_backend_extra_options=xla_cpu_small_while_loop_byte_threshold=100000000"


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("", OPTION),
        ("--xla_cpu_use_fusion_emitters=false", f"--xla_cpu_use_fusion_emitters=false {OPTION}"),
        (OPTION, OPTION),
        ("--xla_backend_extra_options=xla_other=1", "--xla_backend_extra_options=xla_other=1"),
    ],
)
def test_the_loops_option_replaces_no_other(before, after):
    code = "import fascicle.jax, os; print(os.environ['XLA_FLAGS'])"
    assert run(code, XLA_FLAGS=before) == [after]
