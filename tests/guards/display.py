"""`render --display` uses the protocol of the viewer tev: the picture arrives byte for byte as tevclient sends it; a viewer
that hangs, exits or does not exist does not disturb the render."""
import array
import os
import pathlib
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time

# Packets of tevclient 1.0.4 (PyPI): packet.create_image("lonely_cloud.json", 60, 40, ["R", "G", "B", "A"], True), and
# packet.update_image("lonely_cloud.json", pixels, ["R", "G", "B", "A"], 0, 0, False) before the pixels.
CREATE = bytes.fromhex("2c00000004016c6f6e656c795f636c6f75642e6a736f6e003c00000028000000040000005200470042004100")
UPDATE = bytes.fromhex(
    "7496000006006c6f6e656c795f636c6f75642e6a736f6e0004000000520047004200410000000000000000003c00000028000000000000000000"
    "0000010000000000000002000000000000000300000000000000040000000000000004000000000000000400000000000000040000000000"
    "0000")

root = pathlib.Path(__file__).resolve().parents[2]
program = os.environ.get("TYNDALL_BINARY", root / "build/release/tyndall")
faults = 0


def check(good, what):
    global faults
    faults += not good
    print("ok    " if good else "FAILED", what)


def render(folder, port, *more):
    return subprocess.Popen(
        [program, "render", root / "scenes/lonely_cloud.json", "-D", "camera.resolution=[60,40]", "-o", "x.pfm",
         "-D", "photons.count=20000", "-D", "gather.samples=64", "--display", f"localhost:{port}", *more],
        cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)


def listen():
    server = socket.socket()
    server.bind(("localhost", 0))
    server.listen()
    server.settimeout(60)
    return server, server.getsockname()[1]


def packets(connection):
    data = b""
    while block := connection.recv(1 << 16):
        data += block
        while len(data) >= 4 and len(data) >= (size := struct.unpack("<I", data[:4])[0]):
            yield data[:size]
            data = data[size:]
    check(not data, "nothing is left of half a packet")


def texts(data, at, count):
    out = []
    for _ in range(count):
        end = data.index(b"\0", at)
        out.append(data[at:end].decode())
        at = end + 1
    return out, at


with tempfile.TemporaryDirectory() as folder:
    server, port = listen()
    process = render(folder, port)
    got = list(packets(server.accept()[0]))
    check(process.wait() == 0, "the render ends with 0")
    create, *updates = got
    (name,), at = texts(create, 6, 1)
    width, height, channels = struct.unpack_from("<iii", create, at)
    names, at = texts(create, at + 12, channels)
    check((create[4], create[5], name, width, height, names, at)
          == (4, 1, "lonely_cloud.json", 60, 40, ["R", "G", "B", "A"], len(create)), "an image is made")
    last = updates[-1]
    (name,), at = texts(last, 6, 1)
    channels, = struct.unpack_from("<i", last, at)
    names, at = texts(last, at + 4, channels)
    window = struct.unpack_from("<4i", last, at)
    offsets = struct.unpack_from("<4q", last, at + 16)
    strides = struct.unpack_from("<4q", last, at + 48)
    values = array.array("f", last[at + 80:])
    check((last[4], name, window, offsets, strides) == (6, "lonely_cloud.json", (0, 0, 60, 40), (0, 1, 2, 3), (4,) * 4)
          and len(values) == 60 * 40 * 4, f"and filled, {len(updates)} times")
    picture = array.array("f", pathlib.Path(folder, "x.pfm").read_bytes()[-60 * 40 * 12:])
    same = all(values[4 * (y * 60 + x) + c] == picture[3 * ((39 - y) * 60 + x) + c]
               for y in range(40) for x in range(60) for c in range(3))
    check(same, "with the picture that was written")
    check(create == CREATE, "tevclient's packet that makes an image is the same")
    check(last[:len(UPDATE)] == UPDATE and len(last) == len(UPDATE) + 60 * 40 * 16,
          "tevclient's packet that fills it begins alike")

    process = render(folder, 1)  # no viewer listens there
    error = process.communicate()[1]
    check(process.returncode == 0 and "the render goes on without it" in error, "without a viewer: a warning")

    server, port = listen()
    start = time.monotonic()
    process = render(folder, port, "-D", "camera.resolution=[1200,800]", "--samples", "2")
    hanging = server.accept()[0]  # never reads
    process.communicate()
    check(process.returncode == 0, f"a viewer that hangs: the render ends ({time.monotonic() - start:.1f} s)")
    hanging.close()

    server, port = listen()
    process = render(folder, port, "--photons", "2000000")
    threading.Thread(target=lambda: server.accept()[0].close()).start()
    process.communicate()
    check(process.returncode == 0, "a viewer that is closed: the render ends")

sys.exit(faults > 0)
