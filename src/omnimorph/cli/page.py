"""What the commands that open a page have in common: its address, its server, its browser."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from omnimorph.cli import console
from omnimorph.cli.arguments import port_number

__all__ = ["add_page_arguments", "announce", "closing"]

_DEFAULT_PORT = 8080


def add_page_arguments(parser: argparse._ActionsContainer) -> None:
    """Add the arguments that say where a page is served."""
    parser.add_argument(
        "--host",
        default="127.0.0.1",
        metavar="HOST",
        help="listen there (default: 127.0.0.1, which this machine alone can reach)",
    )
    parser.add_argument(
        "--port",
        type=port_number,
        default=_DEFAULT_PORT,
        metavar="P",
        help=f"listen on this port, 0 for any that is free (default: {_DEFAULT_PORT})",
    )
    parser.add_argument(
        "--no-browser", action="store_true", help="say where the page is, and do not open it"
    )


def announce(server: Any, options: argparse.Namespace, ends: str) -> None:
    """Say where the page is and how it ends, warn if others can reach it, open the browser."""
    import webbrowser

    from omnimorph.viewer.server import is_loopback

    port = server.get_port()
    if not is_loopback(options.host):
        console.complain(
            f"warning: on {options.host}, whoever reaches this machine can see and steer the page."
        )
    shown = options.host if options.host != "0.0.0.0" else "127.0.0.1"
    address = f"http://{shown}:{port}"
    opened = not options.no_browser and _has_a_screen() and webbrowser.open(address)
    hint = "" if opened or options.no_browser else _over_ssh(port)
    console.complain(f"the page is at {address} {hint}({ends}).")


@contextmanager
def closing(server: Any) -> Iterator[Any]:
    """Stop a server in the end, quietly."""
    from omnimorph.viewer.server import stop

    try:
        yield server
    finally:
        stop(server)


def _has_a_screen() -> bool:
    """Tell whether a browser opened here would be seen: not in a terminal from elsewhere."""
    if "BROWSER" in os.environ:
        return True
    if sys.platform in ("darwin", "win32"):
        return "SSH_CONNECTION" not in os.environ
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def _over_ssh(port: int) -> str:
    return (
        f"- no browser to open here; from elsewhere, `ssh -L {port}:127.0.0.1:{port} HOST` first - "
    )
