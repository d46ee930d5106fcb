"""README's pictures of a report: figures/report.png, the page as on paper, and figures/explorer.png, its sliders moved.

    tolmc run studies/paper_joint.toml --out joint && tolmc report joint
    tolmc run studies/paper_joint_allocation.toml --out offers && tolmc report offers
    python studies/report_pictures.py joint offers

Chromium draws them (Debian: apt-get install chromium), driven by Playwright (extra "test").
"""

import shutil
import sys
from pathlib import Path

from playwright.sync_api import Browser, sync_playwright

FIGURES = Path(__file__).parents[1] / "figures"
WIDTH = 1060


def draw_report(browser: Browser, run: Path) -> None:
    """The first screens of a report without scripts."""
    page = browser.new_page(viewport={"width": WIDTH, "height": 1250}, java_script_enabled=False)
    page.goto((run / "report.html").absolute().as_uri())
    page.screenshot(path=FIGURES / "report.png")


def draw_explorer(browser: Browser, run: Path) -> None:
    """The explorer with the first dimension's zone two fifths wider."""
    page = browser.new_page(viewport={"width": WIDTH, "height": 1000})
    page.goto((run / "report.html").absolute().as_uri())
    field = page.locator("#explorer fieldset input[type=number]").nth(1)
    field.fill(f"{1.4 * float(field.input_value()):.6g}")
    field.blur()
    page.wait_for_timeout(1000)  # the cost is drawn when nothing moves
    page.evaluate("scrollTo(0, 0)")
    box = page.locator("#explorer").bounding_box() or sys.exit(
        f"{run} has no explorer; make it with tolmc report {run}"
    )
    clip = {"x": 0, "y": box["y"] - 10, "width": WIDTH, "height": box["height"] + 20}
    page.screenshot(path=FIGURES / "explorer.png", clip=clip, full_page=True)


def main(report: Path, explorer: Path) -> None:
    chromium = shutil.which("chromium") or sys.exit("no chromium; apt-get install chromium")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        draw_report(browser, report)
        draw_explorer(browser, explorer)
        browser.close()


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:])) if len(sys.argv) == 3 else sys.exit(__doc__)
