"""Every system of VIPR, held against the laws."""

import re

import numpy as np
import pytest
from pydrake.systems.framework import Diagram, LeafSystem

import vipr.systems

import laws
from examples import EXAMPLES

TIMES = np.arange(1, 9) * 0.04 + 0.001


@pytest.mark.parametrize("cls", laws.systems(LeafSystem), ids=lambda cls: cls.__name__)
class TestLeafSystem:
    def test_has_an_example(self, cls):
        assert cls in EXAMPLES, f"{cls.__name__} needs an example in tests/systems/<stage>/examples.py"

    def test_ports_are_documented(self, cls):
        laws.assert_ports_documented(EXAMPLES[cls]()[0])

    def test_is_context_pure_and_deterministic(self, cls):
        laws.assert_context_pure_and_deterministic(EXAMPLES[cls], TIMES)


def test_the_table_of_stages_names_every_system():
    table = vipr.systems.__doc__
    missing = [cls.__name__ for cls in laws.systems(LeafSystem) if not re.search(rf"\b{cls.__name__}\b", table)]
    assert not missing, f"the docstring of vipr.systems does not name {', '.join(missing)}"


@pytest.mark.parametrize("cls", laws.systems(Diagram), ids=lambda cls: cls.__name__)
class TestDiagram:
    def test_has_an_example(self, cls):
        assert cls in EXAMPLES, f"{cls.__name__} needs an example in tests/diagrams/examples.py"

    def test_ports_are_documented(self, cls):
        laws.assert_ports_documented(EXAMPLES[cls]()[0])

    def test_wires_are_typed(self, cls):
        laws.assert_wires_typed(EXAMPLES[cls]()[0])

    def test_no_truth_reaches_a_controller(self, cls):
        laws.assert_no_truth_reaches_a_controller(EXAMPLES[cls]()[0])
