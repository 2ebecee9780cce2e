"""Rotors of data/rotors by the name of their file."""

from __future__ import annotations

from pathlib import Path

from floquet import Rotor
from floquet.rotor import load_rotor

FOLDER = Path(__file__).resolve().parents[2] / "data" / "rotors"
REAL = ("bo105", "lynx", "puma", "uh60a")
NAMES = {"tp1431-fig6": "γ = 8, ε = 0", "tp1431-fig7": "γ = 8, ε = 0.15", "teetering-nominal": "teetering, γ = 6"}
"""Those that are no aircraft's, by what they are."""


def rotor(name: str) -> Rotor:
    """The rotor of a file, under a name that fits a figure."""
    found = load_rotor(FOLDER / f"{name}.toml")
    return found.replace(name=NAMES.get(name, found.name))
