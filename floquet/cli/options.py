"""The group of all commands, and the options that several of them take."""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable
from typing import Any, TypeVar

import click

from floquet import __version__
from floquet.environment import check_environment
from floquet.errors import did_you_mean

Command = TypeVar("Command", bound=Callable[..., Any])

ROTOR_FLAGS: tuple[tuple[str, Any, str], ...] = (
    ("lock_number", float, "Lock number γ."),
    ("hinge_offset", float, "Flap hinge offset ε = e/R."),
    ("hinge_stiffness", float, "Hinge spring κ = K_β/(I_β Ω²)."),
    ("pitch_flap_coupling", float, "Pitch-flap coupling K₁ = tan δ₃."),
    ("offset_mass_ratio", float, "e M_β/I_β (left out: ε times the static moment ratio)."),
    ("static_moment_ratio", float, "R M_β/I_β (left out: 1.5)."),
    ("flap_damping", float, "Mechanical flap damping C_β/(I_β Ω)."),
    ("root_cutout", float, "No lift inboard of this fraction of the radius."),
    ("blades", int, "Number of blades."),
    ("rotor_speed", float, "Ω in rad/s, for output in Hz and seconds, and for knots."),
    ("radius", float, "R in m, for knots."),
    ("name", str, "What to call the rotor."),
)
"""The fields of Rotor as flags (and ``--hub``); a test holds them against ``Rotor``."""


class Word(click.Choice[str]):
    """A choice that suggests the nearest word."""

    def __init__(self, *words: str) -> None:
        super().__init__(words, case_sensitive=False)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        try:
            return super().convert(value, param, ctx)
        except click.BadParameter as error:
            if near := did_you_mean(str(value).lower(), [str(word) for word in self.choices]):
                self.fail(error.message.rstrip(".") + near, param, ctx)
            raise


MODES = Word("regressing", "coning", "advancing", "differential")
METRICS = Word("relative", "absolute", "frequency", "damping")


def options(*made: Callable[[Command], Command]) -> Callable[[Command], Command]:
    """Several options as one decorator, shown in the order given."""
    return lambda command: functools.reduce(lambda inner, option: option(inner), reversed(made), command)


def flag(name: str) -> str:
    return "--" + name.replace("_", "-")


rotor_flags = options(
    *(click.option(flag(name), type=kind, default=None, help=text) for name, kind, text in ROTOR_FLAGS),
    click.option("--hub", type=Word("articulated", "teetering"), help="How the blades are held."),
)
physics_flags = options(
    click.option("--model", type=Word("flapping", "teetering"), help="Equations of motion (left out: by the hub)."),
    click.option("--exact-offset", is_flag=True, help="Integrals exact in ε in place of the truncation at ε²."),
    click.option("--reversed-flow", is_flag=True, help="Lift reverses where the blade is flown over from behind."),
    click.option("--tip-loss", type=float, default=None, help="No lift outboard of this fraction of the radius."),
    click.option("--kinematic-rates", is_flag=True, help="(1 + m) in the columns of body angular acceleration."),
)
tolerance_flags = options(
    click.option(
        "--tolerance",
        type=float,
        default=0.05,
        show_default=True,
        help="Error at which a mode fails: 0.05 is 5 %, for the metric absolute 0.05 per rev.",
    ),
    click.option("--metric", type=METRICS, default="relative", show_default=True, help="How the error is measured."),
    click.option("--mode", "modes", type=MODES, multiple=True, help="Only this mode (may be repeated)."),
    click.option("--mu-max", type=float, help="Last advance ratio looked at (left out: 1)."),
)


def _style(context: click.Context, option: click.Parameter, chosen: bool) -> None:
    """Keep the one style that was asked for."""
    before = context.params.setdefault("style", None)
    if chosen and before is not None:
        raise click.UsageError("--json and --csv are two answers: give one of them", context)
    if chosen:
        if hasattr(sys.stdout, "reconfigure"):  # what programs read is UTF-8, whatever the terminal has
            sys.stdout.reconfigure(encoding="utf-8")
        context.params["style"] = str(option.name).removeprefix("as_")


output_flags = options(
    click.option("--json", "as_json", is_flag=True, expose_value=False, callback=_style,
                 help="Strict JSON: nan is null, inf is \"inf\"."),
    click.option("--csv", "as_csv", is_flag=True, expose_value=False, callback=_style, help="Comma-separated values."),
)  # fmt: skip
knots_flag = click.option("--knots", type=float, help="Speed V in place of --advance-ratio: μ = V/(ΩR), disc level.")
workers_flag = click.option(
    "--workers", type=click.IntRange(min=1), help="Processes (left out: one for each processor)."
)
table_flag = click.option("--table", default="points", show_default=True, help="points or limits.")
output_file = click.option("-o", "--output", required=True, help="File to write.")


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110})
@click.version_option(__version__, prog_name="floquet", message="%(prog)s %(version)s")
def command() -> None:
    """How stable a rotor is in forward flight, exactly, and where the tip-path-plane model stops being valid.

    A rotor comes from a TOML file, from flags such as --lock-number 8, or from both: flags override the file.
    """
    check_environment()
