"""Running studies: shards, resume, pack, merge.

A running study is a folder beside its database (``folder``) of ``shards``, which ``workers`` make, each whole or not at
all: the listing is the journal.  When all are there they are packed, checked, into the database (``packing``), and only
then removed (``running``).  ``extending`` finds what a database has of a study that has grown, ``merging`` makes one
database of several, and ``estimating`` says beforehand how much it is and how long it takes.
"""

from __future__ import annotations

from ..studyfile import Study, load_study
from .estimating import Estimate, dry_run
from .folder import parts_of
from .merging import merge
from .packing import pack
from .running import RunReport, run
from .workers import processes

__all__ = ["Estimate", "RunReport", "Study", "dry_run", "load_study", "merge", "pack", "parts_of", "processes", "run"]
