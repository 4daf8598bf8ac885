"""``report.html``: placeholder page."""

from html import escape


def make_report(summary, history, *, plots=(), limits=None, diagram=None) -> str:
    """The page."""
    return f"<!doctype html><title>{escape(summary['scenario'])}</title>"
