"""Fast compilation of programs that run once or twice, shared between processes: tests and docs."""

import os
from pathlib import Path


# optimizing such programs takes longer than running them: a quarter of the compiler's time, the
# same numbers to rounding. No pass of XLA is off, and `make slow` compiles as a user does
_FAST_COMPILATION = (
    "--xla_backend_optimization_level=0",
    "--xla_cpu_use_fusion_emitters=false",
    "--xla_cpu_parallel_codegen_split_count=1",
)


def compile_fast(root: Path) -> Path:
    """Set XLA's options before JAX computes; the folder where processes share compiled programs."""
    folder = root / ".pytest_cache" / "compiled"
    folder.mkdir(parents=True, exist_ok=True)
    os.environ.setdefault("JAX_COMPILATION_CACHE_DIR", str(folder))
    os.environ.setdefault("JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS", "0.2")
    os.environ.setdefault("XLA_FLAGS", " ".join(_FAST_COMPILATION))
    return folder
