"""What a hostile web page may do: real handshakes and messages, as a browser on this machine would send them for it."""

import socket
import urllib.error
import urllib.request
from types import SimpleNamespace

import msgspec
import pytest
import viser
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from jawenv.live.page import Page
from jawenv.live.server import serving, url_of
from jawenv.live.setup import Setup
from tests.live.test_live_page import wait_until

CAMERA = {
    "type": "ViewerCameraMessage",
    "wxyz": [1, 0, 0, 0],
    "position": [3, 3, 3],
    "fov": 1.0,
    "near": 0.1,
    "far": 99.0,
    "image_height": 500,
    "image_width": 700,
    "look_at": [0, 0, 0],
    "up_direction": [0, 0, 1],
}


@pytest.fixture(scope="module")
def live(tmp_path_factory):
    """A page that nobody drives, and its server; wishes are fulfilled when a test asks for it."""
    with serving(0) as server:
        yield SimpleNamespace(page=Page(server, Setup.of(seed=500), tmp_path_factory.mktemp("drives")), server=server)


def joined(server, origin=None, host=None, sock=None):
    """A websocket of a page of some origin."""
    port = server.get_port()
    return connect(
        f"ws://{host or '127.0.0.1'}:{port}",
        sock=sock,
        origin=f"http://127.0.0.1:{port}" if origin is None else origin.replace("PORT", str(port)) or None,
        subprotocols=[f"viser-v{viser.__version__}"],
        compression=None,
        max_size=None,
    )


def status_of(server, host):
    request = urllib.request.Request(url_of(server), headers={"Host": host.replace("PORT", str(server.get_port()))})
    with pytest.raises(urllib.error.HTTPError) as refused:
        urllib.request.urlopen(request, timeout=10)
    refused.value.close()
    return refused.value.code


ORIGINS = (
    "https://evil.example",
    "http://127.0.0.1:PORT.evil.example",
    "http://127.0.0.1:1",
    "https://localhost:PORT",
    "null",
    "",
)


@pytest.mark.parametrize("origin", ORIGINS)
def test_a_page_of_another_origin_is_refused(live, origin):
    with pytest.raises(InvalidStatus) as refused:
        joined(live.server, origin)
    assert refused.value.response.status_code == 403


def test_the_pages_own_origin_is_admitted(live):
    for origin in ("http://127.0.0.1:PORT", "http://localhost:PORT"):
        with joined(live.server, origin) as browser:
            assert browser.recv(timeout=20)


@pytest.mark.parametrize("host", ["evil.example:PORT", "evil.example", "127.0.0.1:1", "localhost.:PORT"])
def test_a_name_that_was_bound_to_this_machine_gets_neither_page_nor_websocket(live, host):
    assert status_of(live.server, host) == 403


def test_a_rebound_name_opens_no_websocket(live):
    for origin in (None, "http://evil.example:PORT"):
        with socket.create_connection(("127.0.0.1", live.server.get_port())) as sock:
            with pytest.raises(InvalidStatus) as refused:
                joined(live.server, origin, "evil.example", sock)
        assert refused.value.response.status_code == 403


def test_the_page_has_a_title_and_says_what_it_is_and_is_framed_by_this_machine_alone(live):
    with urllib.request.urlopen(url_of(live.server), timeout=10) as answer:
        page = answer.read().decode()
        assert "frame-ancestors 'self'" in answer.headers["Content-Security-Policy"]
    assert "<title>jawenv live</title>" in page and "Simulated, for research, not a medical device." in page


class Browser:
    """A browser that sends what it likes."""

    def __init__(self, live):
        self.live, self.socket = live, joined(live.server)
        self.send(**CAMERA)
        wait_until(lambda: live.server.get_clients())

    def send(self, **message):
        self.socket.send(msgspec.msgpack.encode(message))

    def set(self, control, value, name="value"):
        self.send(type="GuiUpdateMessage", uuid=control._impl.uuid, updates={name: value})

    def is_heard(self):
        """Messages that are taken still arrive, and so all before it have."""
        roll = self.live.page._sliders[3]
        value = 0.25 if roll.value != 0.25 else 0.5
        self.set(roll, value)
        wait_until(lambda: roll.value == value)


@pytest.fixture
def browser(live):
    sender = Browser(live)
    yield sender
    sender.socket.close()


def test_a_share_request_opens_no_connection(live, browser, monkeypatch):
    asked = []
    monkeypatch.setattr(live.server, "request_share_url", lambda *_: asked.append("share"))
    monkeypatch.setattr(live.server, "disconnect_share_url", lambda *_: asked.append("end"))
    monkeypatch.setattr("viser._viser.ViserTunnel", lambda *_: asked.append("tunnel"))
    browser.send(type="ShareUrlRequest")
    browser.send(type="ShareUrlDisconnect")
    browser.is_heard()
    live.server._thread_executor.submit(lambda: None).result()
    assert asked == []


def controls(page):
    return {
        "opening": page._sliders[0],
        "driver": page._driver,
        "ghost": page._ghosts,
        "drive": page._buttons,
        **page._choices.fields,
    }


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("opening", [float("nan"), float("inf"), -0.1, 1.1, 1e9, True, "0.3", None, [0.3], {"a": 1}]),
        ("driver", ["/etc/passwd", "x.yaml", "", "a\0.yaml", "<b>", "you ", 3, True, "y" * 2000]),
        ("ghost", ["you", "nonsense"]),
        ("drive", ["Nope", True, 0]),
        ("seed", [-1, 2**32, 2**60, 1e30, float("nan"), True, "7"]),
        ("cohort", ["../x", "secret.yaml"]),
        ("episode_s", [0.0, 601.0, float("nan")]),
    ],
)
def test_a_value_that_a_control_cannot_have_does_not_arrive(live, browser, name, values):
    control = controls(live.page)[name]
    before = control.value
    for value in values:
        browser.set(control, value)
    browser.is_heard()
    assert control.value == before


def test_other_properties_and_messages_are_dropped(live, browser, capfd):
    opening = live.page._sliders[0]
    for name, value in (("removed", True), ("update_cb", [1]), ("sync_cb", "x"), ("max", 9.0), ("visible", False)):
        browser.set(opening, value, name)
    browser.send(type="GuiUpdateMessage", uuid=opening._impl.uuid, updates={"value": 0.1, "removed": True})
    browser.send(type="GuiUpdateMessage", uuid="nobody", updates={"value": 0.1})
    browser.send(type="GuiUpdateMessage")
    browser.send(type="GuiFormDirtyMessage", uuid="x")
    browser.send(type="Nope")
    for changed in ({"image_height": 0}, {"fov": float("nan")}, {"wxyz": [0, 0, 0, 0]}, {"position": [1]}, {"more": 1}):
        browser.send(**CAMERA | changed)
    for raw in (b"", b"\xc1", b"\x91" * 5000, "text"):
        browser.socket.send(raw)
    browser.is_heard()
    assert not opening._impl.removed and opening.max == 1.0 and opening.visible
    assert "Traceback" not in "".join(capfd.readouterr())


def test_a_message_that_is_too_large_ends_its_connection_alone(live, browser, capfd):
    large = Browser(live)
    large.set(live.page._driver, "x" * 2**20)
    wait_until(lambda: len(live.server.get_clients()) == 1)
    browser.is_heard()
    assert "Traceback" not in "".join(capfd.readouterr())
