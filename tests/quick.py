"""What runs once or twice is compiled in a hurry, and found by the next run: tests and docs."""

import os
from pathlib import Path


# making such programs fast costs more than they take: a quarter of the compiler's time, the same
# numbers to rounding. `make slow` compiles as a user does
_IN_A_HURRY = (
    "--xla_backend_optimization_level=0",
    "--xla_cpu_use_fusion_emitters=false",
    "--xla_cpu_parallel_codegen_split_count=1",
)


def compile_in_a_hurry(root: Path) -> Path:
    """Say so to JAX, before it computes; the folder where processes share what they compiled."""
    folder = root / ".pytest_cache" / "compiled"
    folder.mkdir(parents=True, exist_ok=True)
    os.environ.setdefault("JAX_COMPILATION_CACHE_DIR", str(folder))
    os.environ.setdefault("JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS", "0.2")
    os.environ.setdefault("XLA_FLAGS", " ".join(_IN_A_HURRY))
    return folder
