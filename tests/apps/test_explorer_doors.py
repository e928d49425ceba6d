"""The explorer's server as strangers find it: over HTTP and websockets, without a browser."""

import asyncio
import base64
import contextlib
import http.client
import io
import json
import os
import re
import signal
import subprocess
import sys

import pytest


pytest.importorskip("panel")
from tornado.websocket import websocket_connect


pytestmark = pytest.mark.filterwarnings("ignore::ResourceWarning")
COMMAND = [sys.executable, "-m", "fascicle", "explore", "--no-show"]


def started(*arguments):
    return subprocess.Popen(
        [*COMMAND, *arguments], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        env=os.environ,
    )  # fmt: skip


@pytest.fixture(scope="module")
def port():
    """A server's port, allowed a name besides its own."""
    process = started("--allow-host", "lab.example")
    said = []
    for line in process.stdout:
        said.append(line)
        if found := re.search(r":(\d+)/", line):
            break
    else:
        pytest.fail("".join(said))
    yield int(found[1])
    process.send_signal(signal.SIGINT)
    rest = process.communicate(timeout=60)[0]
    assert "Traceback" not in rest
    assert "Zen of Python" not in rest


def get(port, path="/", **headers):
    """Status and body of a page."""
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=60)
    connection.request("GET", path, headers=headers)
    answer = connection.getresponse()
    body = "" if answer.status == 101 else answer.read().decode(errors="replace")
    connection.close()
    return answer.status, body


def token_of(port):
    """Token of a new page."""
    return re.search(r'"token":"([^"]+)"', get(port)[1])[1]


def opens(port, host, origin):
    """Whether a websocket of this page is opened."""
    status, _ = get(
        port, "/ws", Host=host, Origin=origin, Upgrade="websocket", Connection="Upgrade",
        **{"Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==", "Sec-WebSocket-Version": "13",
           "Sec-WebSocket-Protocol": f"bokeh, {token_of(port)}"},
    )  # fmt: skip
    assert status in (101, 403)
    return status == 101


def test_a_rebound_name_reads_nothing(port):
    for host in (f"evil.example:{port}", "evil.example"):
        status, body = get(port, Host=host)
        assert (status, "evil.example" in body, "--allow-host" in body) == (403, True, True)
        assert "token" not in body
        assert not opens(port, host, f"http://{host}")


def test_its_own_names_read(port):
    for host in (f"127.0.0.1:{port}", f"localhost:{port}", "localhost:9999", "lab.example"):
        assert get(port, Host=host)[0] == 200
        assert opens(port, host, f"http://{host}")
    assert not opens(port, f"127.0.0.1:{port}", "http://localhost:3000")


def test_no_other_site_shows_an_answer_in_a_frame_or_guesses_its_type(port):
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=60)
    connection.request("GET", "/")
    headers = connection.getresponse().headers
    connection.close()
    assert headers["Content-Security-Policy"] == "frame-ancestors 'self'"
    assert headers["X-Content-Type-Options"] == "nosniff"


@pytest.mark.parametrize("query", ["tab=%00", "theme=%3Cscript%3Ealert", "%FF=%FF"])
def test_other_links_open_the_page(port, query):
    status, body = get(port, f"/?{query}")
    assert status == 200
    assert "<script>alert" not in body


def test_no_module_is_imported_by_its_name_in_an_address(port):
    # `import this` prints: the server's output is looked at in the end
    for path in ("/components/this/x/css/y", "/autoload.js", "/metadata", "/static/js/%00"):
        assert get(port, path)[0] == 404


PATCHES = (
    {"events": [{"kind": "ModelChanged", "model": {"id": "none"}, "attr": "value", "new": 3}]},
    {"events": [{"kind": "RootAdded", "model": {"id": "none"}}]},
    {"events": [{"kind": "Nonsense\n\x1b[31m"}]},
    {},
    [],
)


@contextlib.asynccontextmanager
async def connected(port):
    """Websocket of a new page, after the server's greeting."""
    token = await asyncio.to_thread(token_of, port)
    socket = await websocket_connect(f"ws://127.0.0.1:{port}/ws", subprotocols=["bokeh", token])
    for _ in range(3):  # header, metadata and content
        await socket.read_message()
    yield socket
    socket.close()
    if socket.close_code is None:  # else it has been closed
        await closed(socket)


