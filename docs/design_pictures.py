"""Pictures of the design page, for the site: `make design-pictures`, which needs Chromium."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Callable
from contextlib import closing
from io import BytesIO
from pathlib import Path
from typing import Any, Final

from PIL import Image
from playwright.sync_api import sync_playwright

ROOT: Final = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from agents.design.page import Page  # noqa: E402
from agents.ground.files import replace_file  # noqa: E402
from agents.pictures.door import LOOPBACK, open_front  # noqa: E402
from pnt_gym.cells.line.config import LineConfig  # noqa: E402

FOLDER: Final = ROOT / "docs" / "pictures"
SIZE: Final = {"width": 1400, "height": 900}
QUALITY: Final = 80
PATIENCE: Final = 240_000.0
"""Time for a browser that draws without a graphics card [ms]."""
ARGUMENTS: Final = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader"]
NOTICE: Final = "Software WebGL rendering detected"
"""What viser says of such a browser."""


def wait_for_changes(page: Any) -> None:
    """Wait until everything that is worth trying has been tried."""
    page.get_by_text("settled", exact=True).wait_for(timeout=PATIENCE)
    page.wait_for_function("!document.body.innerText.includes('trying ')", timeout=PATIENCE)


def first(page: Any) -> None:
    """The page as it opens."""
    wait_for_changes(page)


def better(page: Any) -> None:
    """The line after the first offer was taken, with the gain over the kept design."""
    page.locator("button", has_text="+").first.click()
    page.wait_for_timeout(1000)
    wait_for_changes(page)
    page.get_by_text("Against the kept design").wait_for(timeout=PATIENCE)


def above(page: Any) -> None:
    """The line from above."""
    page.get_by_text("from above", exact=True).click()
    page.get_by_role("tab", name="Bins").click()
    page.wait_for_timeout(3000)


def take(page: Any, name: str, act: Callable[[Any], None]) -> None:
    """Act on the page, and write what it shows as a picture."""
    act(page)
    page.wait_for_timeout(2000)
    for notice in page.get_by_text(NOTICE).all():
        notice.locator("xpath=ancestor::div[.//button][1]//button").first.click()
    page.wait_for_timeout(1500)
    shot, buffer = Image.open(BytesIO(page.screenshot(timeout=PATIENCE))), BytesIO()
    shot.convert("RGB").save(buffer, "WEBP", quality=QUALITY, method=6)
    replace_file(FOLDER / name, lambda path: path.write_bytes(buffer.getvalue()))
    print(f"{name}: {len(buffer.getvalue()) // 1000} kB")


def main() -> None:
    """Open the page, and take its pictures."""
    chromium = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if chromium is None:
        print("no Chromium is installed; the pictures of the design page stay as they are")
        return
    front = open_front(LOOPBACK)
    with closing(Page(LineConfig.load("skills3"), front, "token")), sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=chromium, args=ARGUMENTS)
        page = browser.new_page(viewport=SIZE)
        page.goto(f"http://{LOOPBACK}:{front.getsockname()[1]}/?token=token")
        for name, act in (("design.webp", first), ("design_better.webp", better), ("design_above.webp", above)):
            take(page, name, act)
        browser.close()


if __name__ == "__main__":
    main()
