"""Access to the page: pages of its own address alone may speak to it, with values that its controls have."""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Iterator, Sequence
from typing import Annotated, Any
from unittest import mock

import numpy as np
import viser
from msgspec import Meta, MsgspecError, Struct, msgpack, structs
from websockets.asyncio import server as websockets_server
from websockets.asyncio.server import ServerConnection
from websockets.http11 import Request, Response

from jawenv.base.errors import InputError
from jawenv.live.look import NOTICE_HTML, TITLE

_LARGEST_MESSAGE = 2**14  # bytes; those of a browser are below 500
_MOST_BROWSERS = 32
_LARGEST_NUMBER = 2**53  # what a browser's numbers count to
_HTTP_PORT = 80  # addresses leave it out
_MAY_FRAME = "frame-ancestors 'self' http://127.0.0.1:* http://localhost:* vscode-webview:"  # notebooks do
Length = Annotated[float, Meta(ge=-1e6, le=1e6)]
Pixels = Annotated[int, Meta(ge=1, le=100_000)]
Point = tuple[Length, Length, Length]


class _Camera(Struct, tag="ViewerCameraMessage", forbid_unknown_fields=True):
    wxyz: tuple[Length, Length, Length, Length]
    position: Point
    fov: Length
    near: Length
    far: Length
    image_height: Pixels
    image_width: Pixels
    look_at: Point
    up_direction: Point


class _Hotkey(Struct, tag="CommandTriggerMessage", forbid_unknown_fields=True):
    uuid: str


class _Setting(Struct, tag="GuiUpdateMessage", forbid_unknown_fields=True):
    uuid: str
    updates: dict[str, bool | float | str]


_DECODER = msgpack.Decoder(_Camera | _Hotkey | _Setting)


class AccessRules:
    """Rules for browsers of a viser server.

    A browser is admitted if its Host is the page's own address and its Origin is, too; who opens no websocket may have
    no Origin. Of the messages those are taken that move a camera, press a hotkey, or set a control to a value that it
    has. Others are dropped, requests to share the page among them.

    Args:
        host: address of the server.

    Attributes:
        gui: of the server; None while it has no controls that could be set.
    """

    def __init__(self, host: str) -> None:
        self._names = (host, "localhost")
        self.gui: Any = None

    @contextlib.contextmanager
    def installed(self) -> Iterator[None]:
        """Admit to the server that viser makes in this block."""
        serve, made = websockets_server.serve, []

        def guarded(handler: Any, *args: Any, process_request: Any, **options: Any) -> Any:
            made.append(handler)
            options |= {"max_size": _LARGEST_MESSAGE, "create_connection": self._connection, "logger": _silent()}
            return serve(handler, *args, process_request=self._answering(process_request), **options)

        with mock.patch.object(websockets_server, "serve", guarded):  # viser has no argument for it
            yield
        if not made:
            raise InputError(f"viser: {viser.__version__} cannot be guarded; allowed: the version of constraints.txt")

    def admits(self, raw: str | bytes) -> bool:
        """Whether a message is one that the page takes."""
        try:
            message = _DECODER.decode(raw) if isinstance(raw, bytes) else None
        except MsgspecError:
            return False
        if isinstance(message, _Setting):
            controls = {} if self.gui is None else self.gui._gui_input_handle_from_uuid
            return list(message.updates) == ["value"] and _has(controls.get(message.uuid), message.updates["value"])
        return isinstance(message, _Hotkey) or (isinstance(message, _Camera) and _is_finite(message))

    def _answering(self, process_request: Any) -> Any:
        """The handler of requests before viser's."""

        def answer(connection: ServerConnection, request: Request) -> Response | None:
            if not _is_own(request, self._names, connection.local_address[1]):
                return connection.respond(403, "The page is for browsers of this machine, at its own address.\n")
            if len(connection.server.connections) > _MOST_BROWSERS:
                return connection.respond(503, f"{_MOST_BROWSERS} connections are open already.\n")
            request.headers.pop("Accept-Encoding", None)  # so that the page comes as it is
            response: Response | None = process_request(connection, request)
            return response if response is None or b"</head>" not in (response.body or b"") else _named(response)

        return answer

    def _connection(self, *args: Any, **options: Any) -> ServerConnection:
        return _Connection(self, *args, **options)


class _Connection(ServerConnection):
    def __init__(self, admission: AccessRules, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self._admission = admission

    async def recv(self, decode: bool | None = None) -> Any:
        """The next message that is admitted."""
        while not self._admission.admits(raw := await super().recv(decode)):
            pass
        return raw


def _is_own(request: Request, names: Sequence[str], port: int) -> bool:
    """Whether a request was meant for this address, and comes from a page of it or from none."""
    own = [f"{name}:{port}" for name in names] + [name for name in names if port == _HTTP_PORT]
    hosts, origins = (request.headers.get_all(name) for name in ("Host", "Origin"))
    from_none = not origins and "Upgrade" not in request.headers
    return hosts in [[host] for host in own] and (from_none or origins in [[f"http://{host}"] for host in own])


def _named(response: Response) -> Response:
    """Viser's page with a title and a notice, in frames of this machine's pages alone."""
    page = bytes(response.body or b"").replace(b"<title>Viser</title>", f"<title>{TITLE}</title>".encode(), 1)
    response.body = page.replace(b"</body>", NOTICE_HTML.encode() + b"</body>", 1)
    del response.headers["Content-Length"]
    response.headers["Content-Length"] = str(len(response.body))
    response.headers["Content-Security-Policy"] = _MAY_FRAME
    return response


def _is_finite(camera: _Camera) -> bool:
    return bool(np.isfinite(np.hstack(structs.astuple(camera))).all()) and any(camera.wxyz)


def _has(control: Any, value: bool | float | str) -> bool:
    """Whether a control is seen and can have a value."""
    if control is None or not control.visible:
        return False
    if isinstance(control, viser.GuiButtonHandle):
        return value is True
    if isinstance(control, viser.GuiDropdownHandle | viser.GuiButtonGroupHandle):
        return value in control.options
    if not isinstance(control, viser.GuiSliderHandle | viser.GuiNumberHandle) or isinstance(value, bool | str):
        return False
    low = -_LARGEST_NUMBER if control.min is None else control.min
    high = _LARGEST_NUMBER if control.max is None else control.max
    return bool(low <= value <= high)


def _silent() -> logging.Logger:
    """Logger of websockets, silenced: it would print how strangers' connections fail."""
    logger = logging.getLogger("jawenv.live.websockets")
    logger.propagate = False
    logger.setLevel(logging.CRITICAL + 1)
    return logger
