"""The picture of `powered-walker explore` in these pages: `python docs/screenshot.py`.

Needs Chromium (Debian's package `chromium`) and the extra `dev`.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

from PIL import Image
from playwright.sync_api import sync_playwright

TARGET = Path(__file__).parent / "pictures" / "explore.png"
SERVE = "from powered_walker_env.cli import main; exit(main())"
SIZE = {"width": 1400, "height": 800}
OPTIONS = ["--headless", "--no-sandbox", "--disable-gpu", "--no-first-run"]
DRAWN = """() => ["basin", "bifurcation diagram"].every((name) => {
    const panel = window.Bokeh?.documents[0]?.get_model_by_name(name)
    return panel && panel.title.text.includes(": ") && !panel.title.text.includes("computed")
})"""


def main() -> None:
    """Serve the page, push the walker, and keep what a visitor sees."""
    command = [sys.executable, "-c", SERVE, "explore", "--no-browser", "--preset", "round-foot"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as server:
        assert server.stderr is not None
        address = next(filter(None, (re.search(r"http://\S+", line) for line in server.stderr)))[0]
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(
                executable_path=shutil.which("chromium"), args=OPTIONS
            )
            page = browser.new_page(viewport=SIZE)
            page.goto(address)
            page.wait_for_function(DRAWN)
            for _ in range(2):
                page.keyboard.press("ArrowRight")
            page.wait_for_timeout(4500)
            TARGET.parent.mkdir(exist_ok=True)
            page.screenshot(path=TARGET)
            browser.close()
        server.terminate()
    Image.open(TARGET).convert("RGB").quantize(256).save(TARGET)  # a third of the bytes


if __name__ == "__main__":
    main()
