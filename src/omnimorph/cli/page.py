"""What the commands that open a page have in common: its address, its server, its browser."""

from __future__ import annotations

import argparse
import os
import sys
import textwrap
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from omnimorph.cli import console
from omnimorph.cli.arguments import port_number
from omnimorph.errors import InputError

_DEFAULT_HOST, _DEFAULT_PORT = "127.0.0.1", 8080


def add_page_arguments(parser: argparse._ActionsContainer) -> None:
    """Add the arguments that say where a page is served."""
    parser.add_argument(
        "--host",
        metavar="HOST",
        help=f"listen there (default: {_DEFAULT_HOST}, which this machine alone can reach)",
    )
    parser.add_argument(
        "--port",
        type=port_number,
        metavar="P",
        help=f"listen on this port, 0 for any that is free (default: {_DEFAULT_PORT})",
    )
    parser.add_argument(
        "--no-browser", action="store_true", help="say where the page is, and do not open it"
    )


def check_no_page(options: argparse.Namespace, why: str) -> None:
    """Refuse an address where nothing is served; `why` says so in a clause."""
    for option in ("host", "port"):
        if getattr(options, option) is not None:
            raise InputError(f"the command line: --{option} is that of a page, and {why}.")


def announce(server: Any, options: argparse.Namespace, ends: str) -> None:
    """Say where the page is and how it ends, warn if others can reach it, open the browser."""
    import webbrowser

    from omnimorph.viewer.server import LOOPBACK, address_of, is_loopback

    host = _DEFAULT_HOST if options.host is None else options.host
    if not is_loopback(host):
        console.complain(
            f"warning: on {host}, whoever knows the address below, or reads along in the "
            "network, can see and steer the page."
        )
    address = address_of(server, LOOPBACK if host == "0.0.0.0" else host)
    opened = not options.no_browser and _has_a_screen() and webbrowser.open(address)
    hint = "" if opened or options.no_browser else _over_ssh(server.get_port())
    console.complain(f"the page is at {address} {hint}({ends}).")


@contextmanager
def served(options: argparse.Namespace) -> Iterator[Any]:
    """Serve a page, empty as yet, where it is asked for; report what goes wrong with it."""
    from omnimorph.viewer.server import new_server

    host = _DEFAULT_HOST if options.host is None else options.host
    server = new_server(host, _DEFAULT_PORT if options.port is None else options.port)
    server.guard.on_fault(_tell_fault)
    try:
        with closing(server):
            yield server
    finally:
        if server.guard.dropped:
            dropped = console.counted(server.guard.dropped, "message")
            console.complain(f"{dropped} that no control of the page sends had no effect.")


@contextmanager
def closing(server: Any) -> Iterator[Any]:
    """Stop a server in the end, quietly."""
    from omnimorph.viewer.server import stop

    try:
        yield server
    finally:
        stop(server)


def _tell_fault(error: Exception) -> None:
    reason = textwrap.shorten(f"{type(error).__name__}: {error}", 200)
    console.complain(f"a fault of the page, which is ours: {reason}")


def _has_a_screen() -> bool:
    """Return whether a browser opened here would be seen: not in a terminal from elsewhere."""
    if "BROWSER" in os.environ:
        return True
    if sys.platform in ("darwin", "win32"):
        return "SSH_CONNECTION" not in os.environ
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def _over_ssh(port: int) -> str:
    return (
        f"- no browser to open here; from elsewhere, `ssh -L {port}:127.0.0.1:{port} HOST` first - "
    )
