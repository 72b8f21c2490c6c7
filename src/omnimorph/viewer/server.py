"""The server of a page: on loopback, on the port asked for, silent, and for this machine alone."""

from __future__ import annotations

import contextlib
import errno
import io
import ipaddress
import logging
import socket
from typing import Any

from omnimorph.errors import InputError

LOOPBACK = "127.0.0.1"

Viser = Any
"""A `viser.ViserServer` with its `guard`; viser is only there with the extra ``view``."""

_VISER = "1.1."  # the guard reaches into it; `pyproject.toml` asks for the same


def new_server(host: str = LOOPBACK, port: int = 0) -> Viser:
    """Start the server of a page, empty as yet; its ``guard`` knows who may use it.

    Parameters
    ----------
    host : str
        Where it listens; only `LOOPBACK` keeps other machines out.
    port : int
        0 for any that is free.

    Raises
    ------
    InputError
        If the port is in use or may not be taken, the host is not this machine's, viser is not
        installed, or the guard does not hold.
    """
    viser = viser_module()
    from omnimorph.viewer.guard import Guard

    # A browser that leaves in the middle of a word is no news, and neither is who is refused.
    logging.getLogger("websockets").setLevel(logging.CRITICAL)
    port = check_port(host, port)

    class Server(viser.ViserServer):  # type: ignore[misc, name-defined]
        """The same without the tunnel that would show the page to the whole internet."""

        def request_share_url(self, verbose: bool = False) -> None:
            return None

    guard = Guard(host)
    with contextlib.redirect_stdout(io.StringIO()):  # what a command prints is its own
        server = guard.start(lambda: Server(host=host, port=port, verbose=False))
    server.guard = guard
    if server.get_port() != port:  # somebody else was faster
        server.stop()
        raise _in_use(port)
    server.gui.configure_theme(
        show_logo=False, show_share_button=False, control_width="large", brand_color=(0, 114, 178)
    )
    return server


def address_of(server: Viser, host: str = LOOPBACK) -> str:
    """Return the address of a page, with what only those know to whom it was given."""
    return f"http://{host}:{server.get_port()}/{server.guard.token}/"


def viser_module() -> Any:
    """Return the module viser, which is loaded only where a page is wanted.

    Raises
    ------
    InputError
        If it is not installed, or another version of it.
    """
    try:
        import viser
    except ImportError:
        raise InputError(
            "the viewer needs viser, which is not installed: pip install 'omnimorph[view]'."
        ) from None
    if not viser.__version__.startswith(_VISER):
        raise InputError(
            f"the viewer needs viser {_VISER}x, not {viser.__version__}: "
            "pip install 'omnimorph[view]'."
        )
    return viser


def is_loopback(host: str) -> bool:
    """Return whether a host can be reached from this machine alone."""
    address = in_numbers(host)
    return host.lower() == "localhost" if address is None else address.is_loopback


def in_numbers(host: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address | None:
    """Return the address that a host is written as; None for a name, which may mean any."""
    try:
        return ipaddress.ip_address(host)
    except ValueError:
        return None


def check_port(host: str, port: int) -> int:
    """Return a port that can be taken: the one asked for, or a free one for 0.

    Raises
    ------
    InputError
        If it is in use or may not be taken, or if the host is not this machine's.
    """
    elsewhere = InputError.at(
        "the command line", "--host", host, f"an address of this machine, such as {LOOPBACK}"
    )
    if not host:  # would be every address of it
        raise elsewhere
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((host, port))
        except UnicodeError:
            raise elsewhere from None
        except OSError as error:
            if error.errno == errno.EADDRINUSE:
                raise _in_use(port) from None
            if error.errno in (errno.EACCES, errno.EPERM):
                allowed = "a port that you may take, from 1024 on"
                raise InputError.at("the command line", "--port", port, allowed) from None
            raise elsewhere from None
        free: int = probe.getsockname()[1]
    return free


def _in_use(port: int) -> InputError:
    return InputError(
        f"port {port} is in use; name another with --port, or 0 for any that is free."
    )


def stop(server: Viser) -> None:
    """Stop a server; what it would print about that is not said."""
    with contextlib.redirect_stdout(io.StringIO()):
        server.stop()
