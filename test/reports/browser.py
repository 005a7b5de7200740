# SPDX-License-Identifier: Apache-2.0
"""A headless browser that looks at pages, through its own driver."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.actions.action_builder import ActionBuilder
from selenium.webdriver.common.actions.interaction import POINTER_TOUCH
from selenium.webdriver.common.actions.pointer_input import PointerInput
from selenium.webdriver.common.by import By
from selenium.webdriver.remote.webelement import WebElement
from selenium.webdriver.support.wait import WebDriverWait

PATIENCE = 60.0
"""Seconds until a page must be ready, on a busy machine."""


class Screen(NamedTuple):
    """What a page is looked at on."""

    width: int
    height: int
    scheme: str


class Browser:
    """An open browser with one page in it."""

    def __init__(self, driver: webdriver.Chrome) -> None:
        self.driver = driver

    def open(self, path: Path, screen: Screen) -> None:
        """Open a file on a screen and wait until it says that it is ready."""
        self.driver.execute_cdp_cmd(
            "Emulation.setDeviceMetricsOverride",
            {
                "width": screen.width,
                "height": screen.height,
                "deviceScaleFactor": 1,
                "mobile": screen.width < 600,
            },
        )
        feature = {"name": "prefers-color-scheme", "value": screen.scheme}
        self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [feature]})
        self.driver.get(path.resolve().as_uri())
        WebDriverWait(self.driver, PATIENCE).until(
            lambda driver: driver.execute_script("return document.body.dataset.ready")
        )

    def value(self, expression: str) -> Any:
        """Return the value of a JavaScript expression."""
        return self.driver.execute_script(f"return {expression}")

    def find(self, selector: str) -> WebElement:
        """Return the one element of a CSS selector, scrolled into the middle of the window."""
        (found,) = self.driver.find_elements(By.CSS_SELECTOR, selector)
        self.driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", found)
        return found

    def drag(self, selector: str, begin: float, end: float) -> None:
        """Drag across an element, from one share of its width to another."""
        element = self.find(selector)
        width = element.size["width"]
        actions = ActionChains(self.driver)
        actions.move_to_element_with_offset(element, round((begin - 0.5) * width), 0)
        actions.click_and_hold()
        actions.move_by_offset(round((end - begin) * width), 0).release().perform()

    def point_at(self, selector: str, share: float) -> None:
        """Move the pointer to a share of an element's width, half way up."""
        element = self.find(selector)
        offset = round((share - 0.5) * element.size["width"])
        ActionChains(self.driver).move_to_element_with_offset(element, offset, 0).perform()

    def swipe(self, selector: str, begin: float, end: float) -> None:
        """Draw a finger across an element, from one share of its width to another."""
        element = self.find(selector)
        finger = PointerInput(POINTER_TOUCH, "finger")  # type: ignore[no-untyped-call]
        actions = ActionBuilder(self.driver, mouse=finger)
        from_middle = [round((share - 0.5) * element.size["width"]) for share in (begin, end)]
        hand: Any = actions.pointer_action
        hand.move_to(element, from_middle[0], 0).pointer_down()
        hand.move_to(element, from_middle[1], 0).pointer_up()
        actions.perform()

    def complaints(self) -> list[str]:
        """Return what the console has, warnings and errors."""
        entries: list[dict[str, Any]] = self.driver.get_log("browser")  # type: ignore[no-untyped-call]
        return [each["message"] for each in entries]


@contextmanager
def browser() -> Iterator[Browser]:
    """Context manager: a headless browser.

    A test fails where there is none: .ci/browser installs one.
    """
    program = next(filter(None, map(shutil.which, ("chromium", "google-chrome", "chrome"))), None)
    driver = shutil.which("chromedriver")
    if program is None or driver is None:
        pytest.fail("got no browser with a driver: .ci/browser installs chromium and chromedriver")
    options = webdriver.ChromeOptions()
    options.binary_location = program
    for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    opened = webdriver.Chrome(options=options, service=Service(driver))
    try:
        yield Browser(opened)
    finally:
        opened.quit()
