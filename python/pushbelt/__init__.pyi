from ._version import __version__ as __version__
from .calls import Program
from .errors import ArgumentError as ArgumentError
from .errors import FileError as FileError
from .errors import MissingFileError as MissingFileError
from .errors import MissingPackageError as MissingPackageError
from .errors import PushbeltError as PushbeltError
from .errors import UnknownNameError as UnknownNameError
from .errors import VariatorWarning as VariatorWarning
from .fmu.data import parameter_deviations as parameter_deviations
from .fmu.data import parameter_set as parameter_set
from .fmu.data import variators as variators
from .fmu.files import default_fmu as default_fmu
from .fmu.results import Bands as Bands
from .fmu.results import Profile as Profile
from .fmu.results import SteadyState as SteadyState
from .fmu.start_values import StartValueError as StartValueError
from .fmu.unit import UnitError as UnitError
from .fmu.untrusted import InputFileError as InputFileError
from .linear.grid import LinearGrid as LinearGrid
from .linear.grid import load_linear as load_linear
from .linear.model import LinearModel as LinearModel
from .linear.model import LinearPointError as LinearPointError
from .linear.physical import NotPhysicalError as NotPhysicalError
from .maps.data import MapError as MapError
from .maps.data import Maps as Maps
from .maps.variator import MapVariator as MapVariator
from .points import SteadyStateError as SteadyStateError
from .recording import Record as Record
from .variator import Snapshot as Snapshot
from .variator import Variator as Variator

calibrate: Program
drive: Program
maps: Program
sweep: Program
