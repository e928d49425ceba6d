"""What an import costs: laws and the commands for them load no JAX."""

import json
import subprocess
import sys

import pytest


HEAVY = {
    "dask", "fascicle.cli", "IPython", "matplotlib", "moocore", "netCDF4", "pandas", "panel",
    "pint", "plotly", "pydantic", "rich", "scipy", "tomlkit", "typer", "xarray", "zarr",
}  # fmt: skip


WITHOUT = {"jax", "jaxlib", "equinox", "diffrax", "jaxtyping"}
BUNDLE, MUSCLE = "kim2021_bundle_1_4", "kim2021_figure_6"


def loaded(statements: str) -> set[str]:
    """Modules that a fresh interpreter holds after `statements`."""
    code = f"import json, sys\n{statements}\nprint('\\n' + json.dumps(sorted(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return set(json.loads(done.stdout.splitlines()[-1]))


COMMAND = """
from fascicle.cli import main
for line in {lines!r}:
    try:
        main(line)
    except SystemExit as end:
        assert end.code in (0, None), line
    assert not {without!r} & set(sys.modules), line
"""


def test_the_laws_load_no_files_results_or_pictures():
    modules = loaded(
        "import fascicle as fs\n"
        f"assert not {HEAVY!r} & set(sys.modules)\n"
        "m = fs.Muscle.from_dimensions("
        "length=0.127, outer_radius=6.35e-3, wall_thickness=1.6e-3, braid_angle=0.576)\n"
        "m.force(1e5, 0.1)\n"
        "fs.Bundle([fs.MotorUnit(m)]).force([1e5], 0.1)"
    )
    assert not modules & (HEAVY | WITHOUT)


def test_commands_for_laws_load_no_jax():
    lines = [
        ["force", MUSCLE, "--pressure", "200kPa", "--strain", "0.1"],
        ["free-strain", MUSCLE, "--pressure", "200kPa"],
        ["bundle", BUNDLE, "--pressure", "300kPa,100kPa", "--strain", "0.1"],
        ["recruit", BUNDLE, "--force", "60N", "--strain", "0.1"],
        ["space", BUNDLE],
        ["efficiency", BUNDLE],
    ]
    loaded(COMMAND.format(lines=lines, without=WITHOUT))


def test_help_loads_no_jax():
    without = {"jax", "jaxlib", "equinox", "numpy", "xarray", "matplotlib", "pint"}
    loaded(COMMAND.format(lines=[["--help"]], without=without))


def test_importing_leaves_the_environment_alone():
    loaded(
        "import os, jax\nbefore = dict(os.environ)\n"  # JAX has settings of its own
        "import fascicle as fs\nfs.example('kim2021_figure_6').force(1e5, 0.1)\n"
        "assert dict(os.environ) == before"
    )


def test_jax_is_switched_whenever_it_comes():
    checked = "assert jax.config.jax_enable_x64\nassert jax.numpy.asarray(1.0).dtype == 'float64'"
    for order in ("import jax, fascicle", "import fascicle, jax.numpy, jax",
                  "import fascicle.muscle, importlib.util\nimportlib.util.find_spec('jax')\n"
                  "import jax"):  # fmt: skip
        loaded(f"{order}\n{checked}")


def test_single_precision_asked_for_is_kept_and_warned_about_once():
    loaded(
        "import os, warnings\nos.environ['JAX_ENABLE_X64'] = '0'\n"
        "with warnings.catch_warnings(record=True) as caught:\n"
        "    warnings.simplefilter('always')\n"
        "    import fascicle as fs, jax, jax.numpy as jnp\n"
        "ours = [w for w in caught if 'JAX_ENABLE_X64' in str(w.message)]\n"
        "assert len(ours) == 1, caught\n"
        "assert jnp.asarray(1.0).dtype == 'float32'\n"
        "muscle = fs.example('kim2021_figure_6')\n"
        "slope = jax.jit(jax.grad(muscle.force))(34.5e3, 0.13)\n"
        "assert jnp.isfinite(slope) and slope.dtype == 'float32'"
    )


@pytest.mark.slow
def test_all_derivatives_exist_in_single_precision():
    loaded(
        "import os, warnings\nos.environ['JAX_ENABLE_X64'] = '0'\n"
        "warnings.simplefilter('ignore')\n"
        "import fascicle as fs, jax, jax.numpy as jnp\n"
        "muscle, bundle = fs.example('kim2021_figure_6'), fs.example('kim2021_bundle_1_4')\n"
        "at = lambda P: jnp.array([344.7e3, P])\n"
        "recruit = fs.recruitment.recruit\n"
        "slopes = [jax.grad(muscle.free_strain)(34.5e3),\n"
        "    jax.grad(lambda m: m.force(34.5e3, 0.13))(muscle).length,\n"
        "    jax.grad(lambda P: bundle.free_strain(at(P)))(5e4),\n"
        "    jax.grad(lambda e: recruit(bundle, 60.0, e).pressures[0])(0.1)]\n"
        "assert all(jnp.isfinite(s) and s.dtype == 'float32' for s in slopes)"
    )
