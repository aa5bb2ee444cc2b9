"""Maps for tests that need no particular ones."""

import json

import numpy as np

from pushbelt.maps import unit as map_unit
from pushbelt.maps.data import TABLES, Maps
from pushbelt.maps.plan import Grid


def default_maps() -> Maps:
    """The maps of `bench168` in the resources. Thrust ratios over the utilisation are between those over the torque; other tables are 0."""
    document = json.loads(map_unit.default_maps().read_bytes())
    axes = {name: np.array(entry["values"]) for name, entry in document["axes"].items()} | {"utilisation": np.array(Grid.utilisation)}
    tables = {name: np.zeros([len(axes[axis]) for axis in one.axes]) for name, one in TABLES.items()}
    tables |= {name: np.array(entry["values"]) for name, entry in document["tables"].items()}
    for place in np.ndindex(tables["capacity"].shape[:3]):
        torques = axes["torqueShare"] * np.where(axes["torqueShare"] < 0.0, -tables["capacity"][place][0], tables["capacity"][place][1])
        tables["thrustRatio"][place] = np.interp(axes["utilisation"], torques, tables["thrustRatioAtShare"][place])
    return Maps(axes, tables, document["parameters"])
