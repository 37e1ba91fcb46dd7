#!/usr/bin/env python3
"""Tests the page of `tyndall bake -o cloud.html` in headless Chromium over its debugging pipe, with Python's standard
library only. Compares the template, with a small cloud, with ray marching in Python, then a baked scene with its picture.

    page_in_browser.py [SCENE PICTURE.png ...]     also saves pictures of baked scenes

Exits with 77 (skipped) without Chromium.
"""
import array, base64, fcntl, gzip, itertools, json, math, os, random, re, select, shutil, struct, subprocess, sys
import tempfile, time

MARK = "/*TYNDALL_DATA*/null"
CHROMIUM = next(filter(None, map(shutil.which, ["chromium", "chromium-browser", "google-chrome"])), None)


class Browser:
    """Chromium with its DevTools protocol over a pipe: JSON messages, each followed by a zero byte."""

    def __init__(self, size):
        self.profile = tempfile.mkdtemp(prefix="look-")
        down_read, down_write = os.pipe()
        up_read, up_write = os.pipe()
        # Moves the pipes away from descriptors 3 and 4, which Chromium uses.
        down, up = (fcntl.fcntl(fd, fcntl.F_DUPFD, 20) for fd in (down_read, up_write))
        os.close(down_read)
        os.close(up_write)

        def place():
            os.dup2(down, 3)
            os.dup2(up, 4)

        self.log = tempfile.TemporaryFile()
        self.process = subprocess.Popen(
            [CHROMIUM, "--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
             "--ignore-gpu-blocklist", "--no-first-run", "--disable-background-networking", "--disable-dev-shm-usage",
             "--user-data-dir=" + self.profile, "--window-size=%d,%d" % size, "--remote-debugging-pipe",
             "--enable-logging=stderr", "--v=0", "about:blank"],
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=self.log, preexec_fn=place, pass_fds=(3, 4))
        os.close(down)
        os.close(up)
        self.down, self.up, self.buffer, self.number, self.session = down_write, up_read, b"", 0, None
        self.console = []
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log"):
            self.call(domain + ".enable")
        self.resize(size)

    def resize(self, size, ratio=1):
        self.call("Emulation.setDeviceMetricsOverride", width=size[0], height=size[1], deviceScaleFactor=ratio,
                  mobile=False)

    def receive(self, deadline):
        while b"\0" not in self.buffer:
            left = deadline - time.monotonic()
            if left <= 0 or not select.select([self.up], [], [], left)[0]:
                raise TimeoutError("Chromium does not answer")
            read = os.read(self.up, 1 << 20)
            if not read:
                raise TimeoutError("Chromium ended")
            self.buffer += read
        message, self.buffer = self.buffer.split(b"\0", 1)
        message = json.loads(message)
        method, values = message.get("method"), message.get("params", {})
        if method == "Runtime.consoleAPICalled":
            self.console.append(values["type"] + ": " + " ".join(str(a.get("value", a)) for a in values["args"]))
        elif method == "Runtime.exceptionThrown":
            self.console.append("exception: " + json.dumps(values["exceptionDetails"])[:600])
        elif method == "Log.entryAdded":
            self.console.append("%s: %s" % (values["entry"]["level"], values["entry"]["text"]))
        return message

    def call(self, method, timeout=180, **values):
        self.number += 1
        message = {"id": self.number, "method": method, "params": values}
        if self.session:
            message["sessionId"] = self.session
        data = json.dumps(message).encode() + b"\0"
        while data:
            data = data[os.write(self.down, data):]
        deadline = time.monotonic() + timeout
        while True:
            answer = self.receive(deadline)
            if answer.get("id") == self.number:
                if "error" in answer:
                    raise RuntimeError("%s: %s" % (method, answer["error"]))
                return answer["result"]

    def run(self, script):
        """Returns the value of an expression in the page; awaits promises."""
        answer = self.call("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in answer:
            raise RuntimeError("%s: %s" % (script[:80], json.dumps(answer["exceptionDetails"])[:600]))
        return answer["result"].get("value")

    def open(self, page, before=""):
        """Loads the code of a page, with a script that runs before its own. Returns the time [s] until it is ready."""
        path = os.path.join(self.profile, "look_%d.html" % self.number)
        with open(path, "w", encoding="utf-8") as file:
            file.write(page)
        script = self.call("Page.addScriptToEvaluateOnNewDocument", source=before)["identifier"] if before else None
        start = time.monotonic()
        self.call("Page.navigate", url="file://" + path)
        while self.run("document.documentElement?.dataset.state ?? 'none'") not in ("ready", "failed"):
            if time.monotonic() - start > 180:
                raise TimeoutError("the page is neither ready nor failed")
            time.sleep(0.02)
        took = time.monotonic() - start
        if script:
            self.call("Page.removeScriptToEvaluateOnNewDocument", identifier=script)
        return took

    def state(self):
        return self.run("document.documentElement.dataset.state")

    def message(self):
        return self.run("(m => m.hidden ? '' : m.innerText)(document.getElementById('message'))")

    def pixels(self):
        """Rows from the top down, of (r, g, b)."""
        text = self.run("""(() => {
            const bytes = tyndall.pixels(), canvas = document.querySelector("canvas");
            let text = "";
            for (let i = 0; i < bytes.length; i += 8192) text += String.fromCharCode(...bytes.subarray(i, i + 8192));
            return [canvas.width, canvas.height, btoa(text)]; })()""")
        width, height, data = text[0], text[1], base64.b64decode(text[2])
        assert len(data) == 4 * width * height
        return [[tuple(data[4 * (y * width + x):][:3]) for x in range(width)] for y in reversed(range(height))]

    def screenshot(self, path):
        with open(path, "wb") as file:
            file.write(base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"]))

    def close(self):
        try:
            self.session = None
            self.call("Browser.close", timeout=5)
            self.process.wait(10)
        except Exception:
            self.process.kill()
            self.process.wait()
        shutil.rmtree(self.profile, ignore_errors=True)


# ---- An asymmetric cloud, lit by two lights, and its picture ----

def small_cloud(n=(32, 28, 24)):
    """Spheres: a large one, a small one at +x, a middle one at +y, one near +z."""
    nx, ny, nz = n
    low, high = (-1.0, -0.5, 0.25), (1.0, 1.25, 1.75)
    balls = [((0.42, 0.40, 0.50), 0.27, 1.0), ((0.80, 0.30, 0.50), 0.13, 0.7), ((0.30, 0.80, 0.45), 0.16, 0.8),
             ((0.62, 0.62, 0.83), 0.12, 1.0)]
    density, lights = bytearray(), (bytearray(), bytearray())
    for z, y, x in itertools.product(range(nz), range(ny), range(nx)):
        p = ((x + 0.5) / nx, (y + 0.5) / ny, (z + 0.5) / nz)
        d = max(w * max(0.0, min(1.0, 1.5 * (1 - math.dist(p, c) / r))) for c, r, w in balls)
        value = round(255 * math.sqrt(d))
        density.append(value)
        sun, sky = (p[0] + p[1]) / 2, 0.3 + 0.5 * (1 - p[1])
        lights[0].extend((255, 210, 160, round(255 * math.sqrt(sun))) if value else (0, 0, 0, 0))
        lights[1].extend((90, 150, 255, round(255 * math.sqrt(sky))) if value else (0, 0, 0, 0))
    pack = lambda b: base64.b64encode(gzip.compress(bytes(b), 6)).decode()
    return {"title": "small cloud </script> & <b>", "size": [nx, ny, nz], "box_min": low, "box_max": high,
            "extinction_max": 9.0, "density": pack(density), "albedo": [0.99, 0.95, 0.9],
            "lights": [{"name": "sun", "scale": 0.9, "data": pack(lights[0])},
                       {"name": "sky", "scale": 0.5, "data": pack(lights[1])}],
            "background": [0.05, 0.08, 0.15],
            "camera": {"position": [0.9, 1.3, 4.4], "look_at": [0.05, 0.35, 1.0], "up": [0.1, 1, 0], "fov": 32.0,
                       "resolution": [160, 120]},
            "exposure": 0.25}


def fill(template, data):
    # No "<" in the JSON: "</script>" in a title would end the element.
    return template.replace(MARK, json.dumps(data).replace("<", "\\u003c"))


def ray_march(data, camera, width, height, every, mix=None, exposure=None):
    """The picture that the page ought to show: {(x, y): (r, g, b)} of every n-th pixel, y from the top."""
    add = lambda a, b, f=1.0: [x + f * y for x, y in zip(a, b)]
    cross = lambda a, b: [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    unit = lambda a: [x / math.hypot(*a) for x in a]
    n = data["size"]
    unpack = lambda text: gzip.decompress(base64.b64decode(text))
    extinction = [data["extinction_max"] * (v / 255) ** 2 for v in unpack(data["density"])]
    mix = mix or [1.0] * len(data["lights"])
    exposure = data["exposure"] if exposure is None else exposure
    rgbm = [unpack(light["data"]) for light in data["lights"]]
    # The emission per length is interpolated like the extinction, not the light itself.
    emission = [tuple(s * sum(m * l["scale"] * (b[4 * i + 3] / 255) ** 2 * b[4 * i + c] / 255
                              for m, l, b in zip(mix, data["lights"], rgbm)) for c in range(3))
                for i, s in enumerate(extinction)]
    low, high = data["box_min"], data["box_max"]
    extent = add(high, low, -1)
    dt = 0.5 * min(e / k for e, k in zip(extent, n))
    eye = camera["position"]
    forward = unit(add(camera["look_at"], eye, -1))
    right = unit(cross(forward, camera["up"]))
    up = cross(right, forward)
    tangent = math.tan(math.radians(camera["fov"]) / 2)
    picture = {}
    for py, px in itertools.product(range(0, height, every), range(0, width, every)):
        ray = add(add(forward, right, tangent * width / height * (2 * (px + 0.5) / width - 1)),
                  up, tangent * (1 - 2 * (py + 0.5) / height))
        ray = unit(ray)
        spans = [sorted(((a - e) / r, (b - e) / r)) for a, b, e, r in zip(low, high, eye, ray)]
        start, end = max(0.0, *(s[0] for s in spans)), min(s[1] for s in spans)
        radiance, through, t = [0.0, 0.0, 0.0], 1.0, start + dt / 2
        while t < end and through >= 0.002:
            cell, share = [], []
            for a in range(3):
                v = (eye[a] + t * ray[a] - low[a]) / extent[a] * n[a] - 0.5
                v = min(max(v, 0.0), n[a] - 1.0)
                cell.append(min(int(v), n[a] - 2))
                share.append(v - cell[a])
            t += dt
            s, j = 0.0, [0.0, 0.0, 0.0]
            for dz, dy, dx in itertools.product((0, 1), repeat=3):
                i = ((cell[2] + dz) * n[1] + cell[1] + dy) * n[0] + cell[0] + dx
                if extinction[i] == 0:
                    continue
                w = ((share[0] if dx else 1 - share[0]) * (share[1] if dy else 1 - share[1])
                     * (share[2] if dz else 1 - share[2]))
                s += w * extinction[i]
                for c in range(3):
                    j[c] += w * emission[i][c]
            if s == 0:
                continue
            alpha = 1 - math.exp(-s * dt)
            for c in range(3):
                radiance[c] += through * alpha * data["albedo"][c] * j[c] / s
            through *= 1 - alpha
        color = []
        for c in range(3):
            v = min(max(2 ** exposure * (radiance[c] + through * data["background"][c]), 0.0), 1.0)
            color.append(255 * (12.92 * v if v <= 0.0031308 else 1.055 * v ** (1 / 2.4) - 0.055))
        picture[px, py] = tuple(color)
    return picture


def correlation(a, b):
    a, b = list(a), list(b)
    ma, mb = sum(a) / len(a), sum(b) / len(b)
    ab = sum((x - ma) * (y - mb) for x, y in zip(a, b))
    return ab / math.sqrt(sum((x - ma) ** 2 for x in a) * sum((y - mb) ** 2 for y in b))


def compare(pixels, expected):
    """Returns the correlation, the r.m.s. difference [of 255] and the largest difference."""
    a, b = [], []
    for (x, y), color in expected.items():
        a.extend(pixels[y][x])
        b.extend(color)
    return (correlation(a, b), math.sqrt(sum((x - y) ** 2 for x, y in zip(a, b)) / len(a)),
            max(abs(x - y) for x, y in zip(a, b)))


# ---- The checks ----

failures = 0


def check(good, what):
    global failures
    failures += not good
    print("%s  %s" % ("ok    " if good else "FAILED", what), flush=True)


# A synthetic pointer cannot be captured: the browser knows of none such.
POINTERS = """(async () => {
  const canvas = document.querySelector("canvas");
  canvas.setPointerCapture = () => {};
  window.fire = (name, id, kind, x, y, more = {}) => canvas.dispatchEvent(new PointerEvent(name,
    { pointerId: id, pointerType: kind, clientX: x, clientY: y, bubbles: true, cancelable: true, isPrimary: id === 1,
      buttons: name === "pointerup" ? 0 : 1, ...more }));
  window.view = () => JSON.parse(JSON.stringify(tyndall.camera));
})()"""


def distance(camera):
    return math.dist(camera["position"], camera["lookAt"])


def scene_camera(camera, fov):
    return {"position": camera["position"], "look_at": camera["lookAt"], "up": camera["up"], "fov": fov}


def run_checks(browser, template):
    data = small_cloud()
    page = fill(template, data)
    size = 160, 120

    took = browser.open(page)
    check(browser.state() == "ready" and browser.message() == "", "ready after %.2f s, no message" % took)
    check(browser.run("document.title") == data["title"], "the title is the data's, \"</script>\" and all")
    c = browser.run("tyndall.camera")
    check([c["position"], c["lookAt"], c["up"], c["fov"]]
          == [data["camera"][k] for k in ("position", "look_at", "up", "fov")], "the first camera is the scene's")
    first = browser.pixels()
    check((len(first[0]), len(first)) == size, "pixels() has %d x %d" % (len(first[0]), len(first)))
    expected = ray_march(data, data["camera"], *size, every=2)
    close = compare(first, expected)
    check(close[0] >= 0.98 and close[1] < 4, "the picture, against marching in Python: r = %.5f, "
          "rms difference %.2f of 255, largest %.1f" % close)
    mirrored = compare([row[::-1] for row in first], expected)[0]
    check(mirrored < 0.95, "its mirror image would not pass: r = %.3f" % mirrored)

    # The other way round, off its axis, and wider: x is to the left now.
    back = json.loads(json.dumps(data))
    back["camera"].update(position=[-0.4, 0.2, -3.0], look_at=[0.1, 0.3, 1.0], up=[0, 1, 0], fov=38)
    back["exposure"] = -0.5
    browser.resize((200, 100))
    browser.open(fill(template, back))
    close = compare(browser.pixels(), ray_march(back, back["camera"], 200, 100, every=3))
    check(close[0] >= 0.98 and close[1] < 4, "from behind, 200 x 100: r = %.5f, rms %.2f, largest %.1f" % close)
    browser.resize(size)

    # Sliders, moved as by the keyboard.
    browser.open(page)
    sliders = browser.run("[...document.querySelectorAll('input')].map(i => i.parentNode.firstChild.textContent)")
    check(sliders == ["Exposure", "Density", "sun", "sky"], "sliders: " + ", ".join(sliders))
    browser.run("""(() => { const set = (i, v) => { const s = document.querySelectorAll('input')[i]; s.value = v;
        s.dispatchEvent(new Event('input')); }; set(0, 1); set(2, 0); set(3, 2); })()""")
    close = compare(browser.pixels(), ray_march(data, data["camera"], *size, every=4, mix=[0, 2], exposure=1))
    check(close[0] >= 0.98 and close[1] < 4, "sun off, sky doubled, exposure 1: r = %.5f, rms %.2f, largest %.1f" % close)
    browser.run("document.querySelector('#panel').open = true, document.querySelectorAll('input')[1].focus()")
    dark = browser.pixels()
    for _ in range(10):
        for kind in ("rawKeyDown", "keyUp"):
            browser.call("Input.dispatchKeyEvent", type=kind, key="ArrowLeft", code="ArrowLeft", windowsVirtualKeyCode=37)
    value = browser.run("document.querySelectorAll('input')[1].valueAsNumber")
    check(abs(value + 0.2) < 1e-6 and browser.pixels() != dark, "an arrow key moves the density to 10^%g" % value)

    # Synthetic pointers.
    browser.open(page)
    browser.run(POINTERS)
    start = browser.run("view()")
    browser.run("fire('pointerdown', 1, 'mouse', 80, 60), fire('pointermove', 1, 'mouse', 110, 60),"
                "fire('pointerup', 1, 'mouse', 110, 60), fire('pointermove', 1, 'mouse', 10, 10)")
    turned = browser.run("view()")
    check(turned["lookAt"] == start["lookAt"] and abs(distance(turned) - distance(start)) < 1e-9
          and turned["position"][0] < start["position"][0] - 0.5, "mouse drag to the right: the eye goes left, on a circle")
    second = browser.pixels()
    check(second != first, "and the picture changes")
    close = compare(second, ray_march(data, scene_camera(turned, 32), *size, every=4))
    check(close[0] >= 0.98, "and is what is seen from there: r = %.5f" % close[0])
    # The middle of the nearest ball goes right and, dragged down, down.
    browser.run("fire('pointerdown', 1, 'touch', 80, 60), fire('pointermove', 1, 'touch', 80, 80),"
                "fire('pointerup', 1, 'touch', 80, 80)")
    tilted = browser.run("view()")
    check(tilted["position"][1] > turned["position"][1] + 0.5, "touch drag down: the eye goes up")
    check(browser.pixels() != second, "and the picture changes")
    browser.run("fire('pointerdown', 1, 'mouse', 80, 10), fire('pointermove', 1, 'mouse', 80, 5000),"
                "fire('pointerup', 1, 'mouse', 80, 5000)")
    c = browser.run("view()")
    out = [a - b for a, b in zip(c["position"], c["lookAt"])]
    sine = sum(a * b for a, b in zip(out, c["up"])) / math.hypot(*out) / math.hypot(*c["up"])
    check(0.999 < sine < 0.99999 and all(map(math.isfinite, c["position"])), "a long drag stops before the pole")
    browser.run("document.querySelector('#reset').click()")
    check(browser.run("view()") == start and browser.pixels() == first, "the button brings camera and picture back")
    browser.run("fire('pointerdown', 1, 'touch', 60, 60), fire('pointerdown', 2, 'touch', 100, 60),"
                "fire('pointermove', 1, 'touch', 40, 60), fire('pointermove', 2, 'touch', 120, 60),"
                "fire('pointerup', 1, 'touch', 40, 60), fire('pointerup', 2, 'touch', 120, 60)")
    near = browser.run("view()")
    check(abs(distance(near) / distance(start) - 0.5) < 1e-6 and math.dist(near["lookAt"], start["lookAt"]) < 1.0,
          "two fingers, twice as far apart: %.3f of the distance" % (distance(near) / distance(start)))
    check(browser.pixels() != first, "and the picture changes")
    browser.run("document.querySelector('canvas').dispatchEvent(new MouseEvent('dblclick'))")
    check(browser.run("view()") == start, "a double click goes back")

    # Trusted events, as from a user.
    def mouse(kind, x, y, **more):
        browser.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, **more)

    browser.open(page)
    mouse("mousePressed", 20, 110, button="left", buttons=1, clickCount=1, modifiers=8)
    mouse("mouseMoved", 60, 90, button="left", buttons=1, modifiers=8)
    mouse("mouseReleased", 60, 90, button="left", clickCount=1, modifiers=8)
    browser.run("window.view = () => JSON.parse(JSON.stringify(tyndall.camera))")
    panned = browser.run("view()")
    shift = [[a - b for a, b in zip(panned[k], start[k])] for k in ("position", "lookAt")]
    check(math.dist(*shift) < 1e-9 and math.hypot(*shift[0]) > 0.1, "shift and drag: eye and target move alike")
    close = compare(browser.pixels(), {(x + 40, y - 20): v for (x, y), v in expected.items() if x < 120 and y >= 20})
    check(close[0] > 0.9, "what is looked at stays below the pointer: r = %.3f" % close[0])
    mouse("mouseWheel", 60, 60, deltaX=0, deltaY=-200)
    deadline = time.monotonic() + 5
    while distance(browser.run("view()")) == distance(panned) and time.monotonic() < deadline:
        time.sleep(0.05)
    check(distance(browser.run("view()")) < 0.9 * distance(panned), "the wheel zooms")
    browser.run("document.querySelector('canvas').focus()")
    for kind in ("rawKeyDown", "keyUp"):
        browser.call("Input.dispatchKeyEvent", type=kind, key="Home", code="Home", windowsVirtualKeyCode=36)
    check(browser.run("view()") == start, "Home goes back")
    before = browser.run("view()")
    browser.call("Emulation.setTouchEmulationEnabled", enabled=True, maxTouchPoints=2)
    for kind, points in (("touchStart", [(30, 60)]), ("touchMove", [(50, 60)]), ("touchMove", [(60, 60)]),
                         ("touchEnd", [])):
        browser.call("Input.dispatchTouchEvent", type=kind, touchPoints=[{"x": x, "y": y} for x, y in points])
    check(browser.run("view()")["position"][0] < before["position"][0] - 0.1, "a finger orbits")
    middle = browser.run("view()")
    for kind, points in (("touchStart", [(60, 60), (60, 100)]), ("touchMove", [(60, 70), (60, 90)]), ("touchEnd", [])):
        browser.call("Input.dispatchTouchEvent", type=kind,
                     touchPoints=[{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(points)])
    grown = distance(browser.run("view()")) / distance(middle)
    check(abs(grown - 2) < 0.01, "two fingers, pinched to the half: %.3f of the distance" % grown)
    browser.call("Emulation.setTouchEmulationEnabled", enabled=False)

    # The page redraws only after changes: previews during a motion, then the full picture.
    browser.run("tyndall.draw()")
    time.sleep(1.0)
    browser.run("""(() => { window.draws = []; const one = WebGL2RenderingContext.prototype.drawArrays;
        WebGL2RenderingContext.prototype.drawArrays = function (...a) { draws.push(
            this.getParameter(this.VIEWPORT)[2]); return one.apply(this, a); }; })()""")
    time.sleep(0.5)
    check(browser.run("draws.length") == 0, "nothing is drawn while nothing changes")
    browser.run("document.querySelector('#reset').click()")
    time.sleep(1.0)
    draws = browser.run("draws")
    check(draws and draws[-1] == 160 and browser.pixels() == first, "a change: drawn at widths %s" % draws)

    # A context that is lost and comes back.
    browser.run("window.lose = document.querySelector('canvas').getContext('webgl2').getExtension('WEBGL_lose_context'),"
                "lose.loseContext()")
    time.sleep(0.3)
    check(browser.state() == "loading" and "context" in browser.message(), "lost context: " + browser.message())
    browser.run("lose.restoreContext()")
    deadline = time.monotonic() + 20
    while browser.state() != "ready" and time.monotonic() < deadline:
        time.sleep(0.05)
    check(browser.state() == "ready" and browser.pixels() == first, "it comes back, with the same picture")
    browser.resize((161, 120), ratio=3)  # another monitor
    time.sleep(0.5)
    check(len(browser.pixels()[0]) == 322, "three device pixels per pixel are drawn as two")
    browser.resize(size)
    noise = [line for line in browser.console if "CONTEXT_LOST" not in line and "context lost" not in line.lower()
             and "GPU stall due to ReadPixels" not in line]
    check(not noise, "the console is silent" + "".join("\n        " + line for line in noise[:10]))
    browser.console.clear()

    # The page reports errors.
    none = "HTMLCanvasElement.prototype.getContext = () => null"
    wrong = lambda **values: fill(template, {**data, **values})
    short = base64.b64encode(gzip.compress(b"short")).decode()
    packed = data["density"]
    for what, text, before, words in [
            ("no WebGL 2", page, none, "WebGL 2"),
            ("no DecompressionStream", page, "delete window.DecompressionStream", "DecompressionStream"),
            ("the template", template, "", "empty template"),
            ("null", template.replace(MARK, "null"), "", "no cloud"),
            ("a file cut off in the data", page[:page.index(packed) + 500], "", "damaged"),
            ("a file cut off before the data", page[:page.index("application/json")], "", "damaged"),
            ("no size", wrong(size=None), "", "\"size\""),
            ("a size of 300", wrong(size=[300, 28, 24]), "", "\"size\""),
            ("no lights", wrong(lights=[]), "", "\"lights\""),
            ("a camera without fov", wrong(camera={**data["camera"], "fov": None}), "", "\"camera\""),
            ("a camera that looks along up", wrong(camera={**data["camera"], "up": [0.85, 0.95, 3.4]}), "", "\"camera\""),
            ("a density too short", wrong(density=short), "", "5 bytes instead of %d" % (32 * 28 * 24)),
            ("a density with one wrong byte", wrong(density=packed[:900] + ("A" if packed[900] != "A" else "B")
                                                    + packed[901:]), "", "the density"),
            ("a light in blocks of 3", wrong(lights=[{**data["lights"][0], "step": 3}]), "", "\"lights\""),
            ("a light that is no base64", wrong(lights=[{"name": "sun", "scale": 1, "data": "?"}]), "", "\"sun\"")]:
        browser.open(text, before)
        message = browser.message()
        check(browser.state() == "failed" and words in message and browser.run("document.querySelector('#panel').hidden"),
              "%s: %s" % (what, message))
    check(not browser.console, "the console is silent" + "".join("\n        " + line for line in browser.console[:10]))


ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../..")
TYNDALL = os.environ.get("TYNDALL_BINARY", os.path.join(ROOT, "build/release/tyndall"))


def tyndall(*words):
    subprocess.run([TYNDALL, *map(str, words)], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def read_pfm(path):
    """Rows from the top down, of (r, g, b)."""
    with open(path, "rb") as file:
        assert file.readline() == b"PF\n"
        width, height = map(int, file.readline().split())
        file.readline()
        values = array.array("f", file.read())
    return [[tuple(values[3 * (y * width + x):][:3]) for x in range(width)] for y in reversed(range(height))]


def encoded(x):
    x = min(max(x, 0), 1)
    return 255 * (12.92 * x if x <= 0.0031308 else 1.055 * x ** (1 / 2.4) - 0.055)


# A medium in all 128^3 voxels, and two lights: more than fits at full resolution.
FULL = """{"tyndall": 1,
 "medium": {"components": [{"field": {"type": "noise_cloud", "preset": "low_variation", "octaves": 8, "seed": 3,
                                      "body": {"type": "everywhere"}}, "extinction": 20, "albedo": 0.95}]},
 "lights": [{"type": "directional", "direction": [0.3, -1, 0.2], "irradiance": 3},
            {"type": "environment", "radiance": [0.3, 0.5, 0.9]}],
 "camera": {"position": [0.5, 0.5, -2], "look_at": [0.5, 0.5, 0.5], "fov": 45},
 "photons": {"illumination": {"resolution": 128}}}"""


def run_baked(browser, scene, folder, screenshot=None, *more):
    """Checks that a scene's page looks like its picture."""
    size = 160, 120
    path = os.path.join(ROOT, "scenes", scene + ".json")
    if scene == "full":
        path = os.path.join(folder, "scene.json")
        with open(path, "w", encoding="utf-8") as file:
            file.write(FULL)
    shared = ["-D", "camera.resolution=[%d,%d]" % size, "--photons", 1000000]
    page, picture = os.path.join(folder, scene + ".html"), os.path.join(folder, scene + ".pfm")
    tyndall("bake", path, *shared, *more, "-o", page)
    tyndall("render", path, *shared, "--samples", 16 if scene == "lonely_cloud" else 64, "-o", picture)
    with open(page, encoding="utf-8") as file:
        text = file.read()
    check(len(text) < 6e6, "%s: %.2f MB" % (scene, len(text) / 1e6))
    browser.resize(size)
    took = browser.open(text)
    check(browser.state() == "ready", "%s after %.1f s %s" % (browser.state(), took, browser.message()))
    gain = 2 ** float(re.search(r'"exposure":([-0-9.e]+)', text)[1])
    expected = {(x, y): tuple(encoded(gain * c) for c in color)
                for y, row in enumerate(read_pfm(picture)) for x, color in enumerate(row)}
    close = compare(browser.pixels(), expected)
    check(close[0] >= 0.95, "the renderer's own picture: r = %.4f, rms %.1f of 255" % close[:2])
    first = browser.pixels()
    for kind, x in (("mousePressed", 60), ("mouseMoved", 90), ("mouseReleased", 90)):
        browser.call("Input.dispatchMouseEvent", type=kind, x=x, y=60, button="left", buttons=1, clickCount=1)
    check(compare(browser.pixels(), {(x, y): c for y, row in enumerate(first) for x, c in enumerate(row)})[1] > 2,
          "it turns with the mouse")
    if screenshot:
        browser.resize((960, 720))
        browser.open(text)
        browser.screenshot(screenshot)
    check(not browser.console, "the console is silent" + "".join("\n        " + line for line in browser.console[:10]))


def main():
    if not CHROMIUM:
        print("SKIPPED: no chromium here")
        return 77
    with open(os.path.join(ROOT, "src/io/look/look.html"), encoding="utf-8") as file:
        template = file.read()
    check(template.count(MARK) == 1, "the template has one place for the data")
    check(not re.search(r"https?://|\bfetch\(|XMLHttpRequest|\bimport\b", template), "and nothing that it fetches")
    browser = Browser((160, 120))
    with tempfile.TemporaryDirectory() as folder:
        try:
            if len(sys.argv) > 1:
                run_baked(browser, sys.argv[1], folder, sys.argv[2])
            else:
                run_checks(browser, template)
                run_baked(browser, "lonely_cloud", folder)
                run_baked(browser, "full", folder, None, "--per-light")
        finally:
            browser.close()
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
