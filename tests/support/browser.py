"""Chromium without a window, driven as a user would by mouse, keys and touch, without a network."""
import base64
import fcntl
import json
import os
import select
import shutil
import subprocess
import sys
import tempfile
import time

sys.path.append("/usr/lib/python3/dist-packages")
import OpenImageIO as oiio

from cases import Skip

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


class Browser:
    """Chromium through its DevTools protocol: JSON messages that end with a zero byte, on a pair of pipes."""

    def __init__(self, width=1280, height=1000):
        if not CHROMIUM:
            raise Skip("chromium is not installed")
        self.folder = tempfile.mkdtemp(prefix="slicemorph-chromium-")
        to_read, self.to = os.pipe()
        self.back, back_write = os.pipe()
        # Moved away from 3 and 4, the descriptors that Chromium expects.
        ends = [fcntl.fcntl(end, fcntl.F_DUPFD, 20) for end in (to_read, back_write)]

        def wire():
            os.dup2(ends[0], 3)
            os.dup2(ends[1], 4)

        self.process = subprocess.Popen(
            [CHROMIUM, "--headless=new", "--no-sandbox", "--remote-debugging-pipe", "--user-data-dir=" + self.folder,
             "--window-size=%d,%d" % (width, height), "--hide-scrollbars", "--use-angle=swiftshader",
             "--enable-unsafe-swiftshader", "--host-resolver-rules=MAP * ~NOTFOUND", "--no-first-run", "about:blank"],
            preexec_fn=wire, close_fds=False, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        for end in (*ends, to_read, back_write):
            os.close(end)
        self.buffer, self.count, self.events, self.session = b"", 0, [], None
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(domain + ".enable")
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)

    def message(self, until):
        while b"\0" not in self.buffer:
            ready, _, _ = select.select([self.back], [], [], max(until - time.time(), 0))
            assert ready, "Chromium does not answer"
            data = os.read(self.back, 1 << 20)
            assert data, "Chromium is gone"
            self.buffer += data
        text, self.buffer = self.buffer.split(b"\0", 1)
        return json.loads(text)

    def call(self, method, **parameters):
        self.count += 1
        message = {"id": self.count, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.to, json.dumps(message).encode() + b"\0")
        until = time.time() + 120
        while True:
            answer = self.message(until)
            if answer.get("id") == self.count:
                assert "error" not in answer, answer["error"]
                return answer["result"]
            self.events.append(answer)

    def run(self, script):
        result = self.call("Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in result, result["exceptionDetails"]
        return result["result"].get("value")

    def open(self, path, ready="document.body.dataset.player === 'ready' || !!document.querySelector('#player .none')"):
        """`ready`: what is true when the page is."""
        self.call("Page.navigate", url="file://" + os.path.abspath(path))
        self.wait("document.readyState === 'complete' && (%s)" % ready)

    def wait(self, script, seconds=90):
        until = time.time() + seconds
        while not self.run(script):
            assert time.time() < until, "the page is not ready; " + "; ".join(self.errors())
            time.sleep(0.1)

    def mouse(self, kind, x, y, down=True):
        """`kind`: Pressed, Moved, Released; `down`: the left button is, or was until now."""
        self.call("Input.dispatchMouseEvent", type="mouse" + kind, x=x, y=y, button="left" if down else "none", buttons=int(down and kind != "Released"),
                  clickCount=int(kind != "Moved"))

    def click(self, x, y):
        self.mouse("Moved", x, y, False)
        self.mouse("Pressed", x, y)
        self.mouse("Released", x, y)

    def drag(self, start, end, steps=6):
        self.mouse("Moved", *start, False)
        self.mouse("Pressed", *start)
        for i in range(1, steps + 1):
            self.mouse("Moved", *(a + (b - a) * i / steps for a, b in zip(start, end)))
        self.mouse("Released", *end)

    def tap(self, x, y):
        self.call("Input.dispatchTouchEvent", type="touchStart", touchPoints=[{"x": x, "y": y}])
        self.call("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])

    def key(self, key, code=0, text="", modifiers=0):
        """`code`: Windows' number of the key; `modifiers`: 2 Ctrl, 8 Shift."""
        press = dict(key=key, windowsVirtualKeyCode=code, modifiers=modifiers)
        self.call("Input.dispatchKeyEvent", type="keyDown" if text else "rawKeyDown", text=text, **press)
        self.call("Input.dispatchKeyEvent", type="keyUp", **press)

    def box(self, selector):
        """x, y, width and height in the window."""
        return self.run("(r => [r.x, r.y, r.width, r.height])(document.querySelector(%s).getBoundingClientRect())" % json.dumps(selector))

    def picture(self, selector=None):
        """RGB, rows x columns x 3, of the visible part of an element, or of the window."""
        clip = {}
        if selector:
            box = self.run("(r => [r.x + scrollX, r.y + scrollY, r.width, r.height])(document.querySelector(%s).getBoundingClientRect())"
                           % json.dumps(selector))
            clip = {"clip": dict(zip(("x", "y", "width", "height"), box), scale=1), "captureBeyondViewport": True}
        return unpng(self.png(**clip))

    def png(self, **options):
        self.run("new Promise(r => requestAnimationFrame(() => requestAnimationFrame(r)))")
        return base64.b64decode(self.call("Page.captureScreenshot", format="png", **options)["data"])

    def errors(self):
        """Errors and warnings of console and network."""
        found = []
        for event in self.events:
            name, p = event.get("method"), event.get("params", {})
            if name == "Runtime.exceptionThrown":
                found.append(json.dumps(p["exceptionDetails"])[:500])
            elif name == "Runtime.consoleAPICalled" and p["type"] in ("error", "warning", "assert"):
                found.append(p["type"] + ": " + " ".join(str(a.get("value", a.get("description"))) for a in p["args"]))
            elif name == "Log.entryAdded" and p["entry"]["level"] in ("error", "warning"):
                found.append("log: " + p["entry"]["text"])
            elif name == "Network.requestWillBeSent" and not p["request"]["url"].startswith(("file:", "data:", "blob:")):
                found.append("asks the network for " + p["request"]["url"])
        # Headless Chromium without a graphics card warns when pixels are read back.
        return [f for f in found if "GPU stall due to ReadPixels" not in f]

    def close(self):
        self.process.kill()
        self.process.wait()
        os.close(self.to)
        os.close(self.back)
        shutil.rmtree(self.folder, ignore_errors=True)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


def unpng(data):
    with tempfile.NamedTemporaryFile(suffix=".png") as file:
        file.write(data)
        file.flush()
        source = oiio.ImageInput.open(file.name)
        return source.read_image(0, 0, 0, 3, oiio.UINT8).astype(int)
