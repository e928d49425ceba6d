"""fascicle: the open toolkit for fluidic artificial muscles (FAMs, McKibben muscles).

Laws are pure functions in SI units, written once, for numbers and arrays of NumPy. After
`import fascicle.jax` they take arrays of JAX, too, which compiles and differentiates them.
"""

from .core.lazy import attach_lazy


TYPE_CHECKING = False  # as `typing` has it, which takes longer to import than all of this
if TYPE_CHECKING:
    from . import calibrate as calibrate
    from . import control as control
    from . import design as design
    from . import dynamics as dynamics
    from . import fluid as fluid
    from . import laws as laws
    from . import plot as plot
    from . import records as records
    from .bundle import Bundle as Bundle
    from .bundle import MotorUnit as MotorUnit
    from .bundle import energetics as energetics
    from .bundle import recruitment as recruitment
    from .bundle import reversal as reversal
    from .bundle import schemes as schemes
    from .control import Joint as Joint
    from .core.errors import InvalidInputError as InvalidInputError
    from .files import catalog as catalog
    from .files import example as example
    from .files import examples as examples
    from .files import load as load
    from .files import save as save
    from .muscle import Constant as Constant
    from .muscle import MooneyRivlin as MooneyRivlin
    from .muscle import Muscle as Muscle
    from .muscle import MuscleTable as MuscleTable
    from .muscle import Switch as Switch
    from .muscle import Tuning as Tuning
    from .muscle import buckling as buckling
    from .muscle import collapse as collapse
    from .muscle import ends as ends
    from .muscle import materials as materials
    from .muscle import post_collapse as post_collapse
    from .muscle import tension as tension
    from .results import tables as tables

    __version__: str

# each name loads what it needs when it is first used: the command line's help needs no JAX,
# laws need no pint. A module's names; "" has those that are modules
_NAMES = {
    "": "calibrate control design dynamics fluid laws plot records",
    "bundle": "Bundle MotorUnit energetics recruitment reversal schemes",
    "control": "Joint",
    "core.errors": "InvalidInputError",
    "files": "catalog example examples load save",
    "muscle": (
        "Constant MooneyRivlin Muscle MuscleTable Switch Tuning buckling collapse ends "
        "materials post_collapse tension"
    ),
    "results": "tables",
}
_HOMES = {name: home for home, names in _NAMES.items() for name in names.split()}
__all__ = [*_HOMES]  # noqa: PLE0604  # pyright: ignore[reportUnsupportedDunderAll] the table's
__getattr__, __dir__ = attach_lazy(__name__, {**_HOMES, "__version__": "version"})
