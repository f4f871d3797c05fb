"""Who may see the page: everybody on this machine, or who knows the token; and no other site through a browser."""

from __future__ import annotations

import hmac
import ipaddress
import secrets
import socket
from collections.abc import Mapping
from dataclasses import dataclass
from urllib.parse import SplitResult, urlsplit

LOCAL, PORT = "127.0.0.1", 8420
_SOMEWHERE = "192.0.2.1"  # an address for documents (RFC 5737), beyond this machine's networks
_LOCAL_NAMES = ("localhost", "127.0.0.1", "::1")


def is_local(host: str) -> bool:
    """Whether only this machine can reach what is bound to `host`."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


@dataclass(frozen=True)
class Access:
    """The rule for one server: `token` empty means that none is asked for."""

    host: str
    port: int
    token: str = ""

    @staticmethod
    def of(host: str, port: int, token: str = "") -> Access:
        """The rule that follows from where it is bound: beyond this machine there is always a token."""
        if not token and not is_local(host):
            token = secrets.token_urlsafe(16)
        return Access(host, port, token)

    @property
    def cookie(self) -> str:
        """Name of the cookie that holds the token; one for each port, which cookies do not tell apart."""
        return f"ddh_token_{self.port}"

    @property
    def url(self) -> str:
        """Where the page is, as a person types it; where it is served at all addresses, the one that other machines reach."""
        host = _reached_at() if self.host in ("0.0.0.0", "::", "") else LOCAL if self.host == "localhost" else self.host
        host = f"[{host}]" if ":" in host else host
        return f"http://{host}:{self.port}/" + (f"?token={self.token}" if self.token else "")

    def knows_token(self, given: str | None) -> bool:
        """Whether this is the token; always where none is asked for."""
        return not self.token or given is not None and hmac.compare_digest(_bytes(given), _bytes(self.token))

    def refusal(self, headers: Mapping[str, str]) -> str:
        """Why a request is refused whoever makes it, '' where it is not.

        A page of another site must not reach this one through the visitor's browser: neither by a name that leads here
        (header Host, where there is no token) nor across origins (header Origin).
        """
        host = headers.get("Host", "")
        name = _split(f"//{host}").hostname or ""
        if not self.token and name not in (*_LOCAL_NAMES, self.host):
            return f"the page is asked for as {name!r}; it is {self.url}"
        origin = headers.get("Origin")
        if origin is not None and _split(origin).netloc != host:
            return f"another site, {origin!r}, asks for it"
        return ""


def _split(url: str) -> SplitResult:
    """A URL in parts; without any where it is none."""
    try:
        return urlsplit(url)
    except ValueError:
        return SplitResult("", "", "", "", "")


def _bytes(text: str) -> bytes:
    return text.encode(errors="surrogateescape")  # a header may hold bytes that are no text


def _reached_at() -> str:
    """The address that this machine has towards others, 127.0.0.1 where it has none. Nothing is sent."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect((_SOMEWHERE, 9))
            return probe.getsockname()[0]
        except OSError:
            return LOCAL
