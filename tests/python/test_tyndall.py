"""The Python package gives what the command line gives. Run by tests/python/run.sh."""
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy
import tyndall

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../..")
BINARY = os.environ.get("TYNDALL_BINARY", os.path.join(ROOT, "build/release/tyndall"))


def ball(n=24):
    x = (numpy.arange(n) + 0.5) / n * 2 - 1
    r = numpy.sqrt(x[:, None, None] ** 2 + x[None, :, None] ** 2 + x[None, None, :] ** 2)
    return numpy.clip(1 - r, 0, 1).astype(numpy.float32)


def scene(values):
    return {"tyndall": 1,
            "medium": {"components": [{"field": {"type": "grid", "values": values}, "extinction": 20, "albedo": 0.9}]},
            "lights": [{"type": "directional", "direction": [1, -1, 0.5], "irradiance": [3, 2, 1]},
                       {"type": "environment", "radiance": 0.25}],
            "camera": {"position": [0.5, 0.5, -2], "look_at": [0.5, 0.5, 0.5], "fov": 40, "resolution": [32, 24]},
            "photons": {"count": 40000, "illumination": {"resolution": 16}}, "gather": {"samples": 8}}


class Package(unittest.TestCase):
    def test_does_what_its_page_shows(self):
        with open(os.path.join(ROOT, "docs/python.md"), encoding="utf-8") as file:
            code = file.read().split("```python\n")[1].split("```")[0]
        shown = {}
        exec(code, shown)
        self.assertEqual(shown["result"].picture.shape, (240, 320, 4))
        self.assertEqual(shown["light"].fluence["directional_0"].shape[3], 3)

    def test_runs_its_example(self):
        with open(os.path.join(ROOT, "docs/example/puffs.py"), encoding="utf-8") as file:
            code = file.read()
        shown = {}
        exec(code, shown)
        means = [float(picture.mean()) for picture in shown["pictures"]]
        self.assertTrue(all(mean > 0.01 for mean in means), means)
        self.assertGreater(shown["sun"][shown["lit"] & shown["side"]].mean(),
                           shown["sun"][shown["lit"] & ~shown["side"]].mean())
        self.assertGreater(os.path.getsize("puffs.ppm"), 100000)

    def test_takes_what_scenes_are_made_of(self):
        with tempfile.TemporaryDirectory() as folder:
            ball().tofile(os.path.join(folder, "ball.raw"))
            written = scene(ball())
            written["medium"]["components"][0]["field"] = {
                "type": "grid", "file": pathlib.Path(folder) / "ball.raw", "size": numpy.array([24, 24, 24])}
            written["medium"]["sides"] = ("open", "open", "open")
            self.assertEqual(tyndall.render(written).tallies, tyndall.render(scene(ball())).tallies)
        with self.assertRaises(tyndall.Error) as caught:
            tyndall.validate({"tyndall": {1}})
        self.assertIn("a set: expected dicts", str(caught.exception))
        with self.assertRaises(tyndall.Error) as caught:
            tyndall.render(scene(ball()), {"camera.resolution": [65536, 65536]})
        self.assertEqual(caught.exception.code, 6)

    def test_has_the_hashes_of_the_command_line(self):
        values = ball()
        with tempfile.TemporaryDirectory() as folder:
            values.tofile(os.path.join(folder, "ball.raw"))
            written = scene(values)
            written["medium"]["components"][0]["field"] = {"type": "grid", "file": "ball.raw", "size": [24, 24, 24]}
            path = os.path.join(folder, "scene.json")
            with open(path, "w") as file:
                json.dump(written, file)
            said = subprocess.run([BINARY, "render", path, "--print-hash", "-o", os.path.join(folder, "x.pfm")],
                                  check=True, capture_output=True, text=True).stdout.split()
            from_file = tyndall.render(path, threads=1)
        from_array = tyndall.render(scene(values))
        for result in (from_file, from_array):
            self.assertEqual([result.tallies, result.pixels], [said[1], said[3]])

    def test_arrays_keep_their_size(self):
        values = ball()[:, :20, :16]  # [nz][ny][nx]
        wrong, right = scene(values), scene(values)
        right["medium"]["components"][0]["field"]["size"] = numpy.array([16, 20, 24])
        wrong["medium"]["components"][0]["field"]["size"] = (24, 20, 16)
        self.assertEqual(tyndall.render(right).tallies, tyndall.render(scene(values)).tallies)
        with self.assertRaises(tyndall.Error) as caught:
            tyndall.validate(wrong)
        self.assertEqual(caught.exception.code, 3)
        self.assertIn("scene.medium.components[0].field.size: [24, 20, 16] is not that of the array, [16, 20, 24]",
                      str(caught.exception))

    def test_masked_values_are_nothing(self):
        values = ball()
        mask = values < 0.5
        masked = numpy.ma.MaskedArray(values + 7 * mask, mask)
        self.assertEqual(tyndall.render(scene(masked)).tallies, tyndall.render(scene(values * ~mask)).tallies)

    def test_overrides_may_hold_arrays(self):
        field = {"type": "grid", "values": ball()}
        by_override = tyndall.render(scene(numpy.ones((2, 2, 2))), {"medium.components[0].field": field})
        self.assertEqual(by_override.tallies, tyndall.render(scene(ball())).tallies)

    def test_every_failure_is_an_error(self):
        def code(call):
            with self.assertRaises(tyndall.Error) as caught:
                call()
            return caught.exception.code
        good = scene(ball())
        for threads in (-1, 4097, 2 ** 70, "2", 1.5, None):
            self.assertEqual(code(lambda: tyndall.render(good, threads=threads)), 2, threads)
            self.assertEqual(code(lambda: tyndall.bake(good, threads=threads)), 2, threads)
        self.assertEqual(code(lambda: tyndall.render(good, device=0)), 2)
        self.assertEqual(code(lambda: tyndall.render(good, progress="yes")), 2)
        self.assertEqual(code(lambda: tyndall.render(good, [("camera.fov", 30)])), 2)
        self.assertEqual(code(lambda: tyndall.bake(good, order=2)), 2)
        self.assertEqual(code(lambda: tyndall.validate(7)), 2)
        self.assertEqual(code(lambda: tyndall.validate("a\0b")), 3)
        self.assertEqual(code(lambda: tyndall.validate({"tyndall": 1, (1, 2): 3})), 3)
        self.assertEqual(code(lambda: tyndall.validate(scene(ball() * 1j))), 3)
        self.assertEqual(code(lambda: tyndall.validate(scene(numpy.array([[["a"]]])))), 3)
        round_and_round = scene(ball())
        round_and_round["lights"].append(round_and_round)
        self.assertEqual(code(lambda: tyndall.validate(round_and_round)), 3)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "wide.json")
            with open(path, "w", encoding="utf-16") as file:
                file.write('{"tyndall": 1}')
            self.assertEqual(code(lambda: tyndall.validate(path)), 3)
            self.assertEqual(code(lambda: tyndall.validate(folder)), 4)

    def test_names_need_not_be_utf_8(self):
        with tempfile.TemporaryDirectory() as folder:
            inner = os.path.join(os.fsencode(folder), b"caf\xe9")
            os.mkdir(inner)
            ball().tofile(os.path.join(inner, b"ball.raw"))
            written = scene(ball())
            written["medium"]["components"][0]["field"] = {"type": "grid", "file": "ball.raw", "size": [24, 24, 24]}
            path = os.path.join(inner, b"caf\xe9.json")
            with open(path, "w") as file:
                json.dump(written, file)
            right = tyndall.render(scene(ball())).tallies
            self.assertEqual(tyndall.render(path).tallies, right)
            self.assertEqual(tyndall.render(os.fsdecode(path)).tallies, right)
            self.assertEqual(tyndall.bake(path).low, tyndall.bake(scene(ball())).low)
            written["medium"]["components"][0]["extinction"] = 0
            with open(os.path.join(inner, b"dark.json"), "w") as file:
                json.dump(written, file)
            said = tyndall.validate(os.path.join(inner, b"dark.json"))
            self.assertEqual(said[0][:len(os.fsdecode(inner))], os.fsdecode(inner))
            written["medium"]["components"][0]["extinction"] = 20
            with self.assertRaises(tyndall.Error) as caught:
                tyndall.validate(path, {"medium.components[0].field.file": "no.raw"})
            self.assertEqual(caught.exception.code, 4)
            with self.assertRaises(tyndall.Error) as caught:
                tyndall.validate(path + b".no")
            self.assertEqual(str(caught.exception), os.fsdecode(path) + ".no: No such file or directory")
            before = os.getcwd()
            os.chdir(inner)
            try:
                self.assertEqual(tyndall.render(written).tallies, right)
            finally:
                os.chdir(before)

    def test_texts_that_are_none_are_named(self):
        for call, name in ((lambda: tyndall.render(scene(ball()), device="\ud800"), "device: "),
                           (lambda: tyndall.bake(scene(ball()), device="\ud800"), "device: "),
                           (lambda: tyndall.validate(scene(ball()), {"film.filter": "\ud800"}),
                            "overrides['film.filter']: "),
                           (lambda: tyndall.validate("\ud800.json"), "scene: ")):
            with self.assertRaises(tyndall.Error) as caught:
                call()
            self.assertEqual(caught.exception.code, 2)
            self.assertEqual(str(caught.exception)[:len(name)], name)
        for call in (lambda: tyndall.validate(scene(ball()), {"film.filter": "\udce9"}),
                     lambda: tyndall.render(scene(ball()), device="\udce9"),
                     lambda: tyndall.validate(scene(ball()), {"medium.components[0].field.file": "\udce9.raw"}),
                     lambda: tyndall.validate({"\ud800": 1})):
            with self.assertRaises(tyndall.Error):
                call()

    def test_lack_of_memory_is_an_error(self):
        huge = numpy.broadcast_to(numpy.float64(1), (100000, 100000, 100000))
        with self.assertRaises(tyndall.Error) as caught:
            tyndall.validate(scene(huge))
        self.assertEqual(caught.exception.code, 6)
        # From the last pass on, so many megabytes are left.
        script = """
import re, resource, sys, numpy, tyndall
def progress(name, share):
    if (name, share) == ("pixels", 1.0):
        size = int(re.search(r"VmSize:\\s*(\\d+)", open("/proc/self/status").read())[1]) * 1024
        resource.setrlimit(resource.RLIMIT_AS, (size + int(sys.argv[1]) * 2 ** 20, resource.RLIM_INFINITY))
try:
    tyndall.render({"tyndall": 1, "medium": {"components": [{"field": {"type": "sphere"}, "extinction": 1}]},
                    "lights": [{"type": "environment", "radiance": 1}],
                    "camera": {"position": [0, 0, -50], "look_at": [0.5, 0.5, 0.5], "resolution": [1000, 1000]},
                    "photons": {"count": 100, "illumination": {"resolution": 2}}, "gather": {"samples": 1}},
                   progress=progress, threads=1)
    print("done")
except tyndall.Error as error:
    print("Error", error.code)
"""
        said = [subprocess.run([sys.executable, "-c", script, str(megabytes)], capture_output=True, text=True)
                for megabytes in (1, 20, 40, 60, 80, 100, 120, 160, 4000)]
        self.assertEqual({run.stdout for run in said}, {"Error 6\n", "done\n"}, [run.stderr[-200:] for run in said])

    def test_axes_of_arrays(self):
        values = numpy.zeros((4, 6, 8), numpy.float32)
        values[3, :, :] = 1  # [nz][ny][nx]: a layer at the far end of z
        light = tyndall.bake(scene(values), {"photons.illumination.resolution": 8})
        where = numpy.argwhere(light.albedo[..., 0] > 0)
        self.assertGreaterEqual(where[:, 0].min(), 3)
        self.assertEqual(where[:, 2].min(), 0)

    def test_pictures_and_layers(self):
        result = tyndall.render(scene(ball()))
        self.assertEqual(result.picture.shape, (24, 32, 4))
        self.assertEqual(result.picture.dtype, numpy.float32)
        self.assertEqual(result.layers["variance"].shape[:2], (24, 32))
        self.assertGreater(result.picture[12, 16, 3], 0.9)
        self.assertAlmostEqual(float(result.picture[0, 0, 0]), 0.25, places=5)
        self.assertEqual(result.facts["tyndall.ledger.count.shot"], "40000")

    def test_baked_lights_add_up(self):
        together, apart = tyndall.bake(scene(ball())), tyndall.bake(scene(ball()), per_light=True, order=0)
        self.assertEqual(set(apart.fluence), {"directional_0", "environment_1"})
        self.assertEqual(apart.slope, {})
        numpy.testing.assert_allclose(sum(apart.fluence.values()), together.fluence["all"], rtol=1e-4, atol=1e-5)
        self.assertEqual(together.relative_error.shape, (16, 16, 16))
        rest = tyndall.bake(scene(ball()), multiple_only=True)
        self.assertLess(rest.fluence["all"].sum(), 0.9 * together.fluence["all"].sum())
        self.assertGreater(rest.fluence["all"].sum(), 0)

    def test_errors_are_those_of_the_command_line(self):
        wrong = scene(ball())
        wrong["camera"]["fov"] = 900
        with self.assertRaises(tyndall.Error) as caught:
            tyndall.validate(wrong)
        self.assertEqual(caught.exception.code, 3)
        self.assertIn("camera.fov: expected degrees in (0, 180), got 900", str(caught.exception))
        with self.assertRaises(tyndall.Error) as caught:
            tyndall.render("nothing.json")
        self.assertEqual(caught.exception.code, 4)
        with self.assertRaises(tyndall.Error):
            tyndall.render(scene(numpy.zeros((4, 4))))
        with self.assertRaises(tyndall.Error) as caught:
            tyndall.render(scene(ball()), device="cuda:99")
        self.assertEqual(caught.exception.code, 7)

    def test_progress_can_stop(self):
        seen = []
        tyndall.render(scene(ball()), progress=lambda name, share: seen.append((name, share)))
        self.assertEqual(seen[-1], ("pixels", 1.0))
        with self.assertRaises(KeyboardInterrupt):
            tyndall.render(scene(ball()), {"photons.count": 10 ** 10}, progress=lambda name, share: name != "photons")
        for said in (0, "", [], numpy.bool_(False), 0.0):
            with self.assertRaises(KeyboardInterrupt):
                tyndall.render(scene(ball()), {"photons.count": 10 ** 10}, progress=lambda name, share: said)
        with self.assertRaises(ZeroDivisionError):
            tyndall.render(scene(ball()), progress=lambda name, share: 1 / 0)


if __name__ == "__main__":
    unittest.main()
