"""Tables of a benchmark: printed for people, or as JSON for programs."""

import json
import math
from collections.abc import Iterable
from dataclasses import dataclass, field

from vipr.systems.errors import InputError


@dataclass
class Table:
    """Rows of numbers and words under named columns."""

    title: str
    columns: tuple[str, ...]
    rows: list[tuple] = field(default_factory=list)
    note: str = ""

    def as_dict(self) -> dict:
        rows = [{c: _plain(v) for c, v in zip(self.columns, row, strict=True)} for row in self.rows]
        return {"title": self.title, "note": self.note, "rows": rows}


def chosen_parts(bench: str, only: Iterable[str] | None, parts: Iterable[str]) -> list[str]:
    """The parts of a benchmark that were asked for, all of them if none; InputError for one that it does not have."""
    parts, only = list(parts), list(only or ())
    for name in only:
        if name not in parts:
            raise InputError(f"bench {bench}: unknown part {name!r}, allowed are {', '.join(parts)}")
    return only or parts


def print_tables(tables: Iterable[Table]) -> None:
    """Each table on standard output as soon as it is there."""
    from rich import box
    from rich.console import Console
    from rich.table import Table as RichTable

    console = Console(width=None if Console().is_terminal else 160, highlight=False)
    for table in tables:
        shown = RichTable(
            title=table.title,
            title_justify="left",
            min_width=len(table.title) if len(table.title) < 150 else None,
            box=box.MARKDOWN,
        )
        for k, column in enumerate(table.columns):
            shown.add_column(column, justify="left" if k == 0 else "right")
        for row in table.rows:
            shown.add_row(*(_text(v) for v in row))
        console.print(shown)
        if table.note:
            console.print(table.note)
        console.print()


def print_json(tables: Iterable[Table]) -> None:
    """All tables as one JSON list."""
    print(json.dumps([table.as_dict() for table in tables], indent=2))


def _text(value):
    if isinstance(value, float):
        return "-" if math.isnan(value) else f"{value:.3g}" if abs(value) < 1000 else f"{value:.0f}"
    return str(value)


def _plain(value):
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value.item() if hasattr(value, "item") else value
