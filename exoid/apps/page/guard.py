"""Clients that may talk to the local server: this machine alone, with the token that was printed, from the page itself.

Another site that is open in the same browser can send requests to 127.0.0.1 too. It does not know the token, and what
its browser says of it (Origin) is refused; a name that is made to point here (DNS rebinding) is not a Host of ours.
"""

from __future__ import annotations

import hmac
from typing import TYPE_CHECKING

from starlette.requests import Request
from starlette.responses import PlainTextResponse

if TYPE_CHECKING:
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
HEADERS = {
    "content-security-policy": POLICY,
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "referrer-policy": "no-referrer",
    "x-content-type-options": "nosniff",
    "x-frame-options": "DENY",
    "cache-control": "no-store",
}
SAFE = ("GET", "HEAD")


class Guard:
    """Wraps an application: refuses what does not come from the page, and sets the headers of every answer."""

    def __init__(self, app: ASGIApp, token: str, port: int) -> None:
        self.app, self.token = app, token
        self.hosts = {f"127.0.0.1:{port}", f"localhost:{port}"}
        self.cookie = f"exoid-{port}"

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer, or refuse."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        request = Request(scope)
        known = self._is(request.query_params.get("token", "") or request.headers.get("x-exoid-token", ""))
        why = self._why_not(request, known)
        if why:
            await PlainTextResponse(f"exoid: {why}\n", 403, HEADERS)(scope, receive, send)
            return

        async def answer(message: Message) -> None:
            if message["type"] == "http.response.start":
                extra = dict(HEADERS)
                if known and scope["path"] == "/":
                    extra["set-cookie"] = f"{self.cookie}={self.token}; HttpOnly; SameSite=Strict; Path=/"
                message["headers"] = [*message["headers"], *((k.encode(), v.encode()) for k, v in extra.items())]
            await send(message)

        await self.app(scope, receive, answer)

    def _why_not(self, request: Request, known: bool) -> str:
        if request.headers.get("host", "") not in self.hosts:
            return "this address is not ours"
        origin = request.headers.get("origin")
        ours = origin is not None and origin.removeprefix("http://") in self.hosts and origin.startswith("http://")
        if origin is not None and not ours:
            return "requests from other sites are refused"
        if known:
            return ""
        if not self._is(request.cookies.get(self.cookie, "")):
            return "the token is missing or wrong: open the address that exoid open printed"
        if request.method not in SAFE and not ours:
            return "the token is missing"
        return ""

    def _is(self, given: str) -> bool:
        return hmac.compare_digest(given.encode(), self.token.encode())
