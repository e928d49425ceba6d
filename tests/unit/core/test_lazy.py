import os
import subprocess
import sys
from types import ModuleType

import pytest

import fascicle
from fascicle.core.lazy import attach_lazy, enable_whole_loops


def test_a_name_in_a_module_of_its_name_is_refused():
    with pytest.raises(ValueError, match="can't be in a module of the same name"):
        attach_lazy("fascicle.some", {"law": "law"})


def test_packages_list_their_names():
    assert {"Task", "search", "evolve"} <= set(dir(fascicle.design))
    assert {"Muscle", "tables", "__version__"} <= set(dir(fascicle))


def test_public_modules_are_attributes():
    modules = {n for n in fascicle.__all__ if isinstance(getattr(fascicle, n), ModuleType)}
    assert {"buckling", "collapse", "recruitment", "schemes", "tension"} <= modules


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
def test_the_loops_option_replaces_no_other(before, after, monkeypatch):
    monkeypatch.setenv("XLA_FLAGS", before)
    enable_whole_loops()
    assert os.environ["XLA_FLAGS"] == after


@pytest.mark.parametrize("first", ["", "import fascicle as fs, jax; fs.Muscle"])
def test_dynamics_sets_the_loops_option_before_xla_compiles(first):
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
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=environ)
    assert done.stdout.split() == [OPTION, "True"]
