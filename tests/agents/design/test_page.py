"""The page in a browser: it loads, its inputs change the figures, and saving gives a level file."""

import re
import shutil
from contextlib import closing
from dataclasses import replace

import pytest

from agents.design import answers, level_files, session
from agents.pictures.door import open_front
from tests.agents.design.conftest import served

playwright = pytest.importorskip("playwright.sync_api")
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
ARGUMENTS = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader"]
PATIENCE = 60_000.0


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium is installed")
def test_an_engineer_moves_a_slider_and_saves_the_design(tmp_path, monkeypatch):
    monkeypatch.setattr(answers, "LAST", replace(answers.LAST, shifts=6))
    monkeypatch.setattr(session, "possible_changes", lambda line, item: [])
    front, complaints, foreign = open_front("127.0.0.1"), [], []
    with closing(served(front, "token", "single")) as made, playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        page = browser.new_page(viewport={"width": 900, "height": 600})
        page.on("console", lambda message: message.type == "error" and complaints.append(message.text))
        page.on("pageerror", lambda error: complaints.append(str(error)))
        own = (f"http://127.0.0.1:{front.getsockname()[1]}/", "data:", "blob:")
        page.on("request", lambda request: request.url.startswith(own) or foreign.append(request.url))
        page.goto(f"{own[0]}?token=token")
        shown = page.locator(".pg .big")
        playwright.expect(shown).to_have_text(re.compile(r"\d\d\.\d %"), timeout=PATIENCE)
        # Figures that are settled change with the design alone.
        playwright.expect(page.locator(".pg .chip")).to_have_text("settled", timeout=PATIENCE)
        before = shown.inner_text()
        # Half of the objects: one robot sorts far more of them.
        infeed = page.locator("xpath=//label[contains(., 'infeed')]/ancestor::div[.//input][1]//input[last()]").last
        infeed.fill("60")
        infeed.press("Enter")
        playwright.expect(shown).not_to_have_text(before, timeout=PATIENCE)
        assert made.session.state.line.arrivals.rate == 1.0
        assert float(shown.inner_text().split()[0]) > float(before.split()[0]) + 5.0
        # A refused change is told, and the design stays.
        made.session.change(lambda line: type(line).load(line, robots=[]))
        playwright.expect(page.locator(".pg .bad")).to_contain_text("robots", timeout=PATIENCE)
        page.get_by_role("tab", name="File").click()
        with page.expect_download(timeout=PATIENCE) as download:
            page.get_by_role("button", name="save as YAML").click()
        download.value.save_as(tmp_path / "saved.yaml")
        browser.close()
        saved = level_files.line_of_file((tmp_path / "saved.yaml").read_bytes(), "saved.yaml")
        assert saved == made.session.state.line
    assert not complaints
    assert not foreign
