"""``stability(flapping(rotor, μ))`` and ``stability(multiblade(rotor, μ))``: public functions, as users call them."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
from collections.abc import Iterator, Mapping
from functools import partial
from multiprocessing.connection import Connection
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.peers import Call, Contender
from floquet import Rotor, flapping, multiblade, stability

Array = NDArray[np.float64]
DEFAULT: Mapping[str, Any] = MappingProxyType({})
SETTINGS: dict[str, Mapping[str, Any]] = {"default": DEFAULT}
"""Name of a setting → keywords of ``stability``."""
WAYS: dict[str, Mapping[str, Any]] = {"from one blade": DEFAULT, "all coordinates": {"symmetry": False}}
"""Name of a way to treat N identical blades → keywords of ``stability``."""
BATCH = 16384
MANY = 2048
"""Of rotors with all their coordinates."""
WITHOUT_NUMBA = "FLOQUET_NO_NUMBA"


def contenders(blades: int) -> Iterator[Contender]:
    if blades > 1:
        for setting, ways in WAYS.items():
            prepare = partial(rotor_call, blades=blades, ways=ways)
            yield Contender(name="floquet", setting=setting, prepare=prepare, batch=MANY)
        return
    for setting, options in SETTINGS.items():
        yield Contender(name="floquet", setting=setting, prepare=partial(blade_call, options=options), batch=BATCH)
    yield Contender(name="floquet without numba", setting="", prepare=Elsewhere, batch=BATCH)


def rotor_of(points: Array, blades: int = 1) -> Rotor:
    gamma, eps, kappa, K1, _ = points.T
    return Rotor(lock_number=gamma, hinge_offset=eps, hinge_stiffness=kappa, pitch_flap_coupling=K1, blades=blades)


def blade_call(points: Array, *, options: Mapping[str, Any] = DEFAULT) -> Call:
    """From the parameters on: nothing is prepared."""
    return lambda: stability(flapping(rotor_of(points), points[:, 4]), **options).exponents


def rotor_call(points: Array, *, blades: int, ways: Mapping[str, Any] = DEFAULT) -> Call:
    return lambda: stability(multiblade(rotor_of(points, blades), points[:, 4]), **ways).exponents


class Elsewhere:
    """The same in a process without numba, which answers a call with a word: its exponents cross over only once."""

    def __init__(self, points: Array) -> None:
        here, there = multiprocessing.Pipe()
        context = multiprocessing.get_context("spawn")
        self.process = context.Process(target=_serve, args=(there, points), daemon=True)
        before = os.environ.get(WITHOUT_NUMBA)
        os.environ[WITHOUT_NUMBA] = "1"
        try:
            self.process.start()
        finally:
            os.environ.pop(WITHOUT_NUMBA) if before is None else os.environ.update({WITHOUT_NUMBA: before})
        self.pipe = here
        self.answer = here.recv()

    def __call__(self) -> Any:
        self.pipe.send(True)
        self.pipe.recv()
        return self.answer


def _serve(pipe: Connection, points: Array) -> None:
    call = blade_call(points)
    pipe.send(call())
    with contextlib.suppress(EOFError):  # the benchmark has ended
        while pipe.recv():
            call()
            pipe.send(True)
