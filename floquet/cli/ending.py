"""The end of a command: every way out has its status."""

from __future__ import annotations

import errno
import sys
import warnings
from collections.abc import Callable, Sequence
from typing import Any, NoReturn

import click

from floquet.cli import talk
from floquet.cli.options import command
from floquet.errors import FailedError, FloquetError, FloquetWarning


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    """Run the command line and exit with its status."""
    warnings.showwarning = _shown_once(set())
    warnings.simplefilter("always", FloquetWarning)  # "once" forgets what was said when a library imports
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")
    sys.exit(_status(arguments))


def _status(arguments: Sequence[str] | None) -> int:
    try:
        status = command.main(arguments, prog_name="floquet", standalone_mode=False)
        if sys.stdout is not None:
            sys.stdout.flush()
        return int(status or 0)
    except (click.Abort, KeyboardInterrupt):
        talk.abandon_output()
        talk.say("floquet: interrupted")
        return 130
    except click.exceptions.NoArgsIsHelpError as error:
        error.show()
        return 2
    except click.ClickException as error:
        context = getattr(error, "ctx", None)
        where = f" (see {context.command_path} --help)" if context else ""
        return talk.fail(f"{error.format_message()}{where}", error.exit_code)
    except FloquetError as error:
        return talk.fail(str(error), 1 if isinstance(error, FailedError) else 2)
    except MemoryError:
        return talk.fail(
            "there is not enough memory for this; ask for fewer rows or columns, or for a smaller study", 1
        )
    except OSError as error:
        return _operating_system(error)


def _operating_system(error: OSError) -> int:
    """Trouble of the system is one sentence."""
    talk.abandon_output()
    where = f"{error.filename}: " if error.filename else ""
    way_out = "; make room and run the command again" if error.errno == errno.ENOSPC else ""
    return talk.fail(f"{where}{(error.strerror or str(error)).lower()}{way_out}", 1)


def _shown_once(said: set[str]) -> Callable[..., None]:
    """Shows each warning when it is new."""

    def show_warning(message: Warning | str, *_: Any, **__: Any) -> None:
        if (text := str(message)) not in said:
            said.add(text)
            talk.say(f"floquet: warning: {text}")

    return show_warning
