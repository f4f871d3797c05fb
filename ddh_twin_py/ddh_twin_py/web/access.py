"""Who may see the page: everybody on this machine, or who knows the token; and no other site through a browser."""

from __future__ import annotations

import hmac
import ipaddress
import secrets
from collections.abc import Mapping
from dataclasses import dataclass
from urllib.parse import urlsplit

LOCAL = "127.0.0.1"
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
        """Where the page is, as a person types it."""
        host = LOCAL if self.host in ("0.0.0.0", "::", "localhost", "") else self.host
        host = f"[{host}]" if ":" in host else host
        return f"http://{host}:{self.port}/" + (f"?token={self.token}" if self.token else "")

    def knows_token(self, given: str | None) -> bool:
        """Whether this is the token; always where none is asked for."""
        return not self.token or given is not None and hmac.compare_digest(given.encode(), self.token.encode())

    def refusal(self, headers: Mapping[str, str]) -> str:
        """Why a request is refused whoever makes it, '' where it is not.

        A page of another site must not reach this one through the visitor's browser: neither by a name that leads here
        (header Host, where there is no token) nor across origins (header Origin).
        """
        host = headers.get("Host", "")
        name = urlsplit(f"//{host}").hostname or ""
        if not self.token and name not in (*_LOCAL_NAMES, self.host):
            return f"the page is asked for as {name!r}; it is {self.url}"
        origin = headers.get("Origin")
        if origin is not None and urlsplit(origin).netloc != host:
            return f"another site, {origin!r}, asks for it"
        return ""
