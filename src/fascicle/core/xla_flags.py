"""XLA's option that makes fixed steps fast on a CPU.

XLA compiles a small loop as one function of machine code, and runs a larger one as a task for each
of its operations, which takes longer than to add a few numbers: 10 s of a bundle take 1 s instead
of 0.06. The option says up to how many bytes a loop is small.
"""

import os


_NAME = "xla_cpu_small_while_loop_byte_threshold"
_OPTION = "--xla_backend_extra_options"


def enable_whole_loops() -> None:
    """Add the option to `XLA_FLAGS`, unless they have one of its kind.

    XLA reads `XLA_FLAGS` when it first compiles: later it changes nothing.
    """
    flags = os.environ.get("XLA_FLAGS", "")
    if _NAME not in flags and _OPTION not in flags:  # a second one would replace the user's
        os.environ["XLA_FLAGS"] = f"{flags} {_OPTION}={_NAME}=100000000".strip()
