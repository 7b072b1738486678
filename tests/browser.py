# A headless Chromium that draws with the processor, for tests of pages.
# SPDX-License-Identifier: BSD-3-Clause
import importlib.util
import shutil
import tempfile
from pathlib import Path

FLAGS = ["--headless", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader",
         "--enable-unsafe-swiftshader", "--disable-quic",
         "--no-first-run", "--disable-background-networking", "--disable-component-update",
         "--disable-sync", "--hide-scrollbars"]


def missing():
    """What is not installed of all that is needed; nothing where all is there."""
    if not importlib.util.find_spec("selenium"):
        return "python3-selenium"
    return next((name for name in ("chromium", "chromedriver") if not shutil.which(name)), None)


class Browser:
    """`with Browser() as page:` gives a driver of selenium."""

    def __enter__(self):
        from selenium import webdriver
        from selenium.webdriver.chrome.service import Service
        options = webdriver.ChromeOptions()
        options.binary_location = shutil.which("chromium")
        self.profile = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        for flag in (*FLAGS, f"--user-data-dir={self.profile.name}"):
            options.add_argument(flag)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        self.driver = webdriver.Chrome(service=Service(shutil.which("chromedriver")),
                                       options=options)
        return self.driver

    def __exit__(self, *_):
        self.driver.quit()
        self.profile.cleanup()


def set_width(driver, width, height=900, scheme="light"):
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                           {"width": width, "height": height, "deviceScaleFactor": 1,
                            "mobile": False})
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia",
                           {"features": [{"name": "prefers-color-scheme", "value": scheme}]})


def open_report(driver, address):
    """Waits until the page's own script is through."""
    from selenium.webdriver.support.ui import WebDriverWait
    driver.get(Path(address).resolve().as_uri() if "://" not in str(address) else str(address))
    WebDriverWait(driver,
                  120).until(
                      lambda page: page.execute_script(
                          "return document.documentElement.dataset.ready"))


def errors(driver):
    return [one["message"] for one in driver.get_log("browser") if one["level"] == "SEVERE"]
