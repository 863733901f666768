from .api.case import Case as Case
from .api.case import load as load
from .api.planning import Plan as Plan
from .api.planning import plan as plan
from .api.result import Result as Result
from .api.running import run as run
from .api.section import Section as Section
from .api.signal import Signal as Signal
from .api.signal import norm as norm
from .api.sweeping import Sweep as Sweep
from .api.sweeping import sweep as sweep
from .solver.errors import InputError as InputError
from .solver.errors import PackageError as PackageError

__version__: str
