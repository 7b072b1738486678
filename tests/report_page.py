# The page of a report in a real browser: it draws, answers keys and clicks, and fits a phone.
# SPDX-License-Identifier: BSD-3-Clause
"""report_page.py SPALL SOURCE, in a folder to write in. Ends with 77 where no browser is
installed."""
import subprocess
import sys
import time
import unittest
from pathlib import Path

import browser

if absent := browser.missing():
    print(f"skipped: {absent} is not installed (jobs/packages.sh installs it)")
    sys.exit(77)

from selenium.webdriver.common.action_chains import ActionChains  # noqa: E402
from selenium.webdriver.common.by import By  # noqa: E402
from selenium.webdriver.common.keys import Keys  # noqa: E402
from selenium.webdriver.support.ui import Select, WebDriverWait  # noqa: E402

SPALL, SOURCE = (Path(argument).resolve() for argument in (sys.argv.pop(1), sys.argv.pop(1)))
WORK = Path("report_in_browser")
INK = """const view = spall.views[0], gl = view.renderer.getContext();
view.render(1);  // at its whole resolution, which it may have given up before
const [w, h] = [gl.drawingBufferWidth, gl.drawingBufferHeight];
const pixels = new Uint8Array(4 * w * h);
gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
const colors = new Set(), words = new Uint32Array(pixels.buffer);
let drawn = 0;
for (const word of words) { colors.add(word); drawn += word !== words[0]; }
return [drawn / words.length, colors.size];"""


def make_run(name, *changes):
    """A small case, in a second, with its report."""
    subprocess.run([SPALL, "run", SOURCE / "cases/hello/case.toml", "--out", WORK / name,
                    "--overwrite", "--set",
                    "groups.cloud.packing.count=40", "groups.cloud.volume.radius=6",
                    "phases.aggregation.duration=1200",
                    *changes], check=True, stdout=subprocess.DEVNULL)
    return WORK / name


