"""A viser server for browsers of this machine alone, or one line that says why there is none."""

from __future__ import annotations

import contextlib
import io
import socket
from collections.abc import Iterator
from typing import Any

from jawenv.base.errors import InputError, shown
from jawenv.base.extras import needs
from jawenv.base.numeric_fields import whole_number
from jawenv.live.look import TITLE

HOST = "127.0.0.1"
PORT = 8090
LARGEST_PORT = 65535


@contextlib.contextmanager
def serving(port: int = PORT) -> Iterator[Any]:
    """A ``viser.ViserServer`` on the loopback address, stopped at the end of the block.

    Args:
        port: 0 takes one that is free.

    Raises:
        InputError: the port is taken, or no number of a port.
        MissingPackageError: viser is not installed.
    """
    number = whole_number(port)
    if number is None or not 0 <= number <= LARGEST_PORT:
        raise InputError(f"port is {shown(port)}; allowed: a whole number, 0 to {LARGEST_PORT}")
    with needs("jawenv live", "viser", "live"):
        import viser
    from jawenv.live.admission import AccessRules

    _check_free(number)
    admission = AccessRules(HOST)
    with admission.installed(), contextlib.redirect_stdout(io.StringIO()):  # its table of addresses
        server: Any = viser.ViserServer(host=HOST, port=number, label=TITLE, verbose=False)
    admission.gui = server.gui
    try:
        if number and server.get_port() != number:  # viser takes the next one when it is too late
            raise _taken(number)
        yield server
    finally:
        with contextlib.redirect_stdout(io.StringIO()):
            server.stop()


def url_of(server: Any) -> str:
    """Address of the page for a browser."""
    return f"http://{HOST}:{server.get_port()}"


def _check_free(port: int) -> None:
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((HOST, port))
        except OSError:
            raise _taken(port) from None


def _taken(port: int) -> InputError:
    return InputError(f"port: {port} is taken or not allowed; give another one with --port, or 0 for a free one")
