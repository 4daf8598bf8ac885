"""One example of every system, for the laws: how to build it and what to feed it.

``EXAMPLES[Class] = make`` where ``make()`` returns ``(system, fix_inputs)`` and ``fix_inputs(context, t)`` fixes every input port for
time t. A stage keeps its own in ``tests/systems/<stage>/examples.py`` with an ``EXAMPLES`` of the same form.
"""

import importlib
from pathlib import Path

EXAMPLES = {}

for _path in sorted(Path(__file__).parent.glob("*/**/examples.py")):
    _spec = importlib.util.spec_from_file_location(f"examples_{_path.parent.name}", _path)
    _module = importlib.util.module_from_spec(_spec)
    _spec.loader.exec_module(_module)
    EXAMPLES.update(_module.EXAMPLES)


def no_inputs(context, t):
    """For systems without inputs."""
