"""The equations and nothing else: a file per model, each reading as the report's equation."""

from .flapping import flapping
from .hover import hover_modes, hover_response
from .inputs import FORCING, input_vector
from .multiblade import multiblade
from .physics import Physics, PhysicsKeywords
from .teetering import teetering
from .tip_path_plane import averaged, tip_path_plane

__all__ = [
    "FORCING", "Physics", "PhysicsKeywords", "averaged", "flapping", "hover_modes", "hover_response", "input_vector",
    "multiblade", "teetering", "tip_path_plane",
]  # fmt: skip
