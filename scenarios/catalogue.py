"""Every scenario by name."""

import difflib

from vipr.scenarios.align import Align, Follow
from vipr.scenarios.instruct import Instruct
from vipr.scenarios.pick import Pick
from vipr.scenarios.pick_and_place import PickAndPlace
from vipr.scenarios.place_by_showing import PlaceByShowing
from vipr.scenarios.scenario import Scenario
from vipr.scenarios.torque_switch import TorqueSwitch
from vipr.systems.errors import InputError

SCENARIOS: dict[str, type[Scenario]] = {
    scenario.name: scenario for scenario in (Instruct, Align, Follow, PlaceByShowing, Pick, PickAndPlace, TorqueSwitch)
}


def find_scenario(name: str) -> type[Scenario]:
    """The scenario of that name; InputError with the known names otherwise."""
    if name not in SCENARIOS:
        near = difflib.get_close_matches(name, SCENARIOS, n=1)
        hint = f" Did you mean {near[0]}?" if near else ""
        raise InputError(f"unknown scenario {name!r}; there are: {', '.join(SCENARIOS)}.{hint}")
    return SCENARIOS[name]
