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


def test_importing_the_package_loads_no_files_results_or_pictures():
    assert not loaded("import fascicle") & HEAVY


def test_the_laws_load_no_files_results_or_pictures():
    modules = loaded(
        "import fascicle as fs\n"
        "m = fs.Muscle.from_dimensions("
        "length=0.127, outer_radius=6.35e-3, wall_thickness=1.6e-3, braid_angle=0.576)\n"
        "m.force(1e5, 0.1)\n"
        "fs.Bundle([fs.MotorUnit(m)]).force([1e5], 0.1)"
    )
    assert not modules & HEAVY
    assert not modules & WITHOUT


@pytest.mark.parametrize(
    "arguments",
    [
        ("force", MUSCLE, "--pressure", "200kPa", "--strain", "0.1"),
        ("free-strain", MUSCLE, "--pressure", "200kPa"),
        ("bundle", BUNDLE, "--pressure", "300kPa,100kPa", "--strain", "0.1"),
        ("recruit", BUNDLE, "--force", "60N", "--strain", "0.1"),
        ("space", BUNDLE),
        ("efficiency", BUNDLE),
    ],
    ids=lambda arguments: arguments[0],
)
def test_a_command_for_laws_loads_no_jax(arguments):
    modules = loaded(
        "from fascicle.cli import main\n"
        f"try:\n    main({list(arguments)!r})\n"
        "except SystemExit as end:\n    assert end.code in (0, None)\n"
    )
    assert not modules & WITHOUT


def test_help_loads_no_jax():
    modules = loaded(
        "from fascicle.cli import main\n"
        "sys.argv = ['fascicle', '--help']\n"
        "try:\n    main()\n"
        "except SystemExit as end:\n    assert end.code in (0, None)\n"
    )
    assert not modules & {"jax", "jaxlib", "equinox", "numpy", "xarray", "matplotlib", "pint"}


def test_importing_switches_to_double_precision():
    assert "jax" in loaded(
        "import fascicle, jax.numpy as jnp\nassert jnp.asarray(1.0).dtype == 'float64'"
    )


def test_importing_leaves_the_environment_alone():
    loaded(
        "import os, jax\nbefore = dict(os.environ)\n"  # JAX has settings of its own
        "import fascicle as fs\nfs.example('kim2021_figure_6').force(1e5, 0.1)\n"
        "assert dict(os.environ) == before"
    )


def test_jax_is_switched_whenever_it_comes():
    checked = "assert jax.config.jax_enable_x64\nassert jax.numpy.asarray(1.0).dtype == 'float64'"
    for order in ("import jax, fascicle", "import fascicle, jax",
                  "import fascicle, jax.numpy, jax", "import fascicle.muscle, jax",
                  "import fascicle, importlib.util\nimportlib.util.find_spec('jax')\nimport jax",
                  ):  # fmt: skip
        loaded(f"{order}\n{checked}")


def test_single_precision_asked_for_is_kept_and_warned_about_once():
    loaded(
        "import os, warnings\nos.environ['JAX_ENABLE_X64'] = '0'\n"
        "with warnings.catch_warnings(record=True) as caught:\n"
        "    warnings.simplefilter('always')\n"
        "    import fascicle, jax.numpy as jnp\n"
        "ours = [w for w in caught if 'JAX_ENABLE_X64' in str(w.message)]\n"
        "assert len(ours) == 1, caught\n"
        "assert jnp.asarray(1.0).dtype == 'float32'"
    )


def test_derivatives_exist_in_single_precision():
    loaded(
        "import os, warnings\nos.environ['JAX_ENABLE_X64'] = '0'\n"
        "warnings.simplefilter('ignore')\n"
        "import fascicle as fs, jax, jax.numpy as jnp\n"
        "muscle, bundle = fs.example('kim2021_figure_6'), fs.example('kim2021_bundle_1_4')\n"
        "at = lambda P: jnp.array([344.7e3, P])\n"
        "recruit = fs.recruitment.recruit\n"
        "slopes = [jax.grad(muscle.free_strain)(34.5e3), jax.grad(muscle.force)(34.5e3, 0.13),\n"
        "    jax.grad(lambda m: m.force(34.5e3, 0.13))(muscle).length,\n"
        "    jax.grad(lambda P: bundle.free_strain(at(P)))(5e4),\n"
        "    jax.grad(lambda e: recruit(bundle, 60.0, e).pressures[0])(0.1)]\n"
        "assert all(jnp.isfinite(s) and s.dtype == 'float32' for s in slopes)"
    )
