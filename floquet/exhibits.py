"""Numbered studies: a question answered by one table, one figure and a few numbers, and the page that shows them all.

A study is a short Python file in ``studies/tp1431``, ``table-1.py``, ``figure-3.py``, ``question-2.py`` …, whose
``exhibit()`` returns an :class:`Exhibit`.  Written into a folder, it becomes::

    NAME.png                the figure
    NAME.csv, NAME.md       the table
    index.html              all exhibits of the folder in order, with captions and numbers

Tables and figures carry the numbers of NASA TP-1431; questions are asked here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

__all__ = ["Exhibit"]


@dataclass(frozen=True, eq=False, kw_only=True)
class Exhibit:
    """What a numbered study shows.

    Attributes
    ----------
    title : str
        The report's caption, or the question.
    caption : str
        What is shown, what was chosen here because the report does not say, and what comes out.
    equations : tuple of str
        Numbers of the report's equations that are used.
    table : records
        Names → values, a record a row; complex numbers take two columns of the CSV file.
    numbers : name → number
        What a reader takes home; a test holds each against another source.
    figure : matplotlib.figure.Figure
        None where a table says it all.
    """

    title: str
    caption: str
    equations: tuple[str, ...] = ()
    table: Sequence[Mapping[str, Any]] = ()
    numbers: Mapping[str, float] = field(default_factory=dict)
    figure: Any = None