async def closed(socket):
    """Wait until the server has closed a socket."""
    async with asyncio.timeout(60):
        while await socket.read_message() is not None:
            pass


async def send(socket, patch):
    """Send a message with a `patch`."""
    for part in ({"msgid": "1", "msgtype": "PATCH-DOC"}, {}, patch):
        await socket.write_message(json.dumps(part))


async def send_patches(port):
    """Open a page for each of the malformed patches, send it, and wait for the answer."""
    for patch in PATCHES:
        async with connected(port) as socket:
            await send(socket, patch)
            header, *_ = [json.loads(await socket.read_message()) for _ in range(3)]
        assert header["msgtype"] == "ERROR"


@pytest.mark.parametrize("name", ["bokeh-session-id", "bokeh-token", "Bokeh%2DSession%2DId"])
def test_nobody_chooses_a_session(port, name):
    assert get(port, f"/?{name}=lure")[0] == 403
    assert get(port, **{name.replace("%2D", "-"): "lure"})[0] == 403


def ids(value, **attributes):
    """Ids of the models with these `attributes` in a `value` of a message."""
    if isinstance(value, dict):
        if attributes.items() <= value.get("attributes", {}).items():
            yield value["id"]
        value = list(value.values())
    if isinstance(value, list):
        for item in value:
            yield from ids(item, **attributes)


async def wait_for(socket, text):
    """Content of the next message with this `text`."""
    async with asyncio.timeout(60):
        while text not in (part := str(await socket.read_message())):
            pass
    return json.loads(part)


async def answers_meanwhile(port, raw):
    """Number of answers to another visitor while the file `raw` is read."""
    data = {"type": "event", "name": "document_ready", "values": {"type": "map", "entries": []}}
    ready = {"kind": "MessageSent", "msg_type": "bokeh_event", "msg_data": data}
    upload = {"mime_type": "", "filename": "a.xlsx", "value": base64.b64encode(raw).decode()}
    async with connected(port) as socket:
        await send(socket, {"events": [ready]})
        (file,) = ids(await wait_for(socket, "Open a file"), title="Open a file")
        change = {"kind": "ModelChanged", "model": {"id": file}}
        await send(socket, {"events": [change | {"attr": k, "new": v} for k, v in upload.items()]})
        await wait_for(socket, "reading a.xlsx")
        reading, count = asyncio.create_task(wait_for(socket, "export the readings")), 0
        while not reading.done():
            await asyncio.to_thread(get, port, "/favicon.ico")
            count += not reading.done()
        await reading
    return count


def test_nobody_waits_for_the_file_of_another(port):
    sheet = pytest.importorskip("openpyxl").Workbook()
    sheet.active.append(["pressure [kPa]", "strain", "force [N]"])
    sheet.active.cell(2**18, 3, 1.0)  # empty rows above it take a second
    file = io.BytesIO()
    sheet.save(file)
    # one may arrive just when the file has been read
    assert asyncio.run(answers_meanwhile(port, file.getvalue())) > 1


def test_malformed_patches_are_a_line_each_in_the_terminal():
    process = started()
    while not (found := re.search(r":(\d+)/", process.stdout.readline())):
        assert process.poll() is None
    asyncio.run(send_patches(int(found[1])))
    process.send_signal(signal.SIGINT)
    *lines, last = process.communicate(timeout=60)[0].splitlines()
    assert last.startswith("stopped")
    assert len(lines) == len(PATCHES)
    assert all(line.isprintable() and "error" in line.lower() for line in lines)


def test_ctrl_c_at_the_start_ends_it_at_once():
    environment = {**os.environ, "FASCICLE_NO_CACHE": "1"}
    environment.pop("JAX_COMPILATION_CACHE_DIR", None)
    process = subprocess.Popen(
        COMMAND, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment
    )
    assert "starting" in process.stdout.readline()
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=60)
    assert (out, err) == ("", "")
    assert process.returncode == 130
