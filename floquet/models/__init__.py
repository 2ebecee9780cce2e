"""The equations and nothing else: a file per model, each reading as the report's equation."""

from .flapping import FORCING, flapping
from .multiblade import multiblade
from .physics import Physics, PhysicsKeywords
from .teetering import teetering
from .tip_path_plane import averaged, tip_path_plane

__all__ = ["FORCING", "Physics", "PhysicsKeywords", "averaged", "flapping", "multiblade", "teetering", "tip_path_plane"]
