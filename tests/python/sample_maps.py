"""Maps for tests that need no particular ones."""

import json

import numpy as np

from pushbelt.maps import unit as map_unit
from pushbelt.maps.data import TABLES, Maps


def default_maps() -> Maps:
    """The maps of `bench168` in the resources, with zeros in the tables that they leave out."""
    document = json.loads(map_unit.default_maps().read_bytes())
    axes = {name: np.array(entry["values"]) for name, entry in document["axes"].items()}
    tables = {name: np.zeros([len(axes[axis]) for axis in one.axes]) for name, one in TABLES.items()}
    tables |= {name: np.array(entry["values"]) for name, entry in document["tables"].items()}
    return Maps(axes, tables, document["parameters"])
