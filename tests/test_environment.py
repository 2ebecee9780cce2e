"""Settings of the environment: words that mean something count, others are one sentence."""

from __future__ import annotations

import os

import pytest

from floquet.environment import check_environment
from floquet.errors import ParameterError
from floquet.exponents import stability
from floquet.models import flapping
from floquet.rotor import Rotor
from floquet.sweep import sweep
from floquet.validity import lock_windows

ROTOR = Rotor(lock_number=8.0)


@pytest.mark.parametrize(
    ("name", "value"),
    [*(("FLOQUET_THREADS", v) for v in ("abc", "0", "-1", "1.5", "²")), ("FLOQUET_NO_NUMBA", "maybe")],
)
def test_a_setting_that_means_nothing_is_refused(monkeypatch: pytest.MonkeyPatch, name: str, value: str) -> None:
    monkeypatch.setenv(name, value)
    for work in (
        lambda: stability(flapping(ROTOR, 0.3)),
        lambda: sweep(ROTOR, [0.3]),
        lambda: lock_windows(ROTOR),
    ):
        with pytest.raises(ParameterError, match=rf"{name}: '{value}' in the environment is n.*: give "):
            work()


@pytest.mark.parametrize(
    ("word", "plain"),
    [("", "0"), ("no", "0"), ("False", "0"), ("off", "0"), ("0", "0"), ("yes", "1"), ("TRUE", "1"), ("1", "1")],
)
def test_words_are_read_as_the_kernels_read_them(monkeypatch: pytest.MonkeyPatch, word: str, plain: str) -> None:
    monkeypatch.setenv("FLOQUET_NO_NUMBA", word)
    check_environment()
    assert os.environ["FLOQUET_NO_NUMBA"] == plain


@pytest.mark.parametrize("threads", ["", "1", "3"])
def test_numbers_of_threads_are_let_through(monkeypatch: pytest.MonkeyPatch, threads: str) -> None:
    monkeypatch.setenv("FLOQUET_THREADS", threads)
    monkeypatch.delenv("FLOQUET_NO_NUMBA", raising=False)
    check_environment()
    assert os.environ["FLOQUET_THREADS"] == threads and "FLOQUET_NO_NUMBA" not in os.environ
