"""The distribution's Chromium without a window, controlled by its debugging protocol: pages, screenshots, and reported errors."""

from __future__ import annotations

import base64
import itertools
import json
import os
import shutil
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import websocket

NAMES = ("chromium", "chromium-browser", "google-chrome")
ANSWER = 600.0
"""Timeout for a reply of the browser, s. It only ends tests that hang."""
PATIENCE = 600.0
"""Timeout for a condition, s."""
KEY_CODES = {"Enter": 13, "End": 35, "ArrowLeft": 37, "ArrowRight": 39}


def find() -> str | None:
    """A Chromium on the search path."""
    return next((found for name in NAMES if (found := shutil.which(name))), None)


class Page:
    """One page with its reported errors and requests."""

    def __init__(self, address: str) -> None:
        self._socket = websocket.create_connection(address, timeout=ANSWER, suppress_origin=True)
        self._numbers = itertools.count(1)
        self.complaints: list[str] = []
        """Errors and warnings of the console, and failed requests."""
        self.requests: list[str] = []
        """Requested addresses."""
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")

    def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        """Calls a method of the protocol and waits for the reply."""
        number = next(self._numbers)
        self._socket.send(json.dumps({"id": number, "method": method, "params": parameters}))
        while True:
            message = json.loads(self._socket.recv())
            if message.get("id") == number:
                if "error" in message:
                    raise RuntimeError(f"{method}: {message['error']['message']}")
                return message["result"]
            self._note(message)

    def _note(self, message: dict[str, Any]) -> None:
        method, parameters = message.get("method"), message.get("params", {})
        if method == "Runtime.consoleAPICalled" and parameters["type"] in ("error", "warning", "assert"):
            self.complaints.append(" ".join(str(one.get("value", one)) for one in parameters["args"]))
        elif method == "Runtime.exceptionThrown":
            details = parameters["exceptionDetails"]
            self.complaints.append(details.get("exception", {}).get("description", details["text"]))
        elif method == "Log.entryAdded" and parameters["entry"]["level"] in ("error", "warning"):
            self.complaints.append(parameters["entry"]["text"])
        elif method == "Network.requestWillBeSent":
            self.requests.append(parameters["request"]["url"])

    def open(self, file: Path, width: int, height: int = 900) -> None:
        """Opens a file at a width, px, and waits until its figures are drawn."""
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)
        address = file.resolve().as_uri()
        self.call("Page.navigate", url=address)
        self.wait(f"location.href === {json.dumps(address)} && document.readyState === 'complete'")
        self.run("document.querySelectorAll('details:not(.notices)').forEach((one) => { one.open = true; })")
        self.run("pushbelt.ready.then(() => pushbelt.draw())")

    def run(self, script: str) -> Any:
        """Value of an expression. Promises are awaited."""
        answer = self.call("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(answer["exceptionDetails"].get("exception", {}).get("description", script))
        return answer["result"].get("value")

    def wait(self, condition: str) -> None:
        """Waits until an expression is true."""
        end = time.monotonic() + PATIENCE
        while not self.run(condition):
            if time.monotonic() > end:
                raise TimeoutError(condition)
            time.sleep(0.05)

    def key(self, name: str) -> None:
        """Presses a key on the focused element."""
        text = {"text": {"Enter": "\r"}.get(name, name)} if len(name) == 1 or name == "Enter" else {}
        code = KEY_CODES.get(name, 0)
        self.call("Input.dispatchKeyEvent", type="keyDown", key=name, windowsVirtualKeyCode=code, **text)
        self.call("Input.dispatchKeyEvent", type="keyUp", key=name, windowsVirtualKeyCode=code)

    def picture(self, path: Path, whole: bool = True, clip: dict[str, float] | None = None) -> None:
        """Saves a screenshot of the page, or of a part of it."""
        part = {"clip": clip} if clip else {}
        data = self.call("Page.captureScreenshot", captureBeyondViewport=whole, **part)["data"]
        path.write_bytes(base64.b64decode(data))


@contextmanager
def page(program: str) -> Iterator[Page]:
    """A page of a browser that is closed at the end of the block."""
    with tempfile.TemporaryDirectory(prefix="pushbelt-browser-", ignore_cleanup_errors=True) as profile:
        options = ["--headless=new", "--remote-debugging-port=0", f"--user-data-dir={profile}", "--no-first-run", "--disable-gpu"]
        options += [f"--disable-{what}" for what in ("dev-shm-usage", "background-networking", "component-update")]
        options.append("about:blank")
        if hasattr(os, "geteuid") and os.geteuid() == 0:
            options.insert(0, "--no-sandbox")  # Chromium refuses to run as root otherwise.
        process = subprocess.Popen([program, *options], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            yield Page(_address(Path(profile) / "DevToolsActivePort", process))
        finally:
            process.terminate()
            process.wait()


def _address(file: Path, process: subprocess.Popen[bytes]) -> str:
    end = time.monotonic() + ANSWER
    while not (file.is_file() and len(lines := file.read_text().split()) == 2):
        if process.poll() is not None or time.monotonic() > end:
            raise RuntimeError(f"the browser did not start (status {process.poll()})")
        time.sleep(0.05)
    connection = websocket.create_connection(
        f"ws://127.0.0.1:{lines[0]}{lines[1]}", timeout=ANSWER, suppress_origin=True
    )
    connection.send(json.dumps({"id": 1, "method": "Target.getTargets"}))
    targets = json.loads(connection.recv())["result"]["targetInfos"]
    connection.close()
    target = next(one["targetId"] for one in targets if one["type"] == "page")
    return f"ws://127.0.0.1:{lines[0]}/devtools/page/{target}"
