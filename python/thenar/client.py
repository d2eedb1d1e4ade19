# SPDX-License-Identifier: Apache-2.0
"""A client of a running window, `thenar demo`, over the socket of docs/reference/window.md. It needs numpy alone.

    with connect("http://127.0.0.1:8470/?token=...") as window:
        for state in window:
            window.send("poke", force_N=-0.1 * state["force_N"][:3])
"""
import base64, collections.abc, contextlib, hashlib, json, os, socket, urllib.parse
from typing import Any
import numpy as np


class WindowError(RuntimeError):
    """The window refused something, or cannot be reached; the text says what, and why."""


class Window(collections.abc.Iterator, contextlib.AbstractContextManager):
    """A connection, for one thread, to the address that the program printed, or to "host:port" with the token; an
    iterator over the states. `scene`, `status` and `grasps` are the last messages of these types, `geometry` has the
    last one's bytes. TimeoutError: nothing came for `timeout_s`. Who reads nothing for 20 s is dropped."""

    def __init__(self, address: str, token: str = "", timeout_s: float = 10.0) -> None:
        self.scene, self.status, self.grasps = (dict[str, Any]() for _ in range(3))
        self.geometry, self._bytes, self._asked = b"", b"", False
        url = urllib.parse.urlsplit(address if "//" in address else f"//{address}")
        token, key = token or url.query.partition("token=")[2], base64.b64encode(os.urandom(16)).decode()
        try:
            self._socket = socket.create_connection((url.hostname, url.port or 80), timeout_s)
        except (OSError, ValueError) as fault:
            raise WindowError(f"{address}: no window is there: {fault}") from fault
        self._socket.sendall(f"GET /live?token={token} HTTP/1.1\r\nHost: {url.netloc}\r\nConnection: Upgrade\r\n"
                             f"Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
                             f"Sec-WebSocket-Key: {key}\r\n\r\n".encode())
        while b"\r\n\r\n" not in self._bytes:
            self._need(len(self._bytes) + 1)
        head, _, self._bytes = self._bytes.partition(b"\r\n\r\n")
        accept = base64.b64encode(hashlib.sha1(f"{key}258EAFA5-E914-47DA-95CA-C5AB0DC85B11".encode()).digest())
        if not head.startswith(b"HTTP/1.1 101") or accept not in head:
            self._socket.close()
            raise WindowError(f"{address}: refused: {(self._bytes or head).decode(errors='replace').strip()}")

    def __exit__(self, *_: Any) -> None:
        self._socket.close()

    def __next__(self) -> dict[str, Any]:
        """The next new state: the numbers of each of the scene's `fields` by its name, and in "contact" those of its
        `contact_fields`, a row for each contact. In a pause none is new."""
        if not self._asked:
            self.send("next")
        while isinstance(message := self._message(), str) or message[6] != 2:
            if isinstance(message, bytes):
                self.geometry = message
            elif (text := json.loads(message))["type"] == "refused":
                raise WindowError(f"refused: {text['reason']}")
            else:
                setattr(self, text["type"], text)
        self._asked, numbers = False, np.frombuffer(message, "<f8", offset=8)
        fields, row = self.scene["fields"], self.scene["contact_fields"]
        rows = numbers[fields[-1]["begin"] + fields[-1]["count"]:].reshape(-1, row[-1]["begin"] + row[-1]["count"])
        contact = {f["name"]: rows[:, f["begin"]:f["begin"] + f["count"]] for f in row}
        return {"contact": contact, **{f["name"]: numbers[f["begin"]:f["begin"] + f["count"]] for f in fields}}

    def send(self, type: str, **keys: Any) -> None:
        """Sends a message of docs/reference/window.md, as send("set", friction=0.5). If the window refuses it, a later
        read of a state raises a WindowError."""
        self._put(1, json.dumps({"type": type, **keys}, default=lambda value: np.asarray(value).tolist()).encode())

    def _put(self, opcode: int, payload: bytes) -> None:
        size, mask = len(payload), os.urandom(4)
        head = bytes([128 | opcode, 128 | size]) if size < 126 else bytes([128 | opcode, 254]) + size.to_bytes(2, "big")
        masked = np.frombuffer(payload, "u1") ^ np.resize(np.frombuffer(mask, "u1"), size)
        self._socket.sendall(head + mask + masked.tobytes())

    def _need(self, count: int) -> None:
        while len(self._bytes) < count:
            if not (more := self._socket.recv(1 << 16)):
                raise WindowError("the window has closed the connection")
            self._bytes += more

    def _message(self) -> "str | bytes":
        kind, message, first = 0, b"", 0
        while not (first & 128 and first & 15 < 3):
            self._need(begin := 2)
            self._need(begin := {126: 4, 127: 10}.get(self._bytes[1], 2))
            end = begin + (int.from_bytes(self._bytes[2:begin], "big") if begin > 2 else self._bytes[1])
            self._need(end)
            first, part, self._bytes = self._bytes[0], self._bytes[begin:end], self._bytes[end:]
            if first & 15 == 8:
                raise WindowError(f"the window ends this: {part[2:].decode(errors='replace')}")
            if first & 15 == 9:
                self._put(10, part)
            elif first & 15 < 3:
                kind, message = kind or first & 15, message + part
        return message.decode() if kind == 1 else message


connect = Window