class Page(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.one, cls.two = make_run("one"), make_run("two", "contact.friction=0.1")
        for folders in ([cls.one], [cls.one, cls.two]):
            subprocess.run([SPALL, "report", *folders], check=True, stdout=subprocess.DEVNULL)
        cls.browser = browser.Browser()
        cls.driver = cls.browser.__enter__()

    @classmethod
    def tearDownClass(cls):
        cls.browser.__exit__()

    def open(self, page="report.html", width=1280, scheme="light"):
        browser.set_width(self.driver, width, scheme=scheme)
        browser.open_report(self.driver, self.one / page)

    def tearDown(self):
        self.assertEqual(browser.errors(self.driver), [])

    def find(self, name):
        return self.driver.find_element(By.CSS_SELECTOR, name)

    def run_script(self, text):
        return self.driver.execute_script(text)

    def keys(self, *keys):
        chain = ActionChains(self.driver)
        for key in keys:
            chain.send_keys(key)
        chain.perform()

    def test_bodies_are_drawn(self):
        self.open()
        drawn, colors = self.run_script(INK)
        self.assertTrue(0.05 < drawn < 0.8, drawn)
        self.assertGreater(colors, 100)  # shaded, not flat

    def test_nothing_is_fetched(self):
        self.open()
        names = self.run_script(
            "return performance.getEntriesByType('resource').map((one) => one.name.slice(0, 5))")
        self.assertEqual([name for name in names if name != "data:"], [])

    def test_every_control_has_a_name_and_is_reached_by_tab(self):
        self.open()
        wanted = self.driver.find_elements(By.CSS_SELECTOR,
                                           "#views :is(canvas, input, select, button), #plots "
                                           ":is(input, select, button)")
        wanted = [one for one in wanted if one.is_displayed()]
        self.assertGreater(len(wanted), 10)
        for one in wanted:
            self.assertTrue(one.accessible_name.strip(), one.get_attribute("outerHTML")[:80])
        reached = []
        for _ in range(len(wanted) + 5):
            self.keys(Keys.TAB)
            reached.append(self.driver.switch_to.active_element)
        # In the order of the page.
        self.assertEqual([one for one in reached if one in wanted], wanted)

    def test_arrow_keys_move_through_time(self):
        self.open()
        slider, instant = self.find(".slider"), self.find(".instant")
        self.assertIn("4 of 4", instant.text)
        self.assertIn("after the impact", slider.get_attribute("aria-valuetext"))
        slider.send_keys(Keys.ARROW_LEFT, Keys.ARROW_LEFT, Keys.ARROW_LEFT)
        self.assertIn("1 of 4", instant.text)
        # No impactor yet.
        self.assertEqual(self.run_script("return spall.views[0].spheres[4 * 40 + 3]"), 0)
        slider.send_keys(Keys.END)
        self.assertGreater(self.run_script("return spall.views[0].spheres[4 * 40 + 3]"), 0)

    def test_play_shows_all_instants_and_stops(self):
        self.open()
        self.find(".play").click()
        self.assertEqual(self.find(".play").accessible_name, "Pause")
        WebDriverWait(self.driver,
                      20).until(lambda _: self.find(".play").accessible_name == "Play through time")
        self.assertIn("4 of 4", self.find(".instant").text)

    def test_keys_turn_and_zoom_the_view(self):
        self.open()
        place = "return [...spall.views[0].camera.position.toArray(), spall.views[0].camera.zoom]"
        before = self.run_script(place)
        canvas = self.find("canvas")
        self.run_script("document.querySelector('canvas').focus()")
        self.keys(Keys.ARROW_LEFT)
        turned = self.run_script(place)
        self.assertGreater(abs(turned[0] - before[0]), 1)
        self.assertAlmostEqual(turned[2], before[2], places=6)  # around the vertical axis
        self.keys("+")
        self.assertGreater(self.run_script(place)[3], turned[3])
        self.assertTrue(canvas.accessible_name)

    def test_a_click_tells_of_the_body_that_is_seen_there(self):
        self.open()
        canvas = self.find("canvas")
        self.run_script("document.querySelector('canvas').scrollIntoView({block: 'center'})")
        ActionChains(self.driver).move_to_element(canvas).click().perform()
        text = self.find(".picked").text
        for word in ("group", "cloud", "material", "rock", "radius", "1 m", "speed"):
            self.assertIn(word, text)
        number = self.find(".body").get_attribute("value")
        self.assertIn(number, text)
        # It covers the middle of the picture, and none that clearly does is nearer.
        covering = self.run_script("""const view = spall.views[0];
            const e = view.camera.matrixWorldInverse.elements;
            const found = [];
            for (let k = 0; k < view.header.count; ++k) {
              const [x, y, z, r] = view.spheres.subarray(4 * k, 4 * k + 4);
              const at = [0, 1, 2].map((c) => e[c] * x + e[4 + c] * y + e[8 + c] * z + e[12 + c]);
              const apart = Math.hypot(at[0], at[1]) / r;
              if (apart < 1.1)
                found.push([k, apart, at[2] + r * Math.sqrt(Math.max(0, 1 - apart ** 2))]);
            }
            return found""")
        depth = {body: z for body, _, z in covering}
        self.assertIn(int(number), depth)
        self.assertTrue(all(z <= depth[int(number)] + 1e-6 for _, apart, z in covering
                            if apart < 0.9), (number, covering))
        box = self.find(".body")
        box.clear()
        box.send_keys("40")
        self.assertIn("impactor", self.find(".picked").text)

    def test_each_field_colours_the_bodies(self):
        self.open()
        field = Select(self.find(".field"))
        self.assertGreaterEqual(len(field.options), 7)
        for option in range(len(field.options)):
            field.select_by_index(option)
            drawn, colors = self.run_script(INK)
            self.assertGreater(drawn, 0.05, option)
        self.find(".log").click()
        field.select_by_visible_text("group")
        self.assertIn("impactor", self.find(".legend").text)

    def test_bodies_that_are_left_out_would_not_have_been_seen(self):
        self.open(width=640)
        pixels = """const view = spall.views[0], gl = view.renderer.getContext();
            view.render(1);
            const [w, h] = [gl.drawingBufferWidth, gl.drawingBufferHeight];
            const draw = () => { view.render(1); const p = new Uint8Array(4 * w * h);
              gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, p);
              return [view.geometry.drawRange.count, p]; };
            const choose = Object.getPrototypeOf(view).choose, all = () => {
              view.list.array.forEach((_, k, list) => { list[k] = k; });
              view.list.needsUpdate = true; view.geometry.setDrawRange(0, 3 * view.header.count); };
            let differ = 0, left = 0;
            for (let k = 0; k < 4; ++k) {
              view.turn(1.3, 0.1 * (k % 3 - 1));
              view.choose = choose; const [some, seen] = draw();
              view.choose = all; const [every, whole] = draw();
              left += (every - some) / 3;
              for (let b = 0; b < seen.length; ++b) differ += seen[b] !== whole[b];
            }
            return [left, differ]"""
        for cut in ("none", "across x", "facing the viewer"):
            Select(self.find(".cut")).select_by_visible_text(cut)
            left, differ = self.run_script(pixels)
            self.assertGreater(left, 0, cut)
            self.assertEqual(differ, 0, cut)

    def test_a_cut_takes_the_near_half_away(self):
        self.open()
        before, _ = self.run_script(INK)
        Select(self.find(".cut")).select_by_visible_text("across y")
        self.assertTrue(self.find(".level").is_displayed())
        self.assertLess(self.run_script(INK)[0], before)
        depth = """const view = spall.views[0]; view.render(1); let most = -Infinity;
            const box = view.canvas.getBoundingClientRect();
            for (let k = 1; k < 20; ++k) for (let m = 1; m < 20; ++m) {
              view.pickAt({ clientX: box.left + box.width * k / 20,
                            clientY: box.top + box.height * m / 20 });
              const at = 4 * view.picked;
              if (at >= 0) most = Math.max(most, -(view.spheres[at + 1] + view.spheres[at + 3]));
            }
            return most"""
        self.assertLess(self.run_script(depth), 1e-6)  # none lies wholly before the plane y = 0
        self.run_script(
            "const level = document.querySelector('.level'); level.value = -1; "
            "level.dispatchEvent(new Event('input'))")
        after, _ = self.run_script(INK)
        # The camera looks along y: a cut before the bodies takes little.
        self.assertGreater(after, 0.5 * before)

    def test_plots_zoom_together_by_keys(self):
        self.open()
        count, ranges = self.run_script(
            "return [spall.plots.plots.length, spall.plots.plots.map((one) => [one.scales.x.min, "
            "one.scales.x.max])]")
        self.assertGreaterEqual(count, 4)
        self.find("#plots .from").send_keys(*[Keys.PAGE_UP] * 3)
        zoomed = self.run_script(
            "return spall.plots.plots.map((one) => [one.scales.x.min, one.scales.x.max])")
        for (low, high), (low_now, high_now) in zip(ranges, zoomed):
            self.assertGreater(low_now, low)
            self.assertAlmostEqual(high_now, high)
        self.assertEqual(len({tuple(one) for one in zoomed}), 1)
        self.find("#plots .whole").click()
        self.assertEqual(
            self.run_script(
                "return spall.plots.plots.map((one) => [one.scales.x.min, one.scales.x.max])"),
            ranges)

    def test_it_fits_a_screen_and_a_phone_in_light_and_dark(self):
        for page in ("report.html", "compared.html"):
            for width in (1280, 390):
                for scheme in ("light", "dark"):
                    with self.subTest(page=page, width=width, scheme=scheme):
                        self.open(page, width, scheme)
                        self.assertLessEqual(
                            self.run_script("return document.documentElement.scrollWidth"), width)
                        drawn, _ = self.run_script(INK)
                        self.assertGreater(drawn, 0.02)
        self.assertEqual(len(self.driver.find_elements(By.TAG_NAME, "canvas"))
                         - self.run_script("return spall.plots.plots.length"), 2)

    def test_two_runs_turn_together(self):
        self.open("compared.html")
        self.run_script("spall.views[0].turn(0.3, 0.1)")
        places = self.run_script("return spall.views.map((view) => view.camera.position.toArray())")
        for a, b in zip(*places):
            self.assertAlmostEqual(a, b, places=6)

    def test_a_page_that_is_watched_keeps_itself_up_to_date(self):
        import shutil
        folder = WORK / "watched"
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(self.one, folder)
        late = [folder / "snapshots" / "000003.h5", folder / "results.toml"]
        for file in late:
            file.rename(file.with_name(file.name + ".later"))
        (folder / "lock").write_text("host 1\n")
        process = subprocess.Popen([SPALL, "watch", folder, "--port", "0"], stdout=subprocess.PIPE,
                                   text=True)
        try:
            browser.set_width(self.driver, 1280)
            browser.open_report(self.driver, process.stdout.readline().split()[0])
            wait = WebDriverWait(self.driver, 30)
            wait.until(lambda _: "of 3" in self.find(".instant").text)
            self.assertIn("Under way", self.find("#live").text)
            for file in late:
                file.with_name(file.name + ".later").rename(file)
            (folder / "lock").unlink()
            wait.until(lambda _: "4 of 4" in self.find(".instant").text)
            wait.until(lambda _: "has ended" in self.find("#summary").text)
            wait.until(lambda _: "is over" in self.find("#live").text)
        finally:
            process.kill()
            process.wait()
            process.stdout.close()
        time.sleep(0.1)


if __name__ == "__main__":
    WORK.mkdir(exist_ok=True)
    unittest.main(verbosity=2)
