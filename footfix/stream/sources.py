"""Sources of rows: standard input, a peer to connect to, or a peer that connects to us."""

from __future__ import annotations

import os
import socket
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass

from footfix.errors import FootfixError, InputError, UsageError
from footfix.formats.bvh.document import Document
from footfix.stream.backlog import Backlog, Outlet
from footfix.stream.bvh_lines import Lines, Row, Said

_CHUNK = 1 << 16  # [bytes]
_AGAIN = (0.2, 2.0)  # [s] before a connection is tried again: at first, and at most
_POLL = 0.5  # [s] between checks for the end


@dataclass(frozen=True)
class Came:
    """A peer has come."""

    peer: str


@dataclass(frozen=True)
class Gone:
    """A peer has gone, or the input has ended; `last` where nothing follows."""

    last: bool


@dataclass(frozen=True)
class Address:
    """Host and port."""

    host: str
    port: int

    @classmethod
    def parsed(cls, text: str, default: str = "127.0.0.1") -> Address:
        """Read HOST:PORT, :PORT or tcp://HOST:PORT.

        Raises:
            UsageError: it is not an address.
        """
        scheme, mark, rest = text.partition("://")
        if mark and scheme.lower() != "tcp":
            raise UsageError(f"{text}: only tcp:// is known")
        host, colon, port = (rest if mark else text).rpartition(":")
        if not colon or not port.isdigit() or not 0 <= int(port) < 65536:
            raise UsageError(f"{text} is not HOST:PORT, such as tcp://127.0.0.1:7001")
        return cls(host.strip("[]") or default, int(port))

    def __str__(self) -> str:
        return f"{self.host}:{self.port}"


def droppable(item: object) -> bool:
    """Tell whether an item may be dropped when too many wait: rows may, headers, ends and errors may not."""
    return isinstance(item, Row)


class Source:
    """Reads in its own thread, and puts items into a backlog."""

    def __init__(self, backlog: Backlog, document: Document | None, name: str) -> None:
        self.backlog, self._lines = backlog, Lines(document, name)
        self.stopped = threading.Event()
        self.spoke = False  # whether anything but blanks came in

    def start(self) -> None:
        """Begin to read."""
        threading.Thread(target=self._guarded, daemon=True).start()

    def stop(self) -> None:
        """Read no more."""
        self.stopped.set()

    def _guarded(self) -> None:
        try:
            self.read()
        except FootfixError as error:
            self.backlog.put(error)
        except OSError as error:
            self.backlog.put(InputError(f"the input can't be read: {error.strerror or error}"))

    def read(self) -> None:
        """Read until there is no more."""

    def _feed(self, data: bytes) -> None:
        self.spoke = self.spoke or bool(data.strip())
        for item in self._lines.feed(data):
            self.backlog.put(item)

    def _end(self, *, last: bool) -> None:
        for item in self._lines.finish():
            self.backlog.put(item)
        self.backlog.put(Gone(last))


class Standard(Source):
    """Standard input, or any file that is open."""

    def __init__(self, backlog: Backlog, document: Document | None, number: int, *, alone: bool) -> None:
        """Prepare to read it; `start` begins.

        Args:
            backlog: where to put what comes.
            document: what rows mean without a header.
            number: file descriptor of the open file.
            alone: whether its end ends the stream even if nothing came.
        """
        super().__init__(backlog, document, "<stdin>")
        self._number, self._alone = number, alone

    def read(self) -> None:
        """Read until it ends."""
        while not self.stopped.is_set():
            data = os.read(self._number, _CHUNK)
            if not data:
                break
            self._feed(data)
        if self.spoke or self._alone:
            self._end(last=True)


class Peer(Source):
    """A peer on the network, that may go and come again."""

    def __init__(
        self, backlog: Backlog, document: Document | None, address: Address, *, listens: bool, once: bool,
        told: Callable[[str], None], hears: Callable[[], bool] = lambda: True,
    ) -> None:  # fmt: skip
        """Listen at the address, or prepare to connect to it.

        Args:
            backlog: where to put what comes.
            document: what rows mean without a header.
            address: of the peer, or to listen at.
            listens: whether it connects to us.
            once: whether the stream ends when it goes for the first time.
            told: called with messages.
            hears: whether to read what it sends.

        Raises:
            UsageError: it is not possible to listen there.
        """
        super().__init__(backlog, document, str(address))
        self._address, self._listens, self._once, self._told, self._hears = address, listens, once, told, hears
        self.outlet: Outlet | None = None  # to the peer that is there
        self.greeting: Callable[[], bytes] = bytes
        self._server: socket.socket | None = None
        if listens:
            try:
                family = socket.AF_INET6 if ":" in address.host else socket.AF_INET
                self._server = socket.create_server((address.host, address.port), family=family, backlog=1)
            except OSError as error:
                raise UsageError(f"can't listen at {address}: {error.strerror or error}") from None
            self._server.settimeout(_POLL)
            told(f"listening at {address.host}:{self._server.getsockname()[1]}")

    def read(self) -> None:
        """Read from one peer after the other."""
        wait, failed = _AGAIN[0], False
        while not self.stopped.is_set():
            try:
                peer = self._next()
            except OSError as error:
                if not failed:
                    self._told(f"no connection to {self._address}: {error.strerror or error}; trying again")
                failed = True
                time.sleep(wait)
                wait = min(2.0 * wait, _AGAIN[1])
                continue
            if peer is None:
                continue
            wait, failed = _AGAIN[0], False
            self._talk(peer)
            if self._once:
                return

    def _next(self) -> socket.socket | None:
        if self._server is None:
            return socket.create_connection((self._address.host, self._address.port), timeout=5.0)
        try:
            return self._server.accept()[0]
        except TimeoutError:
            return None

    def _who(self, peer: socket.socket) -> str:
        """Name a peer by its own address; by the one that was asked for where it is gone already."""
        try:
            host, port = peer.getpeername()[:2]
        except (OSError, ValueError):
            return str(self._address)
        return str(Address(str(host), int(port)))

    def _talk(self, peer: socket.socket) -> None:
        """Read from a peer until it is gone."""
        peer.settimeout(None)
        with suppress(OSError):
            peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._lines.forget()
        self.backlog.put(Came(self._who(peer)))
        if self._listens:
            self.outlet = Outlet(peer.sendall)
            if greeting := self.greeting():
                self.outlet.put(greeting)
        try:
            while data := peer.recv(_CHUNK):
                if self._hears():
                    self._feed(data)
        except OSError:
            pass
        finally:
            if self.outlet is not None:
                outlet, self.outlet = self.outlet, None
                if outlet.dropped:
                    self._told(f"{outlet.dropped} frames were dropped for a peer that reads too slowly")
                with suppress(OSError):
                    peer.shutdown(socket.SHUT_RDWR)
                outlet.close(0.1)
            peer.close()
        if self._hears() or self._once:
            self._finish_peer()

    def _finish_peer(self) -> None:
        try:
            self._end(last=self._once)
        except InputError as error:
            if self._once:
                raise
            self.backlog.put(Said("peer", error.what))
            self.backlog.put(Gone(last=False))
