"""The local server answers this machine alone, with the token, and lets its page load nothing from elsewhere."""

from __future__ import annotations

import asyncio
from concurrent.futures import ThreadPoolExecutor

import pytest

from exoid.apps.page.guard import Guard

TOKEN = "a-token"
OURS = "127.0.0.1:8000"


async def _application(scope, receive, send):
    await send({"type": "http.response.start", "status": 200, "headers": []})
    await send({"type": "http.response.body", "body": b"in"})


def answer(method="GET", path="/", query="", **headers):
    """Return (status, headers) of the answer to one request."""
    sent = []

    async def send(message):
        sent.append(message)

    given = {"host": OURS} | {name.replace("_", "-"): value for name, value in headers.items()}
    scope = {
        "type": "http", "method": method, "path": path, "query_string": query.encode(),
        "headers": [(name.encode(), value.encode()) for name, value in given.items()],
    }  # fmt: skip
    with ThreadPoolExecutor(1) as thread:  # here a browser of other tests may already run a loop
        thread.submit(asyncio.run, Guard(_application, TOKEN, 8000)(scope, None, send)).result()
    return sent[0]["status"], {k.decode(): v.decode() for k, v in sent[0]["headers"]}


def test_the_printed_address_lets_in_and_is_remembered_by_a_cookie():
    status, headers = answer(query=f"token={TOKEN}")
    assert status == 200 and "HttpOnly" in headers["set-cookie"] and "SameSite=Strict" in headers["set-cookie"]
    cookie = headers["set-cookie"].partition(";")[0]
    assert answer(cookie=cookie)[0] == 200
    assert answer("POST", "/api/add", cookie=cookie, origin=f"http://{OURS}")[0] == 200
    assert answer("POST", "/api/add", x_exoid_token=TOKEN)[0] == 200


@pytest.mark.parametrize(
    "wrong",
    [
        {},
        {"query": "token=another"},
        {"query": f"token={TOKEN}", "host": "exoid.example:8000"},
        {"query": f"token={TOKEN}", "host": "127.0.0.1:9"},
        {"query": f"token={TOKEN}", "origin": "http://evil.example"},
        {"query": f"token={TOKEN}", "origin": "null"},
        {"cookie": "exoid-8000=another"},
        {"cookie": f"exoid-9={TOKEN}"},
        {"method": "POST", "cookie": f"exoid-8000={TOKEN}"},
        {"method": "POST", "cookie": f"exoid-8000={TOKEN}", "origin": "http://evil.example"},
        {"method": "PUT", "query": "token=", "origin": f"http://{OURS}"},
    ],
)
def test_everybody_else_is_refused(wrong):
    status, headers = answer(**wrong)
    assert status == 403 and "set-cookie" not in headers and "content-security-policy" in headers


def test_no_page_of_ours_loads_anything_from_elsewhere():
    policy = answer(query=f"token={TOKEN}")[1]["content-security-policy"]
    rules = dict(rule.strip().split(" ", 1) for rule in policy.split(";"))
    assert rules["default-src"] == "'none'" and rules["script-src"] == "'self'" and rules["style-src"] == "'self'"
    assert "unsafe" not in policy and "*" not in policy and "http" not in policy
