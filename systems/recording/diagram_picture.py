"""``diagram.svg``: a diagram's systems and wires, drawn by Graphviz."""

import shutil
import subprocess
from pathlib import Path

from vipr.systems.recording.files import write_whole

CURE = "no diagram.svg: Graphviz is missing (apt-get install graphviz)"


def write_diagram(diagram, path: str | Path, max_depth: int | None = None) -> str:
    """Draw a Drake diagram (anything with ``GetGraphvizString``) as SVG.

    Args:
        diagram: the system to draw.
        path: the file to write.
        max_depth: levels of nested diagrams that are opened; all if None.

    Returns:
        "" if it was drawn, else one line that says why not and the cure: a run goes on without its picture.
    """
    program = shutil.which("dot")
    if program is None:
        return CURE
    graph = diagram.GetGraphvizString(max_depth=max_depth)
    drawn = subprocess.run([program, "-Tsvg"], input=graph.encode(), capture_output=True, check=False)
    if drawn.returncode:
        complaint = " ".join(drawn.stderr.decode(errors="replace").split())
        return f"no diagram.svg: Graphviz failed ({complaint[:200]})"
    write_whole(Path(path), drawn.stdout)
    return ""
