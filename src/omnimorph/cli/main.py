"""The entry point: from arguments to an exit code.

==== ==============================================================================
0    done
1    our fault: a bug, or a case of `verify` that failed
2    the user's mistake: one line says where it is and what would be right
3    the flight did not complete; the run so far is written
130  interrupted (Ctrl-C): nothing half-written is left; 143 by ``kill``, 129 by a terminal
     that was closed
==== ==============================================================================
"""

from __future__ import annotations

import argparse
import atexit
import gc
import sys
import traceback
from collections.abc import Sequence
from importlib import import_module
from types import ModuleType
from typing import NoReturn

from omnimorph.cli import console, interrupts
from omnimorph.errors import InputError, nearest_name
from omnimorph.version import __version__

COMMANDS: dict[str, ModuleType] = {
    name: import_module(f"omnimorph.cli.{name.replace('-', '_')}")
    for name in (
        *("vehicles", "new-vehicle", "analyze", "compare", "scenarios", "fly", "view"),
        *("gains", "fit", "inertia", "reproduce", "verify", "bench"),
    )
}
"""Name of a command -> its module: SUMMARY, NEEDS, add_arguments(parser), answer(options)."""

OUR_FAULT, USERS_MISTAKE = 1, 2


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line.

    Parameters
    ----------
    arguments : sequence of str, optional
        What follows the program's name; those of the process by default.

    Returns
    -------
    int
        The exit code, see the head of this module.
    """
    words = list(sys.argv[1:] if arguments is None else arguments)
    try:
        options = parsed(words)
        command = COMMANDS[options.command]
        with interrupts.remembered():
            with interrupts.wait():
                for module in command.NEEDS:
                    import_module(module)
            if arguments is None:
                _collect_rarely()
            with console.printed_warnings():
                answer: console.Answer = command.answer(options)
        console.write(answer.as_json() if options.json else answer.text)
        if answer.complaint:
            console.complain(answer.complaint)
        return answer.code
    except SystemExit as end:  # the parser's own, after --help and --version
        console.finish()
        return end.code if isinstance(end.code, int) else 0
    except KeyboardInterrupt as stopped:
        console.complain("interrupted; " + (str(stopped) or "nothing was written."))
        return interrupts.exit_code()
    except InputError as mistake:
        console.complain(str(mistake))
        return USERS_MISTAKE
    except MemoryError:
        console.complain(
            "this takes more memory than there is; fly for less time or with longer steps."
        )
        return USERS_MISTAKE
    except Exception:
        if interrupts.pressed():  # a library made an error of its own of it
            console.complain("interrupted; nothing was written.")
            return interrupts.exit_code()
        traceback.print_exc()
        console.complain(
            f"this is our fault (omnimorph {__version__}); please report the lines above."
        )
        return OUR_FAULT


def _collect_rarely() -> None:
    """Let Python seldom look for garbage, in a process that ends soon and keeps what it makes."""
    gc.freeze()
    gc.set_threshold(20_000, 50, 50)
    atexit.register(gc.freeze)


def parsed(words: list[str]) -> argparse.Namespace:
    """Read the arguments; raise `InputError`, in one line, for those that cannot be used."""
    parser = _Parser(
        prog="omnimorph",
        description="Design, control and fly omnidirectional and morphing multirotors.",
        epilog="`omnimorph COMMAND --help` says more. Exit codes: 0 done, 2 a mistake in what was "
        "asked, 3 the flight did not complete, 130 interrupted (143 by `kill`), 1 our fault.",
        formatter_class=_Help,
        allow_abbrev=False,
    )
    parser.add_argument("--version", action="version", version=f"omnimorph {__version__}")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", title="commands")
    for name, module in COMMANDS.items():
        command = commands.add_parser(
            name,
            help=module.SUMMARY,
            description=module.__doc__,
            formatter_class=_Help,
            allow_abbrev=False,
        )
        module.add_arguments(command)
        command.add_argument(
            "--json", action="store_true", help="print one JSON object, for programs"
        )
    if not words:
        parser.print_help()
        parser.exit()
    if not words[0].startswith("-") and words[0] not in COMMANDS:
        near = nearest_name(words[0], COMMANDS)
        hint = f"did you mean {near}?" if near else f"known are {', '.join(COMMANDS)}."
        raise InputError(f"{words[0]!r} is not a command; {hint}")
    options, unknown = parser.parse_known_args(words)
    if unknown:
        asked = f"omnimorph {options.command or ''}".strip()
        raise InputError(f"{asked} does not take {unknown[0]!r}; see `{asked} --help`.")
    return options


class _Help(argparse.HelpFormatter):
    """Help with room for the names on the left, so that every line of it stays one line."""

    def __init__(self, prog: str) -> None:
        super().__init__(prog, max_help_position=20)


class _Parser(argparse.ArgumentParser):
    """A parser that raises our error, in one line, instead of printing its usage and leaving."""

    def error(self, message: str) -> NoReturn:
        raise InputError(f"{message.rstrip('.')}; see `{self.prog} --help`.")
